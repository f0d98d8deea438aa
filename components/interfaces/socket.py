"""Sockets: what a unit must offer to stand in for another, whatever it is made of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from components.interfaces.problem import Problem
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable, variables


class Reading(Enum):
    """How much of an input bus a unit must read to fill its socket."""

    NOTHING = "nothing"
    SOMETHING = "something"
    """At least one signal: without any the unit would be blind."""
    EVERYTHING = "everything"
    DESIRED = "desired"
    """Nothing, but a unit that reads nothing is worth a remark."""


class Position(Enum):
    """What the positions on a bus may refer to in other tools: points of a vehicle, or ends of a box."""

    VEHICLE = "vehicle"
    BOX = "box"


@dataclass(frozen=True)
class BusTraits:
    """What units of other makers may do differently with a bus, and what a socket makes of it when it is read."""

    other_names: tuple[str, ...] = ()
    """What structures of other makers are called that hold its signals, in lower case without separators."""
    position: Position | None = None
    """What its positions may refer to; `None` where it has none."""
    partial: bool = False
    """Whether its arrays have slots that may stay empty, so that shorter arrays fit too."""
    numbered: tuple[str, str] | None = None
    """A signal that is 1, 2, ... where it is missing, and the signal whose length says how many."""
    driven_by: str = ""
    """For an input bus: the output bus that drives it in a system of sockets, as `socket.bus`."""
    must_read: Reading = Reading.NOTHING
    """For an input bus: how much of it a unit must read to fill the socket."""


@dataclass(frozen=True)
class Socket:
    """A role in a system: the buses that a unit in it reads, must offer and may offer, and how it acts in time.

    Args:
        name: What the socket is called in scenarios, systems and commands.
        inputs: Record type of each bus that the unit may read, by the name of the bus.
        outputs: Record type of each bus that the unit must show.
        optional: Record type of each bus that the unit may show.
        traits: What else is known of its buses, by name; a bus without an entry has no special traits.
        acts_through_step: Whether inputs act on outputs through the step only, as the state of a vehicle does: an FMU
            that leaves its dependencies open is then taken to have no direct feedthrough.
        essential: Whether every scenario fills the socket.
        other_names: What else structures of other makers are called that hold the signals of a unit in it.
        substitute: What the command calls a different unit for the socket, such as `Other traffic`; `Another NAME` if
            not given.

    Raises:
        RequestError: When a bus is not a record.
    """

    name: str
    inputs: Mapping[str, type]
    outputs: Mapping[str, type]
    optional: Mapping[str, type] = field(default_factory=dict[str, type])
    traits: Mapping[str, BusTraits] = field(default_factory=dict[str, BusTraits])
    acts_through_step: bool = False
    essential: bool = False
    other_names: tuple[str, ...] = ()
    substitute: str = ""

    def bus(self, name: str) -> BusTraits:
        """The traits of a bus by its name, or of the bus that a signal (`state.v_x`) belongs to."""
        return self.traits.get(name.partition(".")[0], _NO_TRAITS)

    @property
    def wiring(self) -> dict[str, str]:
        """What drives each input bus in a system of sockets: `socket.bus` by `socket.bus`."""
        return {f"{self.name}.{bus}": source for bus in self.inputs if (source := self.bus(bus).driven_by)}

    def required(self) -> list[Variable]:
        """The output signals every unit in this socket has."""
        return _signals(self.outputs)

    @property
    def buses(self) -> dict[str, type]:
        """All buses by name, those that are read first."""
        return {**self.inputs, **self.outputs, **self.optional}

    def signals(self, role: str | None = None) -> list[Variable]:
        """What a unit in this socket may read (`inputs`) or show (`outputs`), or all; open lengths are -1."""
        read, shown = _signals(self.inputs), [*self.required(), *_signals(self.optional)]
        return {"inputs": read, "outputs": shown}.get(role or "", [*read, *shown])

    def problems(self, unit: str, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> list[Problem]:
        """What keeps a unit with these signals from fitting; inputs and outputs of its own are allowed for."""
        return [
            *self._missing(unit, "output", self.required(), outputs),
            *self._wrong(unit, "input", [*_signals(self.inputs)], inputs, closed=True),
            *self._wrong(unit, "output", [*self.required(), *_signals(self.optional)], outputs, closed=False),
        ]

    def _missing(self, unit: str, role: str, wanted: list[Variable], offered: Sequence[Variable]) -> Iterator[Problem]:
        names = {v.name for v in offered}
        for signal in wanted:
            if signal.name not in names:
                text = f"an {role} `{signal.name}` ({describe(signal.quantity)}), as the socket `{self.name}` asks for"
                yield Problem(f"{unit}.{signal.name}", "nothing", text)

    def _wrong(
        self, unit: str, role: str, known: list[Variable], offered: Sequence[Variable], *, closed: bool
    ) -> Iterator[Problem]:
        declared = {v.name: v.quantity for v in known}
        for signal in offered:
            wanted = declared.get(signal.name)
            if wanted is None:
                if closed:
                    names = ", ".join(sorted(declared))
                    yield Problem(f"{unit}.{signal.name}", f"an {role} unknown to the socket `{self.name}`", names)
            elif not _agrees(wanted, signal.quantity):
                yield Problem(f"{unit}.{signal.name}", describe(signal.quantity), describe(wanted))


_NO_TRAITS: Final = BusTraits()


def _signals(buses: Mapping[str, type]) -> list[Variable]:
    found: list[Variable] = []
    for name, kind in buses.items():
        found.extend(variables(kind, _AnyLength(), prefix=f"{name}."))
    return found


class _AnyLength(dict[str, int]):
    """A length that depends on the block (the horizon, say) is open in the socket."""

    def __missing__(self, key: str) -> int:
        return ANY_LENGTH


ANY_LENGTH = -1


def _agrees(wanted: Quantity, found: Quantity) -> bool:
    same_shape = len(wanted.shape) == len(found.shape) and all(
        ANY_LENGTH in (a, b) or a == b for a, b in zip(wanted.shape, found.shape, strict=True)
    )
    return same_shape and found.unit in (wanted.unit, "") and wanted.type == found.type


def describe(q: Quantity) -> str:
    """Type, unit and shape of a quantity as text."""
    shape = "" if not q.shape else f" of shape ({', '.join('any' if n == ANY_LENGTH else str(n) for n in q.shape)})"
    unit = f" in `{q.unit}`" if q.unit else (" without a unit" if q.type.is_float else "")
    return f"{q.type}{unit}{shape}"
