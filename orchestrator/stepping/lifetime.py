"""The lifetime of a simulation: its units are opened once, and closed whatever becomes of the simulation."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from enum import Enum, auto

from components.interfaces.problem import refuse


class _Stage(Enum):
    NEW = auto()
    OPEN = auto()
    ENDED = auto()
    """Closed at the stop time, by itself."""
    CLOSED = auto()


class Lifetime:
    """Whether units are open.

    Args:
        owner: The simulation; when it is gone, or the program ends, its units are closed.
        release: Closes the units; it must not refer to the owner.
    """

    def __init__(self, owner: object, release: Callable[[], None]) -> None:
        self._stage = _Stage.NEW
        self._close = release
        self._release = weakref.finalize(owner, release)
        self.ends_itself = True
        """Whether the units are closed at the stop time, because no `with` statement does it."""

    @property
    def is_open(self) -> bool:
        """Whether the units have been opened, and not been closed."""
        return self._stage is _Stage.OPEN

    @property
    def is_new(self) -> bool:
        """Whether nothing has been opened yet."""
        return self._stage is _Stage.NEW

    def open(self, start: Callable[[], None], time: Callable[[], float]) -> None:
        """Open the units, unless they are open.

        Args:
            start: Opens them.
            time: The present instant [s], for a message.

        Raises:
            RequestError: They have been closed.
        """
        self._refuse_closed(time, _Stage.ENDED, _Stage.CLOSED)
        if self._stage is _Stage.NEW:
            self._stage = _Stage.OPEN
            self._carry_out(start)

    def begin_again(self, owner: object, start: Callable[[], None]) -> None:
        """Begin again; units that were closed at the stop time are opened when they are needed.

        Args:
            owner: The simulation.
            start: Starts units that are open again.
        """
        if self._stage is _Stage.ENDED:
            self._release = weakref.finalize(owner, self._close)
            self._stage = _Stage.NEW
        elif self._stage is _Stage.OPEN:
            self._carry_out(start)

    def check(self, time: Callable[[], float]) -> None:
        """Refuse units that somebody has closed. Raises `RequestError`."""
        self._refuse_closed(time, _Stage.CLOSED)

    def _refuse_closed(self, time: Callable[[], float], *stages: _Stage) -> None:
        if self._stage in stages:
            found = f"closed at {time():g} s; its rows stay"
            raise refuse("simulation", found, "one that is open", "Make another Simulation of the system.")

    def _carry_out(self, start: Callable[[], None]) -> None:
        try:
            start()
        except BaseException:
            self.close()
            raise

    def end(self) -> None:
        """Close the units at the stop time, after which all may begin again."""
        self.close()
        self._stage = _Stage.ENDED

    def close(self) -> None:
        """Close the units, once."""
        self._stage = _Stage.CLOSED
        self._release()
