"""The processes of units, as a person requests them: `--isolate plant`, `--isolate plant:5`, `--in-process`.

FMUs that were built here and blocks run in this process, other FMUs in processes of their own, if nothing is requested.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from fmus.toolchain.limits import PATIENCE
from orchestrator.system.source import UnitSource


def isolated(
    units: Mapping[str, UnitSource], requests: Sequence[str], *, in_process: bool | Sequence[str] = ()
) -> dict[str, UnitSource]:
    """Give units the processes that are requested for them.

    This happens before the system is made, because some FMUs can fill two units of a system only in this way.

    Args:
        units: The sources of all units.
        requests: The names of units that get processes of their own, each optionally with the time [s] that one call
            may take: `UNIT:SECONDS`. They count more than `in_process`.
        in_process: The names of units that run in this process, or whether all others do.

    Returns:
        The sources of all units.

    Raises:
        RequestError: A unit is unknown or is not an FMU, or a time is not positive.
    """
    here = (list(units) if in_process else []) if isinstance(in_process, bool) else in_process
    problems = [p for name in here for p in _unknown(units, name, "--in-process")]
    sources = {name: source.in_this_process() if name in here else source for name, source in units.items()}
    for request in requests:
        name, _, seconds = request.partition(":")
        where = f"--isolate {request}"
        patience = _number(seconds) if seconds else PATIENCE
        source = units.get(name)
        if source is None:
            problems += _unknown(units, name, where)
        elif not patience > 0:
            problems.append(Problem(where, f"`{seconds}`", "a positive number of seconds"))
        elif (isolated_source := source.in_own_process(patience)) is not None:
            sources[name] = isolated_source
        else:
            problems.append(Problem(where, f"`{name}`, a block in this process", "an FMU", "Leave out --blocks."))
    raise_if_any(problems)
    return sources


def _unknown(units: Mapping[str, UnitSource], name: str, where: str) -> Iterator[Problem]:
    if name not in units:
        yield Problem(where, f"the unknown unit `{name}`", choices(units), did_you_mean(name, units))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
