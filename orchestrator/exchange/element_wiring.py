"""The wiring of a system element by element, for systems whose units are exchanged for others with other variables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from components.interfaces.conversion import IDENTITY, Linear, Transformation, unit_conversion
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System


class Place(NamedTuple):
    """An element of a variable of a unit; the only one of a scalar has the index 0."""

    unit: str
    variable: str
    element: int = 0


@dataclass(frozen=True)
class Feed:
    """What an element of an input receives: an element of an output, converted, or a constant value."""

    origin: Place | None
    value: Any = None
    """The constant value, in the input's unit of measurement, where there is no origin."""
    conversion: Transformation = IDENTITY

    def then(self, relation: Linear) -> Feed:
        """The same, with a conversion of the result; tables are of values that have no conversion."""
        if relation == IDENTITY:
            return self
        if self.origin is None:
            return replace(self, value=relation(self.value))
        assert isinstance(self.conversion, Linear)  # noqa: S101 - a table gives no number with a unit of measurement
        return replace(self, conversion=relation.after(self.conversion))

    def after(self, origin: Place, relation: Linear) -> Feed:
        """The same from another origin, from which the present one follows by a conversion."""
        if relation == IDENTITY:
            return replace(self, origin=origin)
        assert isinstance(self.conversion, Linear)  # noqa: S101 - as above
        return replace(self, origin=origin, conversion=self.conversion.after(relation))

    def constant(self, value: Any) -> Feed:
        """The same where the present origin always has this value."""
        return Feed(None, value if self.conversion == IDENTITY else self.conversion(np.array([value])).item())


Wiring: TypeAlias = dict[Place, Feed]
"""What each element of each input receives; inputs that keep their own values have no entry."""


def elements(unit: str, variable: Variable) -> list[Place]:
    """All elements of a variable of a unit."""
    return [Place(unit, variable.name, i) for i in range(variable.size)]


def flat(value: Any) -> list[Any]:
    """The elements of a value, which may be an array or a list of any shape."""
    return np.asarray(value, dtype=object).ravel().tolist()  # pyright: ignore[reportUnknownVariableType]


def wiring_of(system: System) -> Wiring:
    """The wiring of a system, and the values that its inputs are held at."""
    found: Wiring = {}
    for path, value in system.held.items():
        places = elements(path.partition(".")[0], system.variable(path, role="inputs"))
        found |= {place: Feed(None, one) for place, one in zip(places, flat(value), strict=True)}
    for wire in system.connections:
        ends = elements(wire.unit, system.variable(f"{wire.unit}.{wire.input}", role="inputs"))
        starts = elements(wire.source, system.variable(f"{wire.source}.{wire.output}"))
        ends = ends if wire.input_element is None else [ends[wire.input_element.at]]
        starts = starts if wire.output_element is None else [starts[wire.output_element.at]]
        for end, start in zip(ends, starts, strict=True):
            found[end] = Feed(start, conversion=wire.conversion)
    return found


def rewired(system: System, units: Mapping[str, UnitSource], wiring: Wiring, allow_nonfinite: Sequence[str]) -> System:
    """A system with other units and the wiring between them.

    Args:
        system: The system that it is made from; the sockets of units that have been exchanged are empty.
        units: The units.
        wiring: What their inputs receive.
        allow_nonfinite: The patterns of the signals that may be infinite or not a number.

    Raises:
        RequestError: The wiring does not fit the units.
    """
    shown = {Place(n, v.name): v for n, source in units.items() for v in source.interface.outputs}
    inputs = [(n, source, v) for n, source in units.items() for v in source.interface.inputs]
    driven = {end: drive for n, _, v in inputs for end, drive in _driven(n, v, wiring, shown)}
    held = {f"{n}.{v.name}": value for n, source, v in inputs if (value := _held(source, n, v, wiring)) is not None}
    connected = {Place(end.unit, end.variable) for end, drive in wiring.items() if drive.origin}
    return System(
        units=units,
        wiring={end: origin for end, (origin, _) in driven.items()}
        | {c.target: c.origin for c in system.clock_connections},
        held=held,
        sockets={n: socket for n, socket in system.sockets.items() if units.get(n) is system.units[n]},
        transformations={end: own for end, (_, own) in driven.items() if own not in (None, IDENTITY)},
        unconverted={end for end, (_, own) in driven.items() if isinstance(own, Linear)},
        unset={
            f"{n}.{v.name}" for n, _, v in inputs if f"{n}.{v.name}" not in held and Place(n, v.name) not in connected
        },
        steps=system.steps,
        table=system.table,
        allow_nonfinite=allow_nonfinite,
    )


def _driven(
    unit: str, variable: Variable, wiring: Wiring, shown: Mapping[Place, Variable]
) -> Iterator[tuple[str, tuple[str, Transformation | None]]]:
    """The paths of an input, or of its elements, that are driven; of what drives them; and conversions of their own.

    The last is `None` where it is the conversion of the units of measurement.
    """
    drives = [wiring.get(place) for place in elements(unit, variable)]
    whole = _whole(drives, variable, shown)
    names = {variable.name: whole} if whole else dict(zip(variable.elements, drives, strict=True))
    for name, drive in names.items():
        if drive is None or drive.origin is None:
            continue
        output = shown[drive.origin._replace(element=0)]
        origin = output.name if whole else output.elements[drive.origin.element]
        same = drive.conversion == unit_conversion(output.quantity, variable.quantity)
        yield f"{unit}.{name}", (f"{drive.origin.unit}.{origin}", None if same else drive.conversion)


def _whole(drives: Sequence[Feed | None], variable: Variable, shown: Mapping[Place, Variable]) -> Feed | None:
    """What drives a whole array, where that is a whole array too; else `None`."""
    first = drives[0] if variable.shape and drives else None
    if first is None or first.origin is None or shown[first.origin._replace(element=0)].shape != variable.shape:
        return None
    expected = [replace(first, origin=first.origin._replace(element=i)) for i in range(variable.size)]
    return first if drives == expected else None


def _held(source: UnitSource, unit: str, variable: Variable, wiring: Wiring) -> Any:
    """The value that an input, or what nothing drives of it, is held at; `None` where it keeps what its unit has."""
    drives = [wiring.get(place) for place in elements(unit, variable)]
    start = source.interface.starts.get(variable.name)
    if all(drive and drive.origin for drive in drives) or (start is None and not any(drives)):
        return None
    own = zeros(variable.quantity.type, variable.size) if start is None else flat(start)
    values = [drive.value if drive and not drive.origin else own[i] for i, drive in enumerate(drives)]
    plain: list[Any] = [value.item() if isinstance(value, np.generic) else value for value in values]
    return np.array(plain, dtype=object).reshape(variable.shape).tolist() if variable.shape else plain[0]
