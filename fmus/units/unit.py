"""Units: running blocks behind one interface, whatever they are made of.

The guaranteed order of calls: `bind`, `enter_initialization`, any of the setters and getters, `exit_initialization`,
then per macro step setters, `step` and getters in the order of the schedule, and `close` once at the end, whatever
happened. What only some units can do is a capability: `fmus.units.capabilities`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, TypeAlias

from numpy.typing import NDArray

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from fmus.units.capabilities import EventCapability, StateCapability

Column: TypeAlias = NDArray[Any]
"""Values of one type, of shape (n,)."""
TypedColumns: TypeAlias = Mapping[Type, Column]
"""A column for each type that occurs."""
Operation: TypeAlias = Callable[[], object]
"""One call that moves values; it returns a false value, or the FMI status that it met."""

FMI_WARNING: Final = 1
"""The worst status that is no failure."""


class UnitError(RuntimeError):
    """A unit that could not carry out a call.

    Args:
        unit: Name of the unit.
        action: What could not be done.
        said: The messages of the unit about it.
    """

    def __init__(self, unit: str, action: str, said: Sequence[str]) -> None:
        self.unit = unit
        self.action = action
        self.said = tuple(said)
        super().__init__(f"{unit}: {self.reason}")

    @property
    def reason(self) -> str:
        """What could not be done and why, without the name of the unit."""
        return self.action + (f": {'; '.join(self.said)}" if self.said else "")


class Unit(ABC):
    """A running block. Values pass through the columns that it is bound to, one per type, without further copies.

    Args:
        name: The name in the system, for messages.
        interface: What is known of the unit before it runs.
    """

    def __init__(self, name: str, interface: Interface) -> None:
        self.name = name
        self.interface = interface
        self.messages: list[str] = []
        """The messages of the unit so far, oldest first."""
        self.events: EventCapability | None = None
        """Event Mode; `None` for a unit that does not have it."""
        self.state: StateCapability | None = None
        """Saving and restoring of states; `None` for a unit that does not have it."""

    @abstractmethod
    def bind(self, inputs: TypedColumns, outputs: TypedColumns) -> None:
        """Use other memory from now on; setters and getters have to be requested again.

        Args:
            inputs: The columns that the setters read, variables in the order of the interface.
            outputs: The columns that the getters write, likewise.
        """

    @abstractmethod
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        """Make the unit ready for start values.

        Args:
            parameters: Values by name; the others keep the start values of the unit itself.

        Raises:
            UnitError: The unit refuses a value, or cannot be initialised.
        """

    @abstractmethod
    def exit_initialization(self) -> None:
        """End the initialisation. Raises `UnitError`."""

    @abstractmethod
    def setters(self) -> list[Operation]:
        """The calls that give the unit all its inputs, valid until the next `bind`."""

    @abstractmethod
    def getters(self) -> list[Operation]:
        """The calls that fetch all outputs of the unit, valid until the next `bind`."""

    @abstractmethod
    def step(self, t: float, h: float) -> object:
        """Advance from `t` to `t + h` [s].

        Returns:
            A false value, or the FMI status that was met.

        Raises:
            UnitError: The unit cannot go on, and a status would not say why.
        """

    @abstractmethod
    def close(self) -> None:
        """Release everything that the unit holds. No other call may follow."""


def by_type(variables: Sequence[Variable]) -> dict[Type, list[Variable]]:
    """Variables grouped by type, in order; types that do not occur are left out."""
    groups: dict[Type, list[Variable]] = {}
    for variable in variables:
        groups.setdefault(variable.quantity.type, []).append(variable)
    return groups


def positions(variables: Sequence[Variable]) -> dict[str, tuple[Type, int]]:
    """For every variable its type and the index of its first element in the column of that type."""
    places: dict[str, tuple[Type, int]] = {}
    for kind, group in by_type(variables).items():
        at = 0
        for variable in group:
            places[variable.name] = (kind, at)
            at += variable.size
    return places


def views(variables: Sequence[Variable], columns: TypedColumns) -> dict[str, Column]:
    """The elements of every variable, as a view of the column that holds them."""
    sizes = {v.name: v.size for v in variables}
    return {name: columns[kind][at : at + sizes[name]] for name, (kind, at) in positions(variables).items()}


def widths(variables: Sequence[Variable]) -> dict[Type, int]:
    """Number of elements of each type."""
    return {kind: sum(v.size for v in group) for kind, group in by_type(variables).items()}


def carry_out(operations: Iterable[Operation]) -> int:
    """Carry out operations up to the first that fails, and return the worst status."""
    worst = 0
    for operation in operations:
        status = operation()
        worst = max(worst, status if isinstance(status, int) else 0)
        if worst > FMI_WARNING:
            break
    return worst
