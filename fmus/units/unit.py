"""Units: running blocks behind one interface, whatever they are made of.

The guaranteed order of calls: `bind`, `enter_initialization`, any of the setters and getters, `exit_initialization`,
then per macro step setters, `step` and getters in the order of the schedule, `terminate` if the unit has not failed,
and `close` once at the end, whatever happened. After `reset` all begins anew with `bind`. What only some units can do
is a capability: `fmus.units.capabilities`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from numpy.typing import NDArray
from typing_extensions import override

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.toolchain.limits import MOST_REMARKS
from fmus.unit_interface import Interface
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.message_log import MessageLog

if TYPE_CHECKING:
    from fmus.units.prepared_calls import StepCall

Column: TypeAlias = NDArray[Any]
"""Values of one type, of shape (n,)."""
TypedColumns: TypeAlias = Mapping[Type, Column]
"""A column for each type that occurs."""
Operation: TypeAlias = Callable[[], object]
"""One call that moves values; it returns a false value, or the FMI status that it met."""

FMI_WARNING: Final = 1
"""The worst status that is no failure."""


def is_failure(status: object) -> bool:
    """Whether what a call returned is the FMI status of a failure: any but OK and Warning, whatever FMI knows."""
    return isinstance(status, int) and not 0 <= status <= FMI_WARNING


@dataclass(frozen=True)
class ExperimentSetup:
    """The experiment as far as a unit is told of it."""

    start: float = 0.0
    """[s] The time at which the run begins."""
    stop: float | None = None
    """[s] The time at which the run ends, if it is known."""
    tolerance: float | None = None
    """The relative tolerance that a person wants; the unit's own where there is none."""


DEFAULT_SETUP: Final = ExperimentSetup()
"""An experiment that begins at 0 s, of which nothing else is known."""


class EndRequested(Exception):  # noqa: N818 - no error: the unit's model ends here
    """A unit that asks for the end of the run, such as by `terminate()` in Modelica. Its outputs may still be read.

    Args:
        unit: Name of the unit.
        time: The time that the unit has reached [s].
    """

    def __init__(self, unit: str, time: float) -> None:
        self.unit, self.time = unit, time
        super().__init__(unit, time)  # so that it can be sent to another process

    @override
    def __str__(self) -> str:
        return f"`{self.unit}` asked for the end of the run at {self.time:g} s"


class UnitError(RuntimeError):
    """A unit that could not carry out a call.

    Args:
        unit: Name of the unit.
        action: What could not be done.
        said: The messages of the unit about it.
    """

    def __init__(self, unit: str, action: str, said: Sequence[str] | MessageLog) -> None:
        self.unit = unit
        self.action = action
        self.said = tuple(said.said() if isinstance(said, MessageLog) else said)
        super().__init__(f"{unit}: {self.reason}")

    @property
    def reason(self) -> str:
        """What could not be done and why, without the name of the unit."""
        return self.action + (f": {'; '.join(self.said)}" if self.said else "")


class NoResetError(UnitError):
    """A unit that has no way back to its start, and is opened again instead."""


class Unit(ABC):
    """A running block. Values pass through the columns that it is bound to, one per type, without further copies.

    Args:
        name: The name in the system, for messages.
        interface: What is known of the unit before it runs.
    """

    def __init__(self, name: str, interface: Interface) -> None:
        self.name = name
        self.interface = interface
        self.messages = MessageLog()
        """The last messages of the unit."""
        self.remarks: list[str] = []
        """What a person should know of how the unit was run, beyond what could be known before."""
        self.called: Callable[[], str] = str
        """Gives the function of FMI that was called last; nothing where that is not known."""
        self.warnings = 0
        """How many calls have returned a warning."""
        self.events: EventCapability | None = None
        """Event Mode; `None` for a unit that does not have it."""
        self.state: StateCapability | None = None
        """Saving and restoring of states; `None` for a unit that does not have it."""

    def remark(self, text: str) -> None:
        """Note what a person should know of how the unit was run, once, and to a limit."""
        if text not in self.remarks and len(self.remarks) < MOST_REMARKS:
            self.remarks.append(text)

    def warned(self, status: object = FMI_WARNING, function: str = "it") -> None:
        """Note a call that returned the status of a warning, with what the unit says; the first one is a remark."""
        if status == FMI_WARNING:
            self.warnings += 1
            if self.warnings == 1:
                said = "; ".join(self.messages.said())
                self.remark(f"{function} returned a warning" + (f": {said}" if said else ""))

    def tell_messages(self) -> None:
        """Note what the unit wrote without having failed, and how often it warned; called once, at the end."""
        if self.warnings > 1:
            self.remark(f"its calls returned {self.warnings} warnings in all")
        elif self.messages and not self.warnings:
            self.remark(f"it wrote: {'; '.join(self.messages.said())}")

    @abstractmethod
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        """Use other memory from now on; setters and getters have to be requested again.

        Args:
            inputs: The columns that the setters read, variables in the order of the interface.
            outputs: The columns that the getters write, likewise.
            unset: Names of inputs that the setters leave alone, because nobody has a value for them.
        """

    @abstractmethod
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        """Make the unit ready for start values.

        Args:
            parameters: Values by name; the others keep the start values of the unit itself.
            setup: The experiment.

        Raises:
            UnitError: The unit refuses a value, or cannot be initialised.
        """

    @abstractmethod
    def exit_initialization(self) -> None:
        """End the initialisation. Raises `UnitError`, and `EndRequested`."""

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
            EndRequested: The unit has come to its end, at `t + h` or before.
        """

    @property
    def step_call(self) -> StepCall | None:
        """What `step` comes to where it is one call of a library and usually nothing else, for the native stepper."""
        return None

    def tune(self, parameter: str, value: Any) -> None:  # noqa: ARG002 - of those that have one
        """Give a tunable parameter another value between two steps; it acts from the next one on.

        Args:
            parameter: One of `Interface.tunable`.
            value: A value of the parameter's quantity.

        Raises:
            UnitError: The unit refuses the value.
        """
        raise UnitError(self.name, f"has no parameter `{parameter}` that can be changed while it runs", ())

    @abstractmethod
    def terminate(self) -> None:
        """End the simulation in order; not called for a unit that has failed. Raises `UnitError`."""

    def reset(self) -> None:
        """Return to where the unit was before `bind`, from wherever it is, without what it has said since.

        Raises:
            NoResetError: The unit cannot do this.
            UnitError: It has failed to; only `close` may follow.
        """
        raise NoResetError(self.name, "it has no reset", ())

    def _forget_calls(self) -> None:
        """Forget what the unit has said, and that it has warned."""
        self.messages.clear()
        self.warnings = 0

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
        if status and isinstance(status, int):
            worst = status
            if is_failure(status):
                break
    return worst
