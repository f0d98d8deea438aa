"""The signal table: one column of memory per type that every unit writes its outputs to and reads its inputs from."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from components.interfaces.conversion import IDENTITY, Transformation
from components.interfaces.quantity import Type, zeros
from components.interfaces.record import Variable
from fmus.units.prepared_calls import Copy, Gather
from fmus.units.unit import Column, Operation, TypedColumns, Unit, positions, widths
from orchestrator.system.system import Connection, System


class RecordedElement(NamedTuple):
    """One element of an output or of an observed variable, and where its values are."""

    unit: str
    path: str
    """Full path: unit, signal and, in an array, the index from 1."""
    type: Type
    position: int
    """Its index in the column of that type."""


class _Conversion(NamedTuple):
    """Values that have to be converted on their way to an input."""

    type: Type
    """The type of the input."""
    slots: slice
    """Elements of the unit's inputs of that type."""
    values: Column
    conversion: Transformation


class SignalTable:
    """Memory for all that units show, in the order of the units, and behind them a slot for each input that is held.

    A unit's inputs are a view of the outputs that drive them where these lie side by side, else a copy by index.

    Args:
        system: The system whose signals it holds.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self._first: dict[str, dict[Type, int]] = {}
        self._slots: dict[tuple[str, str], dict[str, tuple[Type, slice]]] = {}
        """By unit and role, where each variable is."""
        length = dict.fromkeys(Type, 0)
        for role in ("recorded", "inputs"):
            for name, source in system.units.items():
                variables = getattr(source.interface, role)
                width = widths(variables)
                first = {kind: length[kind] for kind in width}
                if role == "recorded":
                    self._first[name] = first
                self._slots[name, role] = _slots(variables, first)
                for kind, n in width.items():
                    length[kind] += n
            if role == "recorded":
                self.recorded = dict(length)
                """By type, the number of elements at the beginning of the column that units show."""
        self.columns: dict[Type, Column] = {kind: zeros(kind, n) for kind, n in length.items()}
        """By type, the values of all elements, (n,)."""
        self._held: set[tuple[str, str]] = set()
        self._outputs: dict[str, TypedColumns] = {}
        self._driven: dict[str, tuple[dict[Type, list[int]], list[_Conversion]]] = {}
        """What drives the inputs of each unit, until something is held or released."""
        self._inputs: dict[str, TypedColumns] = {}
        """The columns of the inputs of each unit, as long as `_driven` has it."""
        self._gathers: dict[str, list[Operation]] = {}
        self._without_value: dict[str, list[str]] = {}
        for unit, _, name in (path.partition(".") for path in system.unset):
            self._without_value.setdefault(unit, []).append(name)
        self._fill()

    def _fill(self) -> None:
        """Set the values of inputs that nothing drives."""
        for path, value in self.system.held.items():
            unit, _, name = path.partition(".")
            self._keep(unit, name, value)

    def begin_anew(self) -> None:
        """Undo all that was written and shown; the units have to be bound again where something was held."""
        for kind, column in self.columns.items():
            column[:] = zeros(kind, column.size)
        if self._held:
            self._held.clear()
            self._driven.clear()
        self._fill()

    def slots(self, unit: str, name: str, role: str) -> tuple[Type, slice]:
        """Where an output, or a held input, is.

        Args:
            unit: Name of the unit.
            name: Name of the signal within the unit.
            role: `recorded` or `inputs`, as the interface calls them.

        Returns:
            Its type, and its elements in the column of that type.
        """
        return self._slots[unit, role][name]

    def _source(self, wire: Connection) -> tuple[Type, slice]:
        """Type and place of what drives an input, or an element of it."""
        kind, there = self.slots(wire.source, wire.output, "recorded")
        return kind, there if wire.output_element is None else _moved(wire.output_element.at, there.start, 1)

    def outputs(self, unit: str) -> TypedColumns:
        """The columns that a unit writes its outputs to."""
        if unit not in self._outputs:
            width = widths(self.system.units[unit].interface.recorded)
            first = self._first[unit]
            self._outputs[unit] = {kind: self.columns[kind][first[kind] : first[kind] + n] for kind, n in width.items()}
        return self._outputs[unit]

    def inputs(self, unit: str) -> TypedColumns:
        """The columns that a unit reads its inputs from, after the calls of `gathers`."""
        if unit in self._driven and unit in self._inputs:
            return self._inputs[unit]
        indices, conversions = self._driven[unit] = self._drivers(unit)
        inputs: dict[Type, Column] = {}
        self._gathers[unit] = gathers = list[Operation]()
        for kind, places in indices.items():
            column = self.columns[kind]
            apart = any(c.type == kind for c in conversions)
            if not apart and places == list(range(places[0], places[0] + len(places))):
                inputs[kind] = column[places[0] : places[0] + len(places)]
            else:
                inputs[kind] = zeros(kind, len(places))
                gathers.append(Gather(column, np.array(places), inputs[kind]))
        gathers += [Copy(c.values, inputs[c.type][c.slots], c.conversion) for c in conversions]
        self._inputs[unit] = inputs
        return inputs

    def bind(self, unit: Unit, waiting: Collection[str] = ()) -> None:
        """Bind a unit to its columns; its setters leave alone what nobody has a value for, and what is `waiting`."""
        name = unit.name
        unit.bind(self.inputs(name), self.outputs(name), self._unset(name).union(waiting))

    def giving(self, unit: Unit) -> list[Operation]:
        """The calls that give a unit, which is bound, all its inputs."""
        return [*self.gathers(unit.name), *unit.setters()]

    def gathers(self, unit: str) -> list[Operation]:
        """The copies that bring scattered inputs of a unit together; valid until `inputs` is called again."""
        return self._gathers[unit]

    def _unset(self, unit: str) -> set[str]:
        """The inputs of a unit that nobody has a value for."""
        return {name for name in self._without_value.get(unit, ()) if (unit, name) not in self._held}

    def _drivers(self, unit: str) -> tuple[dict[Type, list[int]], list[_Conversion]]:
        """By type, the place in the table of each element of a unit's inputs; and the values that are converted.

        The place of an element whose value is converted is its own, where it is held if nothing drives it.
        """
        wires: dict[str, list[Connection]] = {}
        for wire in self.system.connections_to(unit):
            if (unit, wire.input) not in self._held:
                wires.setdefault(wire.input, []).append(wire)
        indices: dict[Type, list[int]] = {}
        conversions: list[_Conversion] = []
        for variable in self.system.units[unit].interface.inputs:
            kind, slots = self.slots(unit, variable.name, "inputs")
            places = indices.setdefault(kind, [])
            first = len(places)
            places.extend(range(slots.start, slots.stop))
            for wire in wires.get(variable.name, ()):
                source, there = self._source(wire)
                at = wire.input_element.at if wire.input_element else 0
                mine = _moved(at, first, there.stop - there.start)
                if source == kind and wire.conversion == IDENTITY:
                    places[mine] = range(there.start, there.stop)
                else:
                    conversions.append(_Conversion(kind, mine, self.columns[source][there], wire.conversion))
        return indices, conversions

    def read(self, path: str) -> Any:
        """The present value of what a unit shows, by its full path: a number, a text, or an array of its shape."""
        unit, _, name = path.partition(".")
        variable = self.system.variable(path, role="recorded")
        kind, slots = self.slots(unit, name, "recorded")
        values = self.columns[kind][slots]
        if variable.shape:
            return values.reshape(variable.shape).copy()
        return values[0].item() if kind.is_number else values[0]

    def hold(self, unit: str, name: str, value: Any) -> None:
        """Hold an input at a value in place of its connections, from the next call of `inputs` on."""
        self._keep(unit, name, value)
        self._held.add((unit, name))
        self._driven.pop(unit, None)

    @property
    def held(self) -> frozenset[tuple[str, str]]:
        """The inputs that are held by `hold`: their unit and their name."""
        return frozenset(self._held)

    @held.setter
    def held(self, held: frozenset[tuple[str, str]]) -> None:
        self._held = set(held)
        self._driven.clear()

    def is_held(self, unit: str, name: str) -> bool:
        """Whether an input is held by `hold`."""
        return (unit, name) in self._held

    def _keep(self, unit: str, name: str, value: Any) -> None:
        """Set the value that an input has where nothing drives it."""
        kind, slots = self.slots(unit, name, "inputs")
        self.columns[kind][slots] = np.asarray(value, dtype=None if kind.is_number else object).ravel()

    def release(self, unit: str, name: str) -> None:
        """Undo `hold` from the next call of `inputs` on; an input without a connection keeps its value."""
        self._held.discard((unit, name))
        self._driven.pop(unit, None)

    def elements(self) -> list[RecordedElement]:
        """Every element of every variable that a unit shows, in the order of the units."""
        elements: list[RecordedElement] = []
        for unit, source in self.system.units.items():
            for variable in source.interface.recorded:
                kind, slots = self.slots(unit, variable.name, "recorded")
                elements += [
                    RecordedElement(unit, f"{unit}.{element}", kind, slots.start + i)
                    for i, element in enumerate(variable.elements)
                ]
        return elements


def _slots(variables: Sequence[Variable], first: Mapping[Type, int]) -> dict[str, tuple[Type, slice]]:
    """Where each variable is, when those of a type begin at its `first` element."""
    places = positions(variables)
    return {
        v.name: (kind, slice(first[kind] + at, first[kind] + at + v.size))
        for v in variables
        for kind, at in [places[v.name]]
    }


def _moved(at: int, start: int, size: int) -> slice:
    return slice(start + at, start + at + size)
