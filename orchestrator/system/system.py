"""Systems: units, connections and parameter values, checked completely before anything runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from components.interfaces.arguments import check_fields, names_told
from components.interfaces.conversion import IDENTITY, Linear, Lookup, Transformation, type_fits, unit_conversion
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.socket import Socket, describe
from orchestrator.system.connection import Connection, SignalNames
from orchestrator.system.input_table import InputTable
from orchestrator.system.source import UnitSource
from orchestrator.system.unit_problems import (
    held_problems,
    instance_problems,
    parameter_problems,
    pattern_problems,
    step_problems,
)


@names_told
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

    MADE_BY: ClassVar = 'Write load("static").system, or System(units, wiring).'
    """What to do where something else is given."""
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
        check_fields(self)
        raise_if_any(_problems(self, self._expanded))

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
    def _expanded(self) -> tuple[Connection | Problem, ...]:
        """The wiring, signal by signal, and what is wrong with it."""
        return tuple(one for key, value in self.wiring.items() for one in _expand(self, key, value))

    @cached_property
    def connections(self) -> tuple[Connection, ...]:
        """The wiring, signal by signal."""
        return tuple(one for one in self._expanded if isinstance(one, Connection))

    @cached_property
    def _by_end(self) -> dict[tuple[str, ...], list[Connection]]:
        """The connections from each unit, to each unit and to each input."""
        found: dict[tuple[str, ...], list[Connection]] = {}
        for wire in self.connections:
            for end in (("from", wire.source), ("to", wire.unit), ("to", wire.unit, wire.input)):
                found.setdefault(end, []).append(wire)
        return found

    def connections_from(self, unit: str) -> Sequence[Connection]:
        """The connections that lead from the outputs of a unit."""
        return self._by_end.get(("from", unit), ())

    def connections_to(self, unit: str) -> Sequence[Connection]:
        """The connections that lead to the inputs of a unit."""
        return self._by_end.get(("to", unit), ())

    def driver(self, unit: str, name: str, element: int) -> Connection | None:
        """The connection to an element of an input, by its index from 0; `None` where nothing drives it."""
        wires = self._by_end.get(("to", unit, name), ())
        return next((c for c in wires if c.input_element is None or c.input_element.at == element), None)

    @cached_property
    def _held_by_unit(self) -> dict[str, dict[str, Any]]:
        found: dict[str, dict[str, Any]] = {}
        for path, value in self.held.items():
            unit, _, name = path.partition(".")
            found.setdefault(unit, {})[name] = value
        return found

    def held_by(self, unit: str) -> dict[str, Any]:
        """The values at which inputs of a unit are held, by the name of the input."""
        return {**self._held_by_unit.get(unit, {})}

    @cached_property
    def _names(self) -> dict[tuple[str, str], SignalNames]:
        return {}

    def names(self, unit: str, role: str) -> SignalNames:
        """The names of a unit's variables.

        Args:
            unit: The name of the unit.
            role: The list of the interface that they stand in, such as `inputs`.
        """
        if (unit, role) not in self._names:
            self._names[unit, role] = SignalNames(getattr(self.units[unit].interface, role))
        return self._names[unit, role]

    def variable(self, path: str, *, role: str = "outputs") -> Variable:
        """The variable at a full signal path.

        Args:
            path: The path, such as `plant.state.v_x`.
            role: `inputs`, `outputs` or `recorded`, the list of the interface that it stands in.

        Raises:
            KeyError: There is no such variable.
        """
        unit, _, name = path.partition(".")
        return self.names(unit, role).variables[name]


def _problems(system: System, wiring: Iterable[Connection | Problem]) -> Iterator[Problem]:
    for name, socket in system.sockets.items():
        if name not in system.units:
            yield Problem(f"socket `{socket.name}`", f"the unknown unit `{name}`", choices(system.units))
            continue
        interface = system.units[name].interface
        yield from socket.problems(name, interface.inputs, interface.outputs)
    for name, source in system.units.items():
        yield from parameter_problems(name, source)
    yield from instance_problems(system.units)
    driven: dict[str, str] = {}
    first: dict[str, str] = {}  # by the path of an input, what of it was driven first: all of it, or an element
    for expanded in wiring:
        if isinstance(expanded, Problem):
            yield expanded
            continue
        path, whole = expanded.target, f"{expanded.unit}.{expanded.input}"
        source = expanded.origin
        before = (path, whole) if expanded.input_element else (first.get(whole, path),)
        if taken := next((p for p in before if p in driven), None):
            yield Problem(taken, f"two sources, {driven[taken]} and {source}", "one source")
        driven[path] = source
        first.setdefault(whole, path)
        yield from _mismatch(system, expanded)
    yield from held_problems(system.units, driven, system.held, system.unset)
    for path in system.transformations.keys() - driven.keys():
        yield Problem(path, "a transformation without a connection", choices(driven), did_you_mean(path, driven))
    for path in set(system.unconverted) - driven.keys():
        yield Problem(path, "unconverted, but without a connection", choices(driven), did_you_mean(path, driven))
    yield from step_problems(system.units, system.steps)
    yield from pattern_problems(system.units, system.allow_nonfinite)


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
    inputs, outputs = system.names(unit, "inputs"), system.names(source, "outputs")
    if inputs.find(port) or outputs.find(output):
        pairs = [(port, output)]
    else:
        pairs = [(name, output + name[len(port) :]) for name in inputs.in_bus(port)]
    for name, source_name in pairs or [(port, output)]:
        end, start = inputs.find(name), outputs.find(source_name)
        if end is None:
            known = inputs.variables
            yield Problem(f"{unit}.{name}", "no such input", choices(known), did_you_mean(name, known))
        elif start is None:
            known = outputs.variables
            yield Problem(f"{source}.{source_name}", "no such output", choices(known), did_you_mean(source_name, known))
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
