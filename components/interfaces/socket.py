"""Sockets: the interface that a unit must have to take the place of another one, whatever it is made from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from typing import Final

from components.interfaces.problem import Problem
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable, variables


class Reading(Enum):
    """How much of an input bus a unit must read to fill its socket."""

    NOTHING = "nothing"
    SOMETHING = "something"
    """At least one signal: without one the unit could not react to the bus at all."""
    EVERYTHING = "everything"
    DESIRED = "desired"
    """Nothing, but a unit that reads nothing causes a remark."""


class Position(Enum):
    """The kinds of reference points that positions on a bus may have in other tools: of a vehicle, or of a box."""

    VEHICLE = "vehicle"
    BOX = "box"


@dataclass(frozen=True)
class BusTraits:
    """The ways in which a bus of a foreign unit may differ from ours, and the role of the bus in its socket."""

    other_names: tuple[str, ...] = ()
    """Names of structures with its signals in foreign files, in lower case without separators."""
    position: Position | None = None
    """The kind of reference point of its positions; `None` for a bus without positions."""
    partial: bool = False
    """Whether its arrays have slots that may be empty, so that shorter arrays fit too."""
    numbered: tuple[str, str] | None = None
    """A signal that is set to 1, 2, ... where it is missing, and the signal whose length gives their number."""
    driven_by: str = ""
    """For an input bus: the output bus that drives it in a system of sockets, as `socket.bus`."""
    must_read: Reading = Reading.NOTHING
    """For an input bus: how much of it a unit must read to fill the socket."""


@dataclass(frozen=True)
class Socket:
    """A role in a system: the buses that a unit in it reads, must offer and may offer, and how it acts in time.

    Args:
        name: The name of the socket in scenarios, systems and commands.
        inputs: Record type of each bus that the unit may read, by the name of the bus.
        outputs: Record type of each bus that the unit must show.
        optional: Record type of each bus that the unit may show.
        traits: The traits of its buses, by name; a bus without an entry has none.
        acts_through_step: Whether inputs act on outputs only through the step, as in a vehicle. An FMU that does not
            declare its dependencies is then assumed to have no direct feedthrough.
        essential: Whether every scenario fills the socket.
        other_names: Other names that other makers give to structures with the signals of a unit in it.
        substitute: The words of the command's help for another unit, such as `Other traffic`; `Another NAME` if not
            given.

    Raises:
        RequestError: A bus is not a record.
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
        """The traits of a bus, given its name or that of one of its signals, such as `state.v_x`."""
        return self.traits.get(name.partition(".")[0], _NO_TRAITS)

    @property
    def wiring(self) -> dict[str, str]:
        """The output bus that drives each input bus in a system of sockets, both as `socket.bus`."""
        return {f"{self.name}.{bus}": source for bus in self.inputs if (source := self.bus(bus).driven_by)}

    def required(self) -> list[Variable]:
        """The output signals that every unit in this socket has."""
        return _signals(self.outputs)

    @property
    def buses(self) -> dict[str, type]:
        """The record types of all buses by name, input buses first."""
        return {**self.inputs, **self.outputs, **self.optional}

    def signals(self, role: str | None = None) -> list[Variable]:
        """The signals that a unit in this socket may have; lengths that are open are `ANY_LENGTH`.

        Args:
            role: `inputs` for the signals that it reads, `outputs` for those that it shows; all if not given.
        """
        read, shown = _signals(self.inputs), [*self.required(), *_signals(self.optional)]
        return {"inputs": read, "outputs": shown}.get(role or "", [*read, *shown])

    def problems(self, unit: str, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> list[Problem]:
        """The reasons why a unit does not fit; it may have outputs of its own, but no inputs of its own.

        Args:
            unit: The name of the unit, for messages.
            inputs: The inputs of the unit.
            outputs: The outputs of the unit.
        """
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
            quantity = declared.get(signal.name)
            if quantity is None:
                if closed:
                    names = ", ".join(sorted(declared))
                    yield Problem(f"{unit}.{signal.name}", f"an {role} unknown to the socket `{self.name}`", names)
            elif not _agrees(quantity, signal.quantity):
                yield Problem(f"{unit}.{signal.name}", describe(signal.quantity), describe(quantity))


_NO_TRAITS: Final = BusTraits()


def _signals(buses: Mapping[str, type]) -> list[Variable]:
    return [signal for name, kind in buses.items() for signal in _bus_signals(name, kind)]


@lru_cache(maxsize=256)  # a system may have a thousand units of one socket
def _bus_signals(name: str, kind: type) -> tuple[Variable, ...]:
    return variables(kind, _AnyLength(), prefix=f"{name}.")


class _AnyLength(dict[str, int]):
    """Structural constants for a socket, where lengths that depend on the block, such as the horizon, are open."""

    def __missing__(self, key: str) -> int:
        return ANY_LENGTH


ANY_LENGTH = -1
"""The length of an array where any length fits."""


def _agrees(wanted: Quantity, found: Quantity) -> bool:
    same_shape = len(wanted.shape) == len(found.shape) and all(
        ANY_LENGTH in (a, b) or a == b for a, b in zip(wanted.shape, found.shape, strict=True)
    )
    return same_shape and found.unit in (wanted.unit, "") and wanted.type == found.type


def describe(q: Quantity) -> str:
    """The type, the unit of measurement and the shape of a quantity, in words."""
    shape = "" if not q.shape else f" of shape ({', '.join('any' if n == ANY_LENGTH else str(n) for n in q.shape)})"
    unit = f" in `{q.unit}`" if q.unit else (" without a unit" if q.type.is_float else "")
    return f"{q.type}{unit}{shape}"
