"""Units: running blocks behind one interface, whatever they are made of.

The guaranteed order of calls: `bind`, `enter_initialization`, any of `set` and `get`, `exit_initialization`, then per
macro step `set`, `step` and `get` in the order of the schedule, and `close` once at the end, whatever happened.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, TypeAlias

from numpy.typing import NDArray

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.unit_interface import Interface

Column: TypeAlias = NDArray[Any]
Operation: TypeAlias = Callable[[], object]
"""One call that moves values; it returns a false value, or the FMI status that it met."""

FMI_WARNING: Final = 1
"""The worst status that is no failure"""


class UnitError(RuntimeError):
    """A unit that could not do what it was asked: which one, what, and what it said about it."""

    def __init__(self, unit: str, action: str, said: Sequence[str]) -> None:
        self.unit = unit
        self.action = action
        self.said = tuple(said)
        super().__init__(f"{unit}: {action}" + (f": {'; '.join(said)}" if said else ""))


class Unit(ABC):
    """A running block. Values pass through the columns it is bound to, one per type, without copies on the way."""

    def __init__(self, name: str, interface: Interface) -> None:
        self.name = name
        self.interface = interface
        self.messages: list[str] = []

    @abstractmethod
    def bind(self, inputs: Mapping[Type, Column], outputs: Mapping[Type, Column]) -> None:
        """The memory that `set` reads and `get` writes, one column per type, in the order of the interface."""

    @abstractmethod
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        """Make the unit ready for start values. Raises `UnitError`."""

    @abstractmethod
    def exit_initialization(self) -> None:
        """End the initialisation. Raises `UnitError`."""

    @abstractmethod
    def setters(self) -> list[Operation]:
        """The calls that take in all inputs."""

    @abstractmethod
    def getters(self) -> list[Operation]:
        """The calls that show all outputs."""

    @abstractmethod
    def step(self, t: float, h: float) -> object:
        """Advance from `t` to `t + h`; returns a false value, or the FMI status that it met."""

    def use_events(self, h: float) -> None:
        """Use Event Mode from now on, with macro step `h`; said once, before `bind`. Raises `UnitError`."""
        raise NotImplementedError

    def activate(self, t: float, h: float) -> object:
        """Enter Event Mode at `t`, with the clocks that are due or were triggered. Raises `UnitError`."""
        raise NotImplementedError

    def update(self, t: float, h: float) -> object:
        """Iterate the discrete states, and end what `activate` began. Raises `UnitError`."""
        raise NotImplementedError

    def fired(self) -> set[str]:
        """The output clocks that have ticked since this was asked last."""
        raise NotImplementedError

    def trigger(self, clock: str) -> None:
        """Make a triggered input clock tick when the unit is activated next."""
        raise NotImplementedError

    def save(self) -> Any:
        """The present state, for `restore`. Raises `UnitError`."""
        raise NotImplementedError

    def restore(self, state: Any) -> None:
        """Go back to a state that was saved. Raises `UnitError`."""
        raise NotImplementedError

    def forget(self, state: Any) -> None:
        """Release a saved state. Raises `UnitError`."""
        del state

    @abstractmethod
    def close(self) -> None:
        """Release everything."""


def by_type(variables: Sequence[Variable]) -> dict[Type, list[Variable]]:
    """Variables grouped by type, in order; types that do not occur are left out."""
    found: dict[Type, list[Variable]] = {}
    for variable in variables:
        found.setdefault(variable.quantity.type, []).append(variable)
    return found


def positions(variables: Sequence[Variable]) -> dict[str, tuple[Type, int]]:
    """For every variable its type and the place of its first element in the column of that type."""
    found: dict[str, tuple[Type, int]] = {}
    for kind, group in by_type(variables).items():
        at = 0
        for variable in group:
            found[variable.name] = (kind, at)
            at += variable.size
    return found


def views(variables: Sequence[Variable], columns: Mapping[Type, Column]) -> dict[str, Column]:
    """The elements of every variable, as a view of the column that holds them."""
    sizes = {v.name: v.size for v in variables}
    return {name: columns[kind][at : at + sizes[name]] for name, (kind, at) in positions(variables).items()}


def carry_out(operations: Iterable[Operation]) -> int:
    """Carry out operations up to the first that fails; the worst status that they met."""
    worst = 0
    for operation in operations:
        status = operation()
        worst = max(worst, status if isinstance(status, int) else 0)
        if worst > FMI_WARNING:
            break
    return worst


def widths(variables: Sequence[Variable]) -> dict[Type, int]:
    """Number of elements of each type."""
    return {kind: sum(v.size for v in group) for kind, group in by_type(variables).items()}
