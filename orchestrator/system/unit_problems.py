"""What is wrong with the units of a system, with their steps, and with the values that they are given."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

from components.interfaces.problem import Problem, choices, did_you_mean
from orchestrator.system.patterns import fits
from orchestrator.system.source import UnitSource

Units: TypeAlias = Mapping[str, UnitSource]
"""The units of a system, by name."""


def instance_problems(units: Units) -> Iterator[Problem]:
    """The problems of units that are made from one FMU, of which a process can hold only one instance."""
    once: dict[Path, str] = {}
    for name, source in units.items():
        if (file := source.single_instance()) is not None:
            other = once.setdefault(file.resolve(), name)
            if other != name:
                found = f"{file}, which `{other}` runs too"
                valid = "an FMU that can be instantiated more than once per process"
                yield Problem(f"unit `{name}`", found, valid, "Run one of them in a process of its own.")


def pattern_problems(units: Units, patterns: Iterable[str]) -> Iterator[Problem]:
    """The problems of patterns that no output fits."""
    paths = [
        f"{name}.{path}"
        for name, source in units.items()
        for v in source.interface.outputs
        for path in (v.name, *v.elements)
    ]
    for pattern in patterns:
        if pattern != "*" and not any(fits(path, pattern) for path in paths):
            where = f"allow_nonfinite {pattern}"
            yield Problem(where, "a pattern that no output fits", choices({*paths}), did_you_mean(pattern, paths))


def step_problems(units: Units, steps: Mapping[str, Fraction]) -> Iterator[Problem]:
    """The problems of steps of units, in macro steps, that no schedule can take."""
    for name, ratio in steps.items():
        if name not in units:
            yield Problem(f"step of `{name}`", "an unknown unit", choices(units))
        elif ratio <= 0 or 1 not in (ratio.numerator, ratio.denominator):
            valid = "a whole multiple of the macro step, or a whole part of it"
            yield Problem(f"step of `{name}`", f"{ratio} macro steps", valid)


def held_problems(
    units: Units, driven: Mapping[str, str], held: Mapping[str, Any], unset: Collection[str]
) -> Iterator[Problem]:
    """The problems of values for inputs, and of inputs that have none.

    Args:
        units: All units.
        driven: The path of each input or element that is driven, with that of the output that drives it.
        held: The values of inputs that nothing drives.
        unset: The inputs that keep the values that their units have.
    """
    inputs = {f"{n}.{v.name}": v for n, s in units.items() for v in s.interface.inputs}
    for path, value in held.items():
        if path not in inputs:
            yield Problem(path, "a value for an input that does not exist", choices(inputs), did_you_mean(path, inputs))
        elif path in driven:
            yield Problem(path, f"two sources, {driven[path]} and a held value", "one source")
        else:
            yield from inputs[path].quantity.problems(path, value)
    for path in unset:
        if path not in inputs:
            yield Problem(path, "an input that does not exist", choices(inputs), did_you_mean(path, inputs))
    for path, variable in inputs.items():
        unit = path.partition(".")[0]
        if path not in driven and path not in held and path not in unset:
            undriven = [e for e in variable.elements if f"{unit}.{e}" not in driven]
            missing = "no source" if len(undriven) == variable.size else f"no source of {', '.join(undriven)}"
            if undriven:
                yield Problem(path, missing, "a connection or a held value", "Connect it, or give it a value.")


def parameter_problems(name: str, source: UnitSource) -> Iterator[Problem]:
    """The problems of the parameter values of a unit, by its name, and of parameters that have none."""
    yield from value_problems(name, source, source.parameters)
    if source.has_own_values:
        return
    declared = {v.name: v for v in source.interface.parameters}
    for parameter in (p for p in declared if p not in source.parameters and p not in source.interface.starts):
        remedy = f"Give it with its unit and source in the scenario, or with --set {name}.{parameter}=VALUE."
        yield Problem(f"{name}.{parameter}", "no value", declared[parameter].quantity.range, remedy)


def value_problems(name: str, source: UnitSource, values: Mapping[str, Any]) -> Iterator[Problem]:
    """The problems of values for some parameters of a unit, by its name."""
    declared = {v.name: v for v in source.interface.parameters}
    initials = {v.name: v for v in source.interface.initials}
    for parameter, value in values.items():
        if parameter in declared or parameter in initials:
            yield from (declared | initials)[parameter].quantity.problems(f"{name}.{parameter}", value)
        else:
            kind = source.interface.kind
            valid = f"a parameter of `{kind}`: {choices(declared)}"
            yield Problem(f"{name}.{parameter}", "an unknown parameter", valid, did_you_mean(parameter, declared))
