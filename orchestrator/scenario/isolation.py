"""Units in processes of their own, as a person requests them: `--isolate plant`, `--isolate plant:5`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.system.source import UnitSource


def isolated(units: Mapping[str, UnitSource], requests: Sequence[str]) -> dict[str, UnitSource]:
    """Give some units processes of their own.

    This happens before the system is made, because some FMUs can fill two units of a system only in this way.

    Args:
        units: The sources of all units.
        requests: The names of units, each optionally with the time [s] that one call may take: `UNIT:SECONDS`.

    Returns:
        The sources of all units.

    Raises:
        RequestError: A unit is unknown or is not an FMU, or a time is not positive.
    """
    sources = dict(units)
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
            sources[name] = isolated_source
        else:
            problems.append(Problem(where, f"`{name}`, a block in this process", "an FMU", "Leave out --blocks."))
    raise_if_any(problems)
    return sources


def _patience() -> float:
    from fmus.units.isolated_unit import PATIENCE  # noqa: PLC0415 - slow to import, and few runs need it

    return PATIENCE


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
