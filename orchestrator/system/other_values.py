"""The same system with other values of parameters, of which only the new ones are checked: for one run of many."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from components.interfaces.problem import Problem, did_you_mean, raise_if_any
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System
from orchestrator.system.unit_problems import value_problems


def with_values(system: System, values: Mapping[str, Any]) -> System:
    """The system with other values of some parameters.

    Args:
        system: The system.
        values: Values by full path, such as `plant.m`.

    Raises:
        RequestError: There is no such parameter, it takes no such value, or the lengths of arrays depend on it.
    """
    by_unit: dict[str, dict[str, Any]] = {}
    for path, value in values.items():
        unit, _, name = path.partition(".")
        by_unit.setdefault(unit, {})[name] = value
    raise_if_any(_problems(system, by_unit))
    if not values:
        return system
    units: dict[str, UnitSource] = dict(system.units)
    for unit, given in by_unit.items():
        units[unit] = units[unit].with_parameters({**units[unit].parameters, **given})
    changed = copy.copy(system)  # with what it has found out about its connections, on which no parameter acts
    object.__setattr__(changed, "units", units)
    return changed


def _problems(system: System, by_unit: Mapping[str, Mapping[str, Any]]) -> Iterator[Problem]:
    for unit, given in by_unit.items():
        if unit not in system.units or "" in given:
            known = [f"{name}.{v.name}" for name, s in system.units.items() for v in s.interface.parameters]
            for path in (f"{unit}.{name}" if name else unit for name in given):
                valid = "the path of a parameter, with its unit"
                yield Problem(path, "a parameter of no unit", valid, did_you_mean(path, known))
            continue
        source = system.units[unit]
        yield from value_problems(unit, source, given)
        for name in source.structural:
            present = source.parameters.get(name, source.interface.starts.get(name))
            if name in given and not np.array_equal(given[name], present):
                found = "another value of a parameter that the lengths of arrays depend on"
                yield Problem(f"{unit}.{name}", found, f"{present}", "Make another System with it.")
