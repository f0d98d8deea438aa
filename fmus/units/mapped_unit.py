"""A foreign unit behind the interface of a socket: values are translated on their way in and out.

The foreign unit has columns of its own. All links between two types of values are one gather, one multiplication and
one scatter on arrays that are prepared once; conventions (reference point, slip angle) act on a bus as a whole.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from components.interfaces.conversion import IDENTITY
from components.interfaces.quantity import Type, zeros
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link
from fmus.units.capabilities import StateCapability
from fmus.units.conventions import Convention, Views
from fmus.units.prepared_calls import Copy
from fmus.units.rates import RunningIntegral, RunningRate
from fmus.units.state_bytes import array_of, joined, parted
from fmus.units.unit import (
    DEFAULT_SETUP,
    Column,
    ExperimentSetup,
    Operation,
    TypedColumns,
    Unit,
    carry_out,
    is_failure,
    positions,
    views,
    widths,
)


class MappedUnit(Unit):
    """A foreign unit with the interface of a socket.

    Args:
        name: Name of the unit.
        interface: The interface of the socket, as far as the foreign unit serves it.
        inner: The foreign unit.
        adaptation: How its variables stand for the signals of the socket.
    """

    def __init__(self, name: str, interface: Interface, inner: Unit, adaptation: Adaptation) -> None:
        super().__init__(name, interface)
        self.messages, self.remarks, self.called = inner.messages, inner.remarks, inner.called
        self._inner = inner
        self._adaptation = adaptation
        theirs = inner.interface
        self._u = {kind: zeros(kind, n) for kind, n in widths(theirs.inputs).items()}
        self._y = {kind: zeros(kind, n) for kind, n in widths(theirs.recorded).items()}
        self._starts = {**theirs.starts, **adaptation.held}
        self._fill()
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []
        self._rates = [RunningRate(rate) for rate in adaptation.rates]
        self._integrals = [RunningIntegral() for _ in adaptation.integrated]
        if interface.event_mode:
            self.events = inner.events
        if inner.state is not None:
            columns = [*self._u.values(), *self._y.values()]
            self.state = _MappedState(inner.state, columns, self._rates, self._integrals)

    def _fill(self) -> None:
        """Give the columns of the foreign unit their first values."""
        for columns in (self._u, self._y):
            for kind, column in columns.items():
                column[:] = zeros(kind, column.size)
        for variable, slot in views(self._inner.interface.inputs, self._u).items():
            if variable in self._starts:
                slot[:] = np.ravel(self._starts[variable])

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        self._inner.bind(self._u, self._y, self._unset(unset))
        self._setters = [*self._from_ours(inputs), *self._inner.setters()]
        self._getters = [*self._inner.getters(), *self._to_ours(outputs)]
        ours, theirs = self.interface, self._inner.interface
        for rate in self._rates:
            rate.bind(views(ours.inputs, inputs), views(theirs.inputs, self._u), views(theirs.recorded, self._y))

    def _unset(self, ours: Collection[str]) -> set[str]:
        """The inputs of theirs that nobody has a value for: neither a signal of ours, nor the file, nor a person."""
        links = (*self._adaptation.inputs, *(rate.rate for rate in self._adaptation.rates))
        given = {name for link in links if link.signal not in ours for name, _ in link.theirs}
        waiting = {name for link in links if link.signal in ours for name, _ in link.theirs}
        return {v.name for v in self._inner.interface.inputs} - given - (self._starts.keys() - waiting)

    def _from_ours(self, inputs: TypedColumns) -> list[Operation]:
        """The calls that translate our inputs to theirs; conventions are applied to a copy."""
        ours, theirs = self.interface.inputs, self._inner.interface.inputs
        source = inputs
        calls: list[Operation] = []
        if conventions := _of_present_buses(self._adaptation.conventions, ours):
            source = {kind: column.copy() for kind, column in inputs.items()}
            calls += [Copy(inputs[kind], source[kind]) for kind in inputs]
            buses = _by_bus(views(ours, source))
            calls += [_applied(c.theirs, buses[bus]) for bus, cs in conventions.items() for c in reversed(cs)]
        return calls + _moves(self._adaptation.inputs, (ours, source), (theirs, self._u), back=True)

    def _to_ours(self, outputs: TypedColumns) -> list[Operation]:
        """The calls that translate their outputs to ours, and add what they do not show."""
        ours, theirs, a = self.interface.recorded, self._inner.interface.recorded, self._adaptation
        own = [Link(v.name, tuple((v.name, i) for i in range(v.size))) for v in theirs if v.name in a.passed_on]
        slots = views(ours, outputs)
        calls = [*_moves((*a.outputs, *own), (theirs, self._y), (ours, outputs)), *_constants(a.constants, slots)]
        calls += [i.shown_in(slots[name]) for name, i in zip(a.integrated, self._integrals, strict=True)]
        buses = _by_bus({v.name: slots[v.name] for v in self.interface.outputs})
        conventions = _of_present_buses(a.conventions, self.interface.outputs)
        return calls + [_applied(c.ours, buses[bus]) for bus, cs in conventions.items() for c in cs]

    @override
    def setters(self) -> list[Operation]:
        return self._setters

    @override
    def getters(self) -> list[Operation]:
        return self._getters

    @override
    def step(self, t: float, h: float) -> object:
        for integral in self._integrals:
            integral.begin(h)
        if self._rates:
            for rate in self._rates:
                rate.act(h)
            if is_failure(status := carry_out(self._inner.setters())):
                return status
        return self._inner.step(t, h)

    @override
    def tune(self, parameter: str, value: Any) -> None:
        self._inner.tune(parameter, value)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        self._inner.enter_initialization(parameters, setup)

    @override
    def exit_initialization(self) -> None:
        self._inner.exit_initialization()

    @override
    def terminate(self) -> None:
        self._inner.terminate()

    @override
    def reset(self) -> None:
        self._inner.reset()
        self._fill()
        for rate in self._rates:
            rate.kept = 0.0
        for integral in self._integrals:
            integral.begin_anew()
        self._forget_calls()

    @override
    def close(self) -> None:
        self._inner.close()


class _MappedState(StateCapability):
    """The state of the foreign unit, with that of its columns, and of the rates and integrals around it."""

    def __init__(
        self,
        inner: StateCapability,
        columns: Sequence[Column],
        rates: Sequence[RunningRate],
        integrals: Sequence[RunningIntegral],
    ) -> None:
        self._inner, self._columns, self._rates, self._integrals = inner, columns, rates, integrals
        self.serializes = inner.serializes and all(column.dtype.kind != "O" for column in columns)

    @override
    def save(self) -> Any:
        kept = [[rate.kept] for rate in self._rates], [[i.value, i.shown, i.h] for i in self._integrals]
        return self._inner.save(), [column.copy() for column in self._columns], kept

    @override
    def restore(self, state: Any) -> None:
        inner, columns, (rates, integrals) = state
        self._inner.restore(inner)
        for mine, saved in zip(self._columns, columns, strict=True):
            mine[:] = saved
        for rate, (kept,) in zip(self._rates, rates, strict=True):
            rate.kept = kept
        for integral, kept in zip(self._integrals, integrals, strict=True):
            integral.value, integral.shown, integral.h = kept

    @override
    def forget(self, state: Any) -> None:
        self._inner.forget(state[0])

    @override
    def serialized(self, state: Any) -> bytes:
        inner, columns, kept = state
        parts = [self._inner.serialized(inner), json.dumps(kept).encode()]
        return joined([*parts, *(column.tobytes() for column in columns)])

    @override
    def deserialized(self, content: bytes) -> Any:
        inner, kept, *columns = parted(content, 2 + len(self._columns))
        values = [array_of(part, mine) for part, mine in zip(columns, self._columns, strict=True)]
        rates, integrals = json.loads(kept)
        of_rates = [[float(rate)] for (rate,), _ in zip(rates, self._rates, strict=True)]
        of_integrals = [[float(v), float(s), float(h)] for (v, s, h), _ in zip(integrals, self._integrals, strict=True)]
        return self._inner.deserialized(inner), values, (of_rates, of_integrals)


def _of_present_buses(
    conventions: Mapping[str, tuple[Convention, ...]], variables: Sequence[Variable]
) -> dict[str, tuple[Convention, ...]]:
    """The conventions of the buses that are among the variables."""
    present = {v.name.partition(".")[0] for v in variables}
    return {bus: those for bus, those in conventions.items() if bus in present}


def _by_bus(slots: Mapping[str, Column]) -> dict[str, Views]:
    """By bus, its signals as views."""
    buses: dict[str, dict[str, Column]] = {}
    for name, slot in slots.items():
        bus, _, leaf = name.partition(".")
        buses.setdefault(bus, {})[leaf] = slot
    return dict(buses)


def _applied(function: Callable[[Views], None], bus: Views) -> Operation:
    return lambda: function(bus)


def _constants(values: Mapping[str, Any], slots: Mapping[str, Column]) -> list[Operation]:
    """Calls that write constant signals; each time anew, as the conventions of their bus change them in place."""
    return [Copy(np.array(np.ravel(value), dtype=slots[name].dtype), slots[name]) for name, value in values.items()]


def _moves(
    links: Iterable[Link],
    source: tuple[Sequence[Variable], TypedColumns],
    target: tuple[Sequence[Variable], TypedColumns],
    *,
    back: bool = False,
) -> list[Operation]:
    """One call per pair of types: from theirs to ours, or `back` from ours to theirs."""
    from_places, to_places = positions(source[0]), positions(target[0])
    grouped: dict[tuple[Type, Type], list[tuple[int, int, float, float, float, float]]] = {}
    for link in links:
        relation = link.relation if link.relation == IDENTITY or not back else link.relation.inverse
        for i, (name, element) in enumerate(link.theirs):
            ours, theirs = (link.signal, i), (name, element)
            (a, i_a), (b, i_b) = (ours, theirs) if back else (theirs, ours)
            (kind_a, at_a), (kind_b, at_b) = from_places[a], to_places[b]
            limits = (link.low, link.high) if back else (-np.inf, np.inf)
            item = (at_a + i_a, at_b + i_b, relation.factor, relation.offset, *limits)
            grouped.setdefault((kind_a, kind_b), []).append(item)
    return [
        _move(source[1][kind_a], target[1][kind_b], kind_b, np.array(items))
        for (kind_a, kind_b), items in grouped.items()
    ]


def _move(source: Column, target: Column, kind: Type, table: NDArray[np.float64]) -> Operation:
    """Gather, convert and scatter values; those that need no conversion are copied bit by bit."""
    places, slots = table[:, 0].astype(np.intp), table[:, 1].astype(np.intp)
    factor, offset, low, high = (np.ascontiguousarray(column) for column in table[:, 2:].T)
    limited = bool(np.isfinite([low, high]).any())
    plain = bool((factor == 1).all() and (offset == 0).all()) and not limited
    whole = kind.is_integer or kind is Type.ENUMERATION
    if plain and (source.dtype == target.dtype or source.dtype.kind != "f" or not whole):

        def copy() -> None:
            target[slots] = source[places]

        return copy
    values = np.zeros(len(table))

    def convert() -> None:
        np.multiply(source[places], factor, values)
        np.add(values, offset, values)
        if limited:
            np.clip(values, low, high, values)
        if whole:
            np.rint(values, values)
        target[slots] = values

    return convert
