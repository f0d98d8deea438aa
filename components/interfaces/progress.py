"""Progress of long work, as the functions that do it report it to their caller."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol, final


class Progress(Protocol):
    """Receives reports on the progress of a long operation."""

    def now(self, text: str | Callable[[], str]) -> None:
        """Report what is going on from now on; the next report replaces this one.

        Args:
            text: A short phrase such as `drawing the figures`, or what gives the phrase whenever it is asked, from any
                thread.
        """
        ...

    def done(self, text: str) -> None:
        """Report a result that took long enough to deserve a line of its own.

        Args:
            text: A short phrase such as `built mpc for FMI 3.0`.
        """
        ...


@final
class _Silent:
    def now(self, text: str | Callable[[], str]) -> None:
        pass

    def done(self, text: str) -> None:
        pass


SILENT: Final[Progress] = _Silent()
"""Discards every report."""
