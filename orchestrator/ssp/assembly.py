"""What an SSP gives to each unit: what drives its inputs, what they hold otherwise, and its parameters' values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY, Linear, Transformation, unit_conversion
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connection_graph import Driver, Wiring, is_inside
from orchestrator.ssp.connections import Index
from orchestrator.ssp.conversion import constant, joined
from orchestrator.ssp.parameter_values import Value, Values
from orchestrator.ssp.ssp_units import Part, Place
from orchestrator.ssp.types import Declared, Step

_FEW: Final = 4
"""Elements of an array that a remark shows"""

_Piece: TypeAlias = tuple[Index, Value, tuple[Step, ...]]
"""An element, or all of a variable; a value for it; and what happens to that"""


@dataclass(frozen=True)
class _Wire:
    """A connection into a variable, or one element of it."""

    at: Index
    source: tuple[Part, Place]
    total: Transformation
    where: str


@dataclass
class Assembly:
    """The system that an SSP makes of its parts, as far as they are known."""

    findings: Findings
    values: Values
    wires: Wiring
    wiring: dict[str, str] = field(default_factory=dict[str, str])
    transformations: dict[str, Transformation] = field(default_factory=dict[str, Transformation])
    unconverted: set[str] = field(default_factory=set[str])
    held: dict[str, Any] = field(default_factory=dict[str, Any])
    left: list[str] = field(default_factory=list[str])
    """Inputs that nothing drives or sets, with their start values"""
    lines: dict[str, str] = field(default_factory=dict[str, str])
    """Where in the SSP a connection or a value stands, by the paths that problems are told with"""

    def connect(self, part: Part) -> None:
        """Wire all inputs of a unit; those, or their elements, that nothing drives hold a value."""
        for name in [n for n, p in part.places.items() if p.role == "inputs" and not p.at]:
            place = part.places[name]
            drivers = self.wires.drivers(part, place)
            wires = [made for d in drivers if (made := self._wire(d)) is not None]
            for wire in _merged(place.variable, wires):
                self._add(part, place.variable, wire)
            if not {w.at for w in wires} & {None} and {w.at for w in wires} != set(_indices(place.variable)):
                self._hold(part, place.variable, [d for d in drivers if d.part is None], partly=bool(wires))
        for name in [n for n, p in part.places.items() if p.role == "clocks"]:
            for driver in self.wires.drivers(part, part.places[name]):
                if driver.part is not None and driver.place is not None:
                    self.wiring[f"{part.name}.{name}"] = f"{driver.part.name}.{driver.place.variable.name}"

    def _wire(self, driver: Driver) -> _Wire | None:
        """One connection between units; None where its values cannot pass: the findings say why."""
        if driver.part is None or driver.place is None:
            return None
        start = driver.part.declared(driver.place.variable)
        total = joined(start, driver.steps, self.findings)
        return None if total is None else _Wire(driver.at, (driver.part, driver.place), total, driver.steps[0].where)

    def _add(self, part: Part, variable: Variable, wire: _Wire) -> None:
        (giver, place), total = wire.source, wire.total
        target = f"{part.name}.{_element(variable, wire.at)}"
        origin = f"{giver.name}.{_element(place.variable, place.at)}"
        self.wiring[target] = origin
        self.lines |= {f"{origin} -> {target}": wire.where, target: wire.where}
        own = unit_conversion(place.variable.quantity, variable.quantity)
        if isinstance(total, Linear) and own is not None and _close(total, own):
            return
        if isinstance(total, Linear):
            self.unconverted.add(target)
        if total != IDENTITY:
            self.transformations[target] = total

    def _hold(self, part: Part, variable: Variable, open_ends: list[Driver], *, partly: bool) -> None:
        """Give an input that nothing drives, or its other elements, the value that the SSP or the unit has for it."""
        start = part.source.interface.starts.get(variable.name)
        given = self.given(part, variable, open_ends, start)
        path = f"{part.name}.{variable.name}"
        if given is not None:
            self.held[path], self.lines[path] = given[0], given[1].step.where
            return
        if start is None and not part.component.block:
            start = zeros(variable.quantity.type, variable.shape or 1)
            start = start if variable.shape else start.item()
        if start is not None:
            self.held[path] = start.tolist() if isinstance(start, np.ndarray) else start
            if not partly:
                self.left.append(f"{path} = {_short(self.held[path])}")

    def parameters(self, part: Part, only: tuple[str, ...] | None = None) -> dict[str, tuple[Any, Value]]:
        """The values that a unit's parameters get, and where each comes from; those that are connected count last."""
        found: dict[str, tuple[Any, Value]] = {}
        for name in [n for n, p in part.places.items() if p.role == "parameters" and not p.at]:
            if only is not None and name not in only:
                continue
            variable = part.places[name].variable
            drivers = self.wires.drivers(part, part.places[name])
            for driver in drivers:
                if driver.part is not None and driver.place is not None:
                    told = f"`{driver.part.name}.{driver.place.variable.name}` for the parameter `{name}`"
                    self.findings.wrong(driver.steps[-1].where, told, "a value that is known before anything runs")
            start = part.source.interface.starts.get(name)
            given = self.given(part, variable, [d for d in drivers if d.part is None], start)
            if given is not None:
                found[name] = given
        if only is None:
            for name in [n for n, p in part.initials.items() if not p.at]:
                start = part.source.interface.starts.get(name)
                if (given := self.given(part, part.initials[name].variable, [], start)) is not None:
                    found[name] = given
        self.lines |= {f"{part.name}.{name}": value.step.where for name, (_, value) in found.items()}
        return found

    def given(self, part: Part, variable: Variable, open_ends: list[Driver], start: Any) -> tuple[Any, Value] | None:
        """The value of a variable from parameter sets: its own, and over it those of connectors that lead to it.

        Elements that nothing gives keep their `start`.
        """
        whole = np.empty(variable.shape, dtype=object)
        if start is not None:
            whole[...] = start
        last: Value | None = None
        for at, value, steps in [*self._own(part, variable), *self._through(open_ends)]:
            made = constant(value, steps, variable, at, self.findings)
            if made is None:
                continue
            last = value
            if at is None:
                whole[...] = _objects(made, variable.shape)
            else:
                whole[tuple(i - 1 for i in at)] = made
        if last is None:
            return None
        if missing := [at for at in _indices(variable) if whole[tuple(i - 1 for i in at)] is None]:
            names = ", ".join(_element(variable, at) for at in missing)
            self.findings.wrong(last.step.where, f"no value of {names}", f"all elements of `{variable.name}`")
            return None
        return whole.tolist(), last

    def _own(self, part: Part, variable: Variable) -> Iterator[_Piece]:
        for name, value in self.values.variables.get(part.component.path, {}).items():
            place = part.settable(name)
            if place is not None and place.variable.name == variable.name:
                yield place.at, value, (replace(value.step, to=part.declared(variable)),)

    def _through(self, drivers: list[Driver]) -> Iterator[_Piece]:
        for driver in drivers:
            for passed in reversed(driver.passed):  # bindings further out count more
                value = self.values.connectors.get(passed.port)
                connector = self.wires.connector(passed.port)
                if value is not None and connector is not None:
                    picked = _picked(value, passed.at, connector.declared)
                    yield driver.at, picked, (replace(value.step, to=connector.declared), *passed.steps)
                    break


def _merged(variable: Variable, wires: Sequence[_Wire]) -> Sequence[_Wire]:
    """One wire of a whole array in place of those of all its elements, where these come from an array alike."""
    if not variable.size or not variable.shape or {w.at for w in wires} != set(_indices(variable)):
        return wires
    first = wires[0]
    part, place = first.source
    for wire in wires:
        other, there = wire.source
        if (other.name, there.variable.name, wire.total) != (part.name, place.variable.name, first.total):
            return wires
        if there.at != wire.at or there.variable.shape != variable.shape:
            return wires
    return [replace(first, at=None, source=(part, replace(place, at=None)))]


def _indices(variable: Variable) -> list[tuple[int, ...]]:
    """All elements, counted from 1; () for a scalar."""
    return [tuple(i + 1 for i in index) for index in np.ndindex(*variable.shape)]


def _element(variable: Variable, at: Index) -> str:
    return variable.elements[_indices(variable).index(at)] if at else variable.name


def _short(value: Any) -> str:
    """A value as a person reads it; of long arrays the beginning."""
    items = np.ravel(np.array(value, dtype=object)).tolist() if isinstance(value, list) else [value]
    told = ", ".join(str(item) for item in items[:_FEW]) + (", ..." if len(items) > _FEW else "")
    return f"[{told}]" if isinstance(value, list) else told


def _objects(value: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    made = np.empty(shape, dtype=object)
    made[...] = np.array(value, dtype=object).reshape(shape)
    return made


def _picked(value: Value, at: Index, declared: Declared) -> Value:
    """One element of the value of an array connector."""
    if not at:
        return value
    texts = value.texts[0].split() if len(value.texts) == 1 else list(value.texts)
    shape = value.declared.shape or declared.shape or (len(texts),)
    known = is_inside(at, shape) and math.prod(shape) == len(texts)
    one = [texts[int(np.ravel_multi_index([i - 1 for i in at], shape))]] if known else []
    return replace(value, texts=tuple(one), declared=replace(value.declared, shape=()))


def _close(a: Linear, b: Linear) -> bool:
    """Whether two changes of unit are the same, but for the rounding of factors that were multiplied."""
    return math.isclose(a.factor, b.factor, rel_tol=1e-12) and math.isclose(a.offset, b.offset, rel_tol=1e-12)
