"""What the commands print on the terminal, and the exit codes that they end with."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, final

from rich.console import Console

if TYPE_CHECKING:  # the start of the command does not wait for them
    from rich.status import Status

    from components.interfaces.problem import Problem
    from components.interfaces.progress import Progress

FAULT: Final = 1
"""Exit code: the run ended in a fault, the file does not pass, or the compiler failed."""
WRONG: Final = 2
"""Exit code: the request was wrong."""
INTERRUPTED: Final = 130
"""Exit code: Ctrl-C."""

# Emoji codes are off: a pattern such as `plant.*:x:` is printed as it was typed.
out = Console(soft_wrap=True, highlight=False, emoji=False)
err = Console(stderr=True, soft_wrap=True, highlight=False, emoji=False)


@final
class StatusLine:
    """The progress of a command: a status line on terminals, and lines that stay for results everywhere."""

    def __init__(self, status: Status) -> None:
        self._status = status

    def now(self, text: str) -> None:
        """Show in the status line what is going on."""
        self._status.update(text)

    def done(self, text: str) -> None:
        """Print a result on a line of its own."""
        self._status.update(text)
        err.print(text)


@contextmanager
def working() -> Generator[Progress]:
    """Show the progress of the work in the block."""
    with err.status("starting") as status:
        yield StatusLine(status)


def print_message(text: str) -> None:
    """Print a message on standard error, exactly as it stands."""
    err.print(text, markup=False)


def print_notes(remarks: Iterable[str]) -> None:
    """Print remarks on standard error, one per line."""
    for remark in remarks:
        print_message(f"note: {remark}")


def print_problems(problems: Iterable[Problem]) -> None:
    """Print what is wrong with a request or a file on standard error, one problem per line."""
    for problem in problems:
        err.print("macrostep: ", end="", style="red")
        print_message(str(problem))
