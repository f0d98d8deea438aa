"""Connections through systems in systems, followed back to what drives each input and each parameter of a unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from components.interfaces.problem import did_you_mean
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connections import Connector, Index, Port, Wire
from orchestrator.ssp.ssp_units import Part, Place
from orchestrator.ssp.structure import Group
from orchestrator.ssp.types import Step


@dataclass(frozen=True)
class Passed:
    """A connector on the way: what happens from there on, to all of it or to one element."""

    port: Port
    at: Index
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class Driver:
    """What a variable, or one element of it, is connected to."""

    at: Index
    """The element that is driven; None for the whole variable"""
    part: Part | None
    """The unit that drives it; None where the way ends at a connector of a system"""
    place: Place | None
    passed: tuple[Passed, ...]
    """Connectors on the way, the nearest first; the last is that of the unit"""

    @property
    def steps(self) -> tuple[Step, ...]:
        """What happens on the whole way."""
        return self.passed[-1].steps


class Wiring:
    """All connections of an SSP."""

    def __init__(self, root: Group, parts: Mapping[tuple[str, ...], Part], findings: Findings) -> None:
        self._parts, self._findings = parts, findings
        self._elements = {element.path: element for element in root.walk()}
        self._arriving: dict[Port, list[Wire]] = {}
        for group in (e for e in root.walk() if isinstance(e, Group)):
            for wire in group.wires:
                self._arriving.setdefault(self._normal(wire.target), []).append(wire)

    def connector(self, port: Port) -> Connector | None:
        """A connector of a system."""
        element = self._elements.get(port[0])
        return None if element is None else element.connectors.get(port[1])

    def _place(self, port: Port) -> Place | None:
        part = self._parts.get(port[0])
        return part.places.get(port[1]) if part else None

    def _normal(self, port: Port) -> Port:
        """The variable's port, where a connector is one element of it."""
        place = self._place(port)
        return port if place is None else (port[0], place.variable.name)

    def _at(self, wire: Wire, port: Port, at: Index) -> Index:
        """The element that one end of a wire means."""
        place, connector = self._place(port), self.connector(port)
        own = None if place is None else place.at
        if at is None:
            return own
        said = connector.declared.shape if connector is not None else None
        shape = said or () if place is None else place.shape
        if place is None and not shape:  # a system may leave the lengths open
            return at
        if own or not is_inside(at, shape):
            told = f"the element {' '.join(map(str, at))} of `{port[1]}`"
            lengths = " x ".join(map(str, shape))
            valid = f"an element of {lengths}" if shape else "no element: it is a scalar"
            self._findings.wrong(wire.step.where, told, valid)
            return own
        return at

    def drivers(self, part: Part, place: Place) -> list[Driver]:
        """What drives a variable: nothing, one driver of all of it, or those of its elements."""
        port = (part.component.path, place.variable.name)
        wires = self._arriving.get(port, [])
        ends = [self._at(wire, wire.target, wire.target_at) for wire in wires]
        for i, at in enumerate(ends):
            taken = next((j for j, before in enumerate(ends[:i]) if at in (before, None) or before is None), None)
            if taken is not None:
                told = f"a second source of `{part.name}.{wires[i].target[1]}`"
                self._findings.wrong(wires[i].step.where, told, f"one source, as in {wires[taken].step.where}")
                return []
        found: list[Driver] = []
        for wire, at in zip(wires, ends, strict=True):
            steps = (self._last(wire, part, place),)
            if at is None and self._splits(wire):
                for index in np.ndindex(*place.variable.shape):
                    one = tuple(i + 1 for i in index)
                    found += self._follow(wire, one, one, steps)
            else:
                found += self._follow(wire, at, None if at is None else (), steps)
        return found

    @staticmethod
    def _last(wire: Wire, part: Part, place: Place) -> Step:
        """The step into a unit, whose own variable says what is expected."""
        step = wire.step
        return Step(step.where, step.change, step.as_it_is, part.declared(place.variable))

    def _splits(self, wire: Wire, seen: frozenset[Port] = frozenset()) -> bool:
        """Whether the way of a whole array is that of its elements somewhere."""
        if wire.source_at is not None or self._place(wire.source) or wire.source in seen:
            return False
        before = self._arriving.get(wire.source, [])
        return any(w.target_at is not None or self._splits(w, seen | {wire.source}) for w in before)

    def _follow(self, wire: Wire, at: Index, wanted: Index, steps: tuple[Step, ...]) -> Iterator[Driver]:
        """Go back along a wire to the unit that it comes from; `wanted` is the element, () where that is a scalar."""
        passed: list[Passed] = []
        seen: set[tuple[Port, Index]] = set()
        while True:
            source = wire.source
            here = self._at(wire, source, wire.source_at) or (wanted or None)
            passed.append(Passed(source, here, steps))
            if source[0] not in self._elements or isinstance(self._elements[source[0]], Group):
                before = self._arriving.get(source, [])
                found = [w for w in before if w.target_at in (None, here)]
                if len(found) > 1:
                    told = f"a second source of the connector `{source[1]}`"
                    self._findings.wrong(found[1].step.where, told, f"one source, as in {found[0].step.where}")
                if not found or (source, here) in seen:
                    if found:
                        self._findings.wrong(wire.step.where, "connections in a circle", "a way from a unit to a unit")
                    yield Driver(at, None, None, tuple(passed))
                    return
                seen.add((source, here))
                wire = found[0]
                wanted = here if wire.target_at is None else ()
                steps = (wire.step, *steps)
                continue
            yield from self._end(wire, at, here, passed)
            return

    def _end(self, wire: Wire, at: Index, here: Index, passed: Sequence[Passed]) -> Iterator[Driver]:
        """The unit that a way begins at."""
        path, name = wire.source
        part = self._parts.get(path)
        if part is None:
            return  # its component cannot be used: told already
        place = part.places.get(name)
        if place is not None and here and not is_inside(here, place.variable.shape):
            told = f"one element for `{part.name}.{name}` of shape {place.variable.shape}"
            self._findings.wrong(wire.step.where, told, "arrays of one shape, or scalars")
        elif place is not None and place.role in ("outputs", "clocks"):
            yield Driver(at, part, Place(place.role, place.variable, here), tuple(passed))
        elif part.has(name):
            told = f"`{part.name}.{name}`, which is not an output"
            self._findings.wrong(wire.step.where, told, "an output: a master reads nothing else while it runs")
        else:
            close = did_you_mean(name, part.places)
            self._findings.wrong(wire.step.where, f"no variable `{name}` of `{part.name}`", "one that it has", close)


def is_inside(at: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    """Whether an array of this shape has an element, counted from 1."""
    return len(at) == len(shape) and all(1 <= i <= n for i, n in zip(at, shape, strict=True))
