"""What a person says on the command line about values and recording, as `--set` and `--record`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from typing import Any

from components.interfaces.problem import Problem, choices, raise_if_any
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.resolution import Setting

_SETTING = re.compile(r"(?P<unit>\w+)\.(?P<name>[\w.]+)(?:\[(?P<index>\d+)\])?=(?P<value>.+)")


def parse_settings(texts: Sequence[str], *, any_unit: bool = False) -> dict[str, list[Setting]]:
    """Read `controller.b_3=1e-2` and the like.

    Args:
        texts: What was given as `--set`.
        any_unit: Whether a unit may have any name; otherwise it is a socket's, or `scene`.

    Returns:
        The settings by unit.

    Raises:
        RequestError: With everything that has another form.
    """
    known = () if any_unit else (*SOCKETS, "scene")
    found: dict[str, list[Setting]] = {unit: [] for unit in known}
    problems: list[Problem] = []
    for text in texts:
        match = _SETTING.fullmatch(text)
        if match is None:
            problems.append(
                Problem(f"--set {text}", "text of another form", "UNIT.PARAMETER=VALUE", "Try controller.b_3=1e-2.")
            )
        elif not any_unit and match["unit"] not in found:
            problems.append(Problem(f"--set {text}", f"the unknown unit `{match['unit']}`", choices(found)))
        else:
            index = None if match["index"] is None else int(match["index"])
            setting = Setting(match["unit"], match["name"], index, _literal(match["value"]))
            found.setdefault(match["unit"], []).append(setting)
    raise_if_any(problems)
    return found


_RECORD = "PATTERN or PATTERN:N, N a whole number of ticks"


def parse_record(texts: Sequence[str]) -> dict[str, int]:
    """`plant.*` for every tick, `controller.plan.*:10` for every tenth; later ones win. Raises `RequestError`."""
    found: dict[str, int] = {}
    problems: list[Problem] = []
    for text in texts:
        pattern, colon, every = text.rpartition(":")
        if not colon:
            found[text] = 1
        elif pattern and every.isdecimal():
            found[pattern] = int(every)
        else:
            problems.append(Problem(f"--record {text}", "text of another form", _RECORD, "Try plant.*:10."))
    raise_if_any(problems)
    return found


def _literal(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text  # the check of the parameter says what it should have been
