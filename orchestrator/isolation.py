"""Units in processes of their own, as a person asks for them: `--isolate plant`, `--isolate plant:5`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from fmus.isolated_unit import PATIENCE
from orchestrator.mapping.mapped import Mapped
from orchestrator.scenario import Scenario
from orchestrator.system import Fmu, Source


def isolated(scenario: Scenario, requests: Sequence[str]) -> Scenario:
    """The scenario with the units that `requests` name in processes of their own. Raises `RequestError`.

    `UNIT:SECONDS` also says how long one call may take.
    """
    units = dict(scenario.system.units)
    problems: list[Problem] = []
    for request in requests:
        name, _, seconds = request.partition(":")
        where = f"--isolate {request}"
        patience = _number(seconds) if seconds else PATIENCE
        source = units.get(name)
        if source is None:
            problems.append(Problem(where, f"the unknown unit `{name}`", choices(units), did_you_mean(name, units)))
        elif not patience > 0:
            problems.append(Problem(where, f"`{seconds}`", "a positive number of seconds"))
        elif isinstance(source, Fmu | Mapped):
            units[name] = _apart(source, patience)
        else:
            problems.append(Problem(where, f"`{name}`, a block in this process", "an FMU", "Leave out --blocks."))
    raise_if_any(problems)
    return replace(scenario, system=replace(scenario.system, units=units)) if requests else scenario


def _apart(source: Fmu | Mapped, patience: float) -> Source:
    if isinstance(source, Mapped):
        inner = _apart(source.fmu, patience)
        return replace(source, fmu=inner) if isinstance(inner, Fmu) else source
    made = replace(source, isolated=patience)
    vars(made)["archive"] = source.archive  # read once is enough
    return made


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
