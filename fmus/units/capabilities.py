"""The capabilities of some units in addition to stepping: acting at an instant, and returning to a saved state.

`Unit.events` and `Unit.state` are `None` where a unit lacks the capability. They are looked up once, when a run is
prepared, so that no step has to test for them. `Interface.event_mode` and `Interface.rolls_back` say the same before
the unit is made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any


class EventCapability(ABC):
    """Event Mode of FMI 3.0: the unit acts at an instant t_k, without advancing in time.

    The order of calls is `use` before the unit is bound; then at each instant `activate`, the unit's setters and
    getters, and `update`. Methods return a false value, or the FMI status that they met; they raise `EndRequested` as
    the unit's step does.
    """

    demanded = False
    """Whether the unit runs with Event Mode only, also where the schedule does not use it."""

    @abstractmethod
    def use(self, h: float, *, settles: bool = False) -> None:
        """Use Event Mode from now on; called once, before `Unit.bind`.

        Args:
            h: The communication step of the unit [s], which is the interval of clocks that have none of their own.
            settles: Whether an event at the end of a step is handled by that step, with the inputs of the step, so that
                the outputs at that instant show it; otherwise `activate` handles it.

        Raises:
            UnitError: The unit cannot be started with Event Mode.
        """

    @abstractmethod
    def activate(self, t: float, h: float) -> object:
        """Enter Event Mode at `t` [s] with the clocks that are due or were triggered. Raises `UnitError`."""

    @abstractmethod
    def update(self, t: float, h: float) -> object:
        """Iterate the discrete states until they settle, which ends what `activate` began. Raises `UnitError`."""

    @abstractmethod
    def fired(self) -> set[str]:
        """The output clocks that have ticked since this was called last, by name."""

    @abstractmethod
    def trigger(self, clock: str) -> None:
        """Make a triggered input clock tick when the unit is activated next."""


class StateCapability(ABC):
    """The unit returns to a state that was saved, bit by bit. The saved states are opaque to its callers."""

    serializes = False
    """Whether a saved state can be written as bytes, for another instance of the same unit in any process."""

    @abstractmethod
    def save(self) -> Any:
        """The present state, for `restore`. Raises `UnitError`."""

    @abstractmethod
    def restore(self, state: Any) -> None:
        """Return to a saved state, any number of times. Raises `UnitError`."""

    @abstractmethod
    def forget(self, state: Any) -> None:
        """Release a saved state, which cannot be restored afterwards. Raises `UnitError`."""

    @abstractmethod
    def serialized(self, state: Any) -> bytes:
        """A saved state as bytes, of a unit that `serializes`. Raises `UnitError`."""

    @abstractmethod
    def deserialized(self, content: bytes) -> Any:
        """A saved state from bytes that `serialized` gave, for `restore` and `forget`. Raises `UnitError`."""
