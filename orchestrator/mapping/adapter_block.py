"""What stands between a foreign unit and its socket as two blocks, which become FMUs that other tools run.

One block, on the way in, makes the inputs of the foreign unit from our signals; the other, on the way out, makes our
signals from what it shows. Both act once per communication point, and do what `MappedUnit` does.
"""

from __future__ import annotations

import math
import re
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any, Final, TypeAlias

import numpy as np

from components.interfaces.block import Block, Sampled, block
from components.interfaces.conversion import IDENTITY, Linear
from components.interfaces.maths import clip, joined
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable, groups, pack, record, unpack, variables
from components.interfaces.socket import Socket
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, VariableElement

THEIRS: Final = "theirs"
"""The bus of an adapter that has the variables of the foreign unit."""
_Signals: TypeAlias = dict[str, Any]
"""The elements of each signal, numbers or symbols, by its name, (n,)."""


@dataclass(frozen=True)
class Part:
    """What one of the two blocks has to do."""

    adaptation: Adaptation
    """What stands between the two; only what it says of this direction counts."""
    ours: Sequence[Variable]
    """The signals that are read or made."""
    theirs: Interface
    """The interface of the foreign unit."""
    h: float
    """[s] The step over which rates act, or are integrated."""
    early: bool = False
    """Whether the foreign unit has made a step when its outputs are first read."""


@dataclass(frozen=True)
class Adapter:
    """One of the two blocks."""

    block: type[Block[Any, Any, Any]]
    reads: Mapping[VariableElement, str] = field(default_factory=dict[VariableElement, str])
    """Its input for each element of a variable of theirs that it reads."""
    sets: Mapping[VariableElement, str] = field(default_factory=dict[VariableElement, str])
    """Its output for each element of a variable of theirs that it sets."""


class _Ports:
    """The variables of theirs that an adapter has a port for, each element by itself, in the order of their use."""

    def __init__(self, theirs: Iterable[Variable]) -> None:
        self._theirs = {v.name: v for v in theirs}
        self.names: dict[VariableElement, str] = {}
        self.variables: list[Variable] = []

    def of(self, place: VariableElement) -> str:
        """The port of an element, which is made where there is none yet."""
        if place not in self.names:
            variable = self._theirs[place[0]]
            plain = re.sub(r"\W+", "_", variable.elements[place[1]]).strip("_") or "value"
            name = plain if plain[0].isalpha() else f"v_{plain}"
            taken = {v.name for v in self.variables}
            n = 1
            while f"{THEIRS}.{name}" in taken:
                n += 1
                name = f"{plain}_{n}"
            self.names[place] = f"{THEIRS}.{name}"
            self.variables.append(Variable(f"{THEIRS}.{name}", _port_quantity(variable)))
        return self.names[place]


def _port_quantity(variable: Variable) -> Quantity:
    """The quantity of a port: blocks have fewer types than FMI, and ranges are the business of the foreign unit."""
    q = variable.quantity
    kind = q.type if q.type in (Type.BOOLEAN, Type.ENUMERATION) else Type.FLOAT64 if q.type.is_float else Type.INT32
    unit = (q.unit if q.base is None else "") or "1"
    return Quantity(unit if kind.is_float else "1", f"`{variable.name}` of the FMU", kind, enumeration=q.enumeration)


def input_adapter(name: str, part: Part) -> Adapter:
    """The block, of this name, that makes the inputs of a foreign unit."""
    adaptation, ours, theirs, h = part.adaptation, part.ours, part.theirs, part.h
    read, given = _Ports(theirs.outputs), _Ports(theirs.inputs)
    for link in (*adaptation.inputs, *(rate.rate for rate in adaptation.rates)):
        for place in link.theirs:
            given.of(place)
    for rate in adaptation.rates:
        for place in rate.present.theirs if rate.present else ():
            read.of(place)
    kept = {f"kept_{i}": 0.0 for i in range(len(adaptation.rates))}

    def sample(x: _Signals, u: _Signals) -> tuple[_Signals, _Signals]:
        out: _Signals = {}
        signals = {v.name: u[v.name].copy() for v in ours}
        _convert(adaptation, signals, to_theirs=True)
        for link in adaptation.inputs:
            for i, place in enumerate(link.theirs):
                value = _applied(link.relation, signals[link.signal][i], back=True)
                out[given.of(place)] = [_limited(value, link.low, link.high)]
        states: _Signals = {}
        for i, rate in enumerate(adaptation.rates):
            present = rate.present
            now = x[f"kept_{i}"][0] if present is None else _applied(present.relation, u[read.of(present.theirs[0])][0])
            value = _limited((u[rate.rate.signal][0] - now) / h, -rate.limit, rate.limit)
            states[f"kept_{i}"] = [now + h * value]
            value = _applied(rate.rate.relation, value, back=True)
            out[given.of(rate.rate.theirs[0])] = [_limited(value, rate.rate.low, rate.rate.high)]
        return states, out

    made = _block(name, ([*ours, *read.variables], kept, given.variables), sample, (adaptation, ours, h))
    return Adapter(made, read.names, given.names)


def output_adapter(name: str, part: Part) -> Adapter:
    """The block, of this name, that makes our signals from what a foreign unit shows."""
    adaptation, ours, h = part.adaptation, part.ours, part.h
    ports = _Ports(part.theirs.outputs)
    for link in adaptation.outputs:
        for place in link.theirs:
            ports.of(place)
    integrals = {signal: i for i, signal in enumerate(adaptation.integrated)}
    kept = {f"{n}_{i}": 0.0 if n == "integral" else float(part.early) for i in integrals.values() for n in _INTEGRAL}

    def sample(x: _Signals, u: _Signals) -> tuple[_Signals, _Signals]:
        signals: _Signals = {v.name: np.zeros(v.size, dtype=object) for v in ours}
        for link in adaptation.outputs:
            for i, place in enumerate(link.theirs):
                signals[link.signal][i] = _applied(link.relation, u[ports.of(place)][0])
        for signal, value in adaptation.constants.items():
            signals[signal][:] = np.ravel(value).astype(float)
        states: _Signals = {}
        for signal, i in integrals.items():
            # where no step leads to the first sample, it is the start
            signals[signal][0] = x[f"integral_{i}"][0] + x[f"begun_{i}"][0] * h * signals[signal][0]
            states |= {f"integral_{i}": [signals[signal][0]], f"begun_{i}": [1.0]}
        _convert(adaptation, signals, to_theirs=False)
        return states, signals

    made = _block(name, (ports.variables, kept, ours), sample, (adaptation, ours, h))
    return Adapter(made, reads=ports.names)


_INTEGRAL: Final = ("integral", "begun")
"""The states of an integral: its value, and whether a step leads to the next sample."""


def _applied(relation: Linear, value: Any, *, back: bool = False) -> Any:
    if relation == IDENTITY:
        return value
    return (relation.inverse if back else relation)(value)


def _limited(value: Any, low: float, high: float) -> Any:
    return value if math.isinf(low) and math.isinf(high) else clip(value, low, high)


def _convert(adaptation: Adaptation, signals: _Signals, *, to_theirs: bool) -> None:
    """Apply the conventions of the buses that are among the signals, in place."""
    for bus, conventions in adaptation.conventions.items():
        views = {n.partition(".")[2]: v for n, v in signals.items() if n.partition(".")[0] == bus}
        for convention in (reversed(conventions) if to_theirs else conventions) if views else ():
            (convention.theirs if to_theirs else convention.ours)(views)


_Sample: TypeAlias = Callable[[_Signals, _Signals], tuple[_Signals, _Signals]]


def _block(
    name: str,
    signals: tuple[Sequence[Variable], Mapping[str, float], Sequence[Variable]],
    sample: _Sample,
    made_from: object,
) -> type[Block[Any, Any, Any]]:
    """The class of a sampled block with these inputs, start values of states, and outputs."""
    kept = [Variable(state, Quantity("1", "kept from sample to sample")) for state in signals[1]]
    inputs, states, outputs = (
        _record(f"{name}_{n}", vs) for n, vs in (("u", signals[0]), ("x", kept), ("y", signals[2]))
    )

    def start(self: Any) -> Any:  # noqa: ARG001 - a method
        return states(**signals[1])

    def one_sample(self: Any, x: Any, u: Any) -> tuple[Any, Any]:  # noqa: ARG001 - a method
        x_next, y = sample(_elements(x), _elements(u))
        return _as_record(states, kept, x_next), _as_record(outputs, signals[2], y)

    body = {
        "__doc__": "Adapter between an FMU and a socket of macrostep.",
        "__module__": __name__,
        "definition": sha256(repr((made_from, signals)).encode()).hexdigest(),
        "start": start,
        "sample": one_sample,
        "name": name,
    }
    cls: Any = types.new_class(name, (Sampled[inputs, states, outputs],), {}, lambda n: n.update(body))
    return block(Socket(name="adapter", inputs=groups(inputs), outputs={}, optional=groups(outputs)))(cls)


def _as_record(kind: Any, members: Sequence[Variable], values: _Signals) -> Any:
    return unpack(kind, joined([element for v in members for element in values[v.name]]))


def _record(name: str, members: Sequence[Variable]) -> Any:
    """A record class with these variables, in which a dot in a name makes a nested record."""
    buses: dict[str, list[Variable]] = {}
    for v in members:
        bus, _, leaf = v.name.rpartition(".")
        buses.setdefault(bus, []).append(replace(v, name=leaf))
    plain = buses.pop("", [])
    annotations: dict[str, Any] = {bus: _record(f"{name}_{bus}", vs) for bus, vs in buses.items()}
    annotations |= {v.name: float for v in plain}
    fields = {v.name: field(metadata={"quantity": v.quantity}) for v in plain}
    return record(type(name, (), {"__doc__": name, "__module__": __name__, "__annotations__": annotations, **fields}))


def _elements(values: Any) -> _Signals:
    """The elements of all signals of a record, in arrays that take numbers and symbols alike."""
    column, at = pack(values), 0
    found: _Signals = {}
    kind: Any = type(values)  # pyright: ignore[reportUnknownVariableType]
    for v in variables(kind):
        found[v.name] = np.empty(v.size, dtype=object)
        for i in range(v.size):
            found[v.name][i] = column[at + i]
        at += v.size
    return found
