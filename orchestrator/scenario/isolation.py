"""Units in processes of their own, as a person asks for them: `--isolate plant`, `--isolate plant:5`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.system.source import UnitSource


def isolated(units: Mapping[str, UnitSource], requests: Sequence[str]) -> dict[str, UnitSource]:
    """The units, those that `requests` name in processes of their own. Raises `RequestError`.

    `UNIT:SECONDS` also says how long one call may take. They are given before the system is made: some FMUs can be
    used twice only like this.
    """
    found = dict(units)
    problems: list[Problem] = []
    for request in requests:
        name, _, seconds = request.partition(":")
        where = f"--isolate {request}"
        patience = _number(seconds) if seconds else _patience()
        source = units.get(name)
        if source is None:
            problems.append(Problem(where, f"the unknown unit `{name}`", choices(units), did_you_mean(name, units)))
        elif not patience > 0:
            problems.append(Problem(where, f"`{seconds}`", "a positive number of seconds"))
        elif (isolated_source := source.in_own_process(patience)) is not None:
            found[name] = isolated_source
        else:
            problems.append(Problem(where, f"`{name}`, a block in this process", "an FMU", "Leave out --blocks."))
    raise_if_any(problems)
    return found


def _patience() -> float:
    from fmus.units.isolated_unit import PATIENCE  # noqa: PLC0415 - only who asks for it needs it

    return PATIENCE


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
