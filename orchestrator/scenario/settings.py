"""The options `--set` and `--record` of the command line, read from their texts."""

from __future__ import annotations

import re
from collections.abc import Sequence

from components.interfaces.problem import Problem, choices, raise_if_any
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.resolution import Setting
from orchestrator.scenario.values_file import expanded

_SETTING = re.compile(r"(?P<unit>[^.=]+)\.(?P<assignment>.+?=.*)", re.DOTALL)


def parse_settings(
    texts: Sequence[str], problems: list[Problem] | None = None, *, any_unit: bool = False
) -> dict[str, list[Setting]]:
    """Read `controller.b_3=1e-2` and the like.

    Args:
        texts: The values of the option `--set`; `@FILE` stands for a file with one of them on each line.
        problems: Takes what is wrong with single texts, so that the others can be looked at; raised if not given.
        any_unit: Whether units may have any name, not only that of a socket or `scene`.

    Returns:
        The settings by unit.

    Raises:
        RequestError: A text has another form, or a unit is unknown; the error lists all of them. A file that a text
            names cannot be read.
    """
    wrong: list[Problem] = [] if problems is None else problems
    known = () if any_unit else (*SOCKETS, "scene")
    settings: dict[str, list[Setting]] = {unit: [] for unit in known}
    for text in expanded(texts):
        match = _SETTING.fullmatch(text)
        if match is None:
            wrong.append(
                Problem(f"--set {text}", "text of another form", "UNIT.PARAMETER=VALUE", "Try controller.b_3=1e-2.")
            )
        elif not any_unit and match["unit"] not in settings:
            wrong.append(Problem(f"--set {text}", f"the unknown unit `{match['unit']}`", choices(settings)))
        else:
            settings.setdefault(match["unit"], []).append(Setting(match["unit"], match["assignment"]))
    if problems is None:
        raise_if_any(wrong)
    return settings


_TICKS = re.compile(r"[0-9]{1,18}")
_RECORD = "PATTERN or PATTERN:N, N a whole number of ticks"


def parse_record(texts: Sequence[str]) -> dict[str, int]:
    """Read `plant.*` (every tick), `controller.plan.*:10` (every tenth tick) and the like.

    Args:
        texts: The values of the option `--record`.

    Returns:
        At every how many ticks the signals that match a pattern are recorded, by pattern.

    Raises:
        RequestError: A text has another form; the error lists all of them.
    """
    choice: dict[str, int] = {}
    problems: list[Problem] = []
    for text in texts:
        pattern, colon, every = text.rpartition(":")
        if not colon:
            choice[text] = 1
        elif pattern and _TICKS.fullmatch(every):
            choice[pattern] = int(every)
        else:
            problems.append(Problem(f"--record {text}", "text of another form", _RECORD, "Try plant.*:10."))
    raise_if_any(problems)
    return choice
