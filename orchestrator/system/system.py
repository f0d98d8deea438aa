"""Systems: units, connections and parameter values, checked completely before anything runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from components.interfaces.conversion import IDENTITY, Linear, Lookup, Transformation, type_fits, unit_conversion
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.socket import Socket, describe
from orchestrator.system.connection import Connection, is_part, signal
from orchestrator.system.input_table import InputTable
from orchestrator.system.patterns import fits
from orchestrator.system.source import UnitSource


@dataclass(frozen=True)
class System:
    """Units, what drives each of their inputs, and the sockets that they fill.

    Everything is checked when a system is made: unknown or missing ports, types, shapes, units of measurement, ranges,
    and inputs with two sources. Units of measurement are converted along the connections.

    Args:
        units: What each unit is made from, by its name.
        wiring: The output that drives each input (a signal, one element of it, or a whole bus), both with the name of
            their unit: ``{"controller.ego": "plant.state"}``.
        held: Constant values of inputs, or of those elements of them that nothing drives, by their full path; a scalar,
            or an array of the input's shape `(n,)`, in the input's unit of measurement.
        sockets: The sockets that units must fit, by the name of the unit.
        transformations: The transformation of the value that an input receives, by input as in `wiring`.
        unconverted: Inputs whose values are not converted to their unit of measurement.
        unset: Full paths of inputs that nothing drives and nobody has a value for: a unit keeps the values that it has
            for them inside.
        steps: Steps of units that have their own, in macro steps: a whole number, or the reciprocal of one.
        table: A table that inputs follow in place of their held values.
        allow_nonfinite: Patterns of the signals that may be infinite or not a number although a unit reads them.

    Raises:
        RequestError: The system is not valid; the error lists all problems.
    """

    units: Mapping[str, UnitSource]
    wiring: Mapping[str, str]
    held: Mapping[str, Any] = field(default_factory=dict[str, Any])
    sockets: Mapping[str, Socket] = field(default_factory=dict[str, Socket])
    transformations: Mapping[str, Transformation] = field(default_factory=dict[str, Transformation])
    unconverted: Collection[str] = frozenset()
    unset: Collection[str] = frozenset()
    steps: Mapping[str, Fraction] = field(default_factory=dict[str, Fraction])
    table: InputTable | None = None
    allow_nonfinite: Collection[str] = ()

    def __post_init__(self) -> None:
        raise_if_any(_problems(self))

    @cached_property
    def clock_connections(self) -> tuple[Connection, ...]:
        """The part of the wiring that leads from output clocks to triggered input clocks."""
        wires = [(*key.split(".", 1), *value.split(".", 1)) for key, value in self.wiring.items()]
        return tuple(
            Connection(unit, clock, source, output)
            for unit, clock, source, output in wires
            if _is_clock(self, f"{unit}.{clock}", "input")
        )

    @cached_property
    def connections(self) -> tuple[Connection, ...]:
        """The wiring, signal by signal."""
        return tuple(
            c for key, value in self.wiring.items() for c in _expand(self, key, value) if isinstance(c, Connection)
        )

    def driver(self, unit: str, name: str, element: int) -> Connection | None:
        """The connection to an element of an input, by its index from 0; `None` where nothing drives it."""
        wires = (c for c in self.connections if (c.unit, c.input) == (unit, name))
        return next((c for c in wires if c.input_element is None or c.input_element.at == element), None)

    def held_by(self, unit: str) -> dict[str, Any]:
        """The values at which inputs of a unit are held, by the name of the input."""
        return {path.partition(".")[2]: v for path, v in self.held.items() if path.partition(".")[0] == unit}

    def variable(self, path: str, *, role: str = "outputs") -> Variable:
        """The variable at a full signal path.

        Args:
            path: The path, such as `plant.state.v_x`.
            role: `inputs`, `outputs` or `recorded`, the list of the interface that it stands in.

        Raises:
            KeyError: There is no such variable.
        """
        unit, _, name = path.partition(".")
        return {v.name: v for v in getattr(self.units[unit].interface, role)}[name]


def _problems(system: System) -> Iterator[Problem]:
    for name, socket in system.sockets.items():
        if name not in system.units:
            yield Problem(f"socket `{socket.name}`", f"the unknown unit `{name}`", choices(system.units))
            continue
        interface = system.units[name].interface
        yield from socket.problems(name, interface.inputs, interface.outputs)
    for name, source in system.units.items():
        yield from _parameter_problems(name, source)
    yield from _instance_problems(system)
    driven: dict[str, str] = {}
    for key, value in system.wiring.items():
        for expanded in _expand(system, key, value):
            if isinstance(expanded, Problem):
                yield expanded
                continue
            path, whole = expanded.target, f"{expanded.unit}.{expanded.input}"
            source = expanded.origin
            before = [path, whole] if expanded.input_element else [p for p in driven if is_part(p, path)]
            for taken in [p for p in dict.fromkeys(before) if p in driven][:1]:
                yield Problem(taken, f"two sources, {driven[taken]} and {source}", "one source")
            driven[path] = source
            yield from _mismatch(system, expanded)
    yield from _held_problems(system, driven)
    for path in system.transformations.keys() - driven.keys():
        yield Problem(path, "a transformation without a connection", choices(driven), did_you_mean(path, driven))
    yield from _step_problems(system)
    yield from _pattern_problems(system)


def _instance_problems(system: System) -> Iterator[Problem]:
    """The problems of units that are made from one FMU, of which a process can hold only one instance."""
    once: dict[Path, str] = {}
    for name, source in system.units.items():
        if (file := source.single_instance()) is not None:
            other = once.setdefault(file.resolve(), name)
            if other != name:
                found = f"{file}, which `{other}` runs too"
                valid = "an FMU that can be instantiated more than once per process"
                yield Problem(f"unit `{name}`", found, valid, "Run one of them in a process of its own.")


def _pattern_problems(system: System) -> Iterator[Problem]:
    paths = [
        f"{name}.{path}"
        for name, source in system.units.items()
        for v in source.interface.outputs
        for path in (v.name, *v.elements)
    ]
    for pattern in system.allow_nonfinite:
        if pattern != "*" and not any(fits(path, pattern) for path in paths):
            where = f"allow_nonfinite {pattern}"
            yield Problem(where, "a pattern that no output fits", choices({*paths}), did_you_mean(pattern, paths))


def _step_problems(system: System) -> Iterator[Problem]:
    for name, ratio in system.steps.items():
        if name not in system.units:
            yield Problem(f"step of `{name}`", "an unknown unit", choices(system.units))
        elif ratio <= 0 or 1 not in (ratio.numerator, ratio.denominator):
            valid = "a whole multiple of the macro step, or a whole part of it"
            yield Problem(f"step of `{name}`", f"{ratio} macro steps", valid)


def _held_problems(system: System, driven: Mapping[str, str]) -> Iterator[Problem]:
    inputs = {f"{n}.{v.name}": v for n, s in system.units.items() for v in s.interface.inputs}
    for path, value in system.held.items():
        if path not in inputs:
            yield Problem(path, "a value for an input that does not exist", choices(inputs), did_you_mean(path, inputs))
        elif path in driven:
            yield Problem(path, f"two sources, {driven[path]} and a held value", "one source")
        else:
            yield from inputs[path].quantity.problems(path, value)
    for path in system.unset:
        if path not in inputs:
            yield Problem(path, "an input that does not exist", choices(inputs), did_you_mean(path, inputs))
    for path, variable in inputs.items():
        unit = path.partition(".")[0]
        if path not in driven and path not in system.held and path not in system.unset:
            undriven = [e for e in variable.elements if f"{unit}.{e}" not in driven]
            missing = "no source" if len(undriven) == variable.size else f"no source of {', '.join(undriven)}"
            if undriven:
                yield Problem(path, missing, "a connection or a held value", "Connect it, or give it a value.")


def _parameter_problems(name: str, source: UnitSource) -> Iterator[Problem]:
    declared = {v.name: v for v in source.interface.parameters}
    initials = {v.name: v for v in source.interface.initials}
    for parameter, value in source.parameters.items():
        if parameter in declared or parameter in initials:
            yield from (declared | initials)[parameter].quantity.problems(f"{name}.{parameter}", value)
        else:
            kind = source.interface.kind
            valid = f"a parameter of `{kind}`: {choices(declared)}"
            yield Problem(f"{name}.{parameter}", "an unknown parameter", valid, did_you_mean(parameter, declared))
    if source.has_own_values:
        return
    for parameter in (p for p in declared if p not in source.parameters and p not in source.interface.starts):
        remedy = f"Give it with its unit and source in the scenario, or with --set {name}.{parameter}=VALUE."
        yield Problem(f"{name}.{parameter}", "no value", declared[parameter].quantity.range, remedy)


def _is_clock(system: System, path: str, causality: str) -> bool:
    unit, _, name = path.partition(".")
    clocks = [c for c in system.units[unit].interface.clocks if c.name == name] if unit in system.units else []
    return bool(clocks) and (clocks[0].is_triggered_input if causality == "input" else clocks[0].causality == causality)


def _expand(system: System, key: str, value: str) -> Iterator[Connection | Problem]:
    """The connections of signals that one entry of the wiring stands for; none for clocks, which carry no value."""
    if _is_clock(system, key, "input"):
        if not _is_clock(system, value, "output"):
            yield Problem(f"{value} -> {key}", f"`{value}`, which is no output clock", "an output clock")
        return
    unit, _, port = key.partition(".")
    source, _, output = value.partition(".")
    for side in (unit, source):
        if side not in system.units:
            yield Problem(f"{value} -> {key}", f"the unknown unit `{side}`", choices(system.units))
            return
    port = system.units[unit].interface.aliases.get(port, port)
    inputs = system.units[unit].interface.inputs
    outputs = system.units[source].interface.outputs
    names = [v.name for v in inputs]
    if signal(port, inputs) or signal(output, outputs):
        pairs = [(port, output)]
    else:
        pairs = [(name, output + name[len(port) :]) for name in names if name.startswith(port + ".")]
    for name, source_name in pairs or [(port, output)]:
        end, start = signal(name, inputs), signal(source_name, outputs)
        if end is None:
            yield Problem(f"{unit}.{name}", "no such input", choices(names), did_you_mean(name, names))
        elif start is None:
            shown = [v.name for v in outputs]
            yield Problem(f"{source}.{source_name}", "no such output", choices(shown), did_you_mean(source_name, shown))
        else:
            connection = Connection(unit, end[0].name, source, start[0].name, IDENTITY, end[1], start[1])
            yield dataclasses.replace(connection, conversion=_conversion(system, connection))


def _ends(system: System, wire: Connection) -> tuple[Quantity, Quantity]:
    wanted = system.variable(f"{wire.unit}.{wire.input}", role="inputs").quantity
    found = system.variable(f"{wire.source}.{wire.output}").quantity
    found = dataclasses.replace(found, shape=()) if wire.output_element else found
    return found, dataclasses.replace(wanted, shape=()) if wire.input_element else wanted


def _conversion(system: System, wire: Connection) -> Transformation:
    """The conversion of the unit of measurement, then the system's transformation; `_mismatch` reports misfits."""
    transformation = system.transformations.get(wire.target, IDENTITY)
    if wire.target in system.unconverted:
        return transformation
    conversion = unit_conversion(*_ends(system, wire)) or IDENTITY
    return transformation.after(conversion) if isinstance(transformation, Linear) else transformation


def _mismatch(system: System, wire: Connection) -> Iterator[Problem]:
    found, wanted = _ends(system, wire)
    transformation = system.transformations.get(wire.target, IDENTITY)
    if isinstance(transformation, Lookup):
        fits = found.type.is_listed and (found.type is wanted.type or Type.BOOLEAN not in (found.type, wanted.type))
        fits &= wanted.type.is_listed
    else:
        fits = type_fits(found, wanted)
    fits &= wire.target in system.unconverted or unit_conversion(found, wanted) is not None
    if not fits or wanted.shape != found.shape:
        yield Problem(str(wire), describe(found), describe(wanted), _remedy(found, wanted))
    elif isinstance(transformation, Lookup):
        for value in transformation.table.values():
            yield from wanted.problems(f"{wire}, transformation", value)
    elif not (found.type.is_float or transformation == IDENTITY):
        yield Problem(str(wire), f"a linear transformation of {describe(found)}", "one of a Float64 or Float32")


def _remedy(found: Quantity, wanted: Quantity) -> str:
    if found.type.is_integer and wanted.type.is_integer and not type_fits(found, wanted):
        return "An integer goes into one that can hold all of its values."
    return ""
