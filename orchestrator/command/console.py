"""What the commands print on the terminal, and the exit codes that they end with."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, final

from rich.console import Console
from rich.text import Text
from typing_extensions import override

from fmus.toolchain.foreign_text import escaped

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

TELLS_EVERY: Final = 5.0
"""[s] The time between two lines on the progress where there is no terminal."""
_LONGEST: Final = 10_000
"""[characters] What is longer is left out in the middle: a file may hold a name of any length."""


class _PlainConsole(Console):
    """A terminal on which texts stand as they are: they come from files, from FMUs, and from what a person typed.

    Nothing in them is markup or an emoji code, and characters that a terminal would obey are shown by their codes.
    """

    def __init__(self, *, stderr: bool) -> None:
        super().__init__(stderr=stderr, soft_wrap=True, highlight=False, emoji=False, markup=False)

    @override
    def render_str(self, text: str, **how: Any) -> Text:
        return super().render_str(visible(text), **how)


def visible(text: str) -> str:
    """A text in which no character can command a terminal, or change the direction of others; of bounded length."""
    if len(text) > _LONGEST:
        half = _LONGEST // 2
        text = f"{text[:half]} ... ({len(text) - 2 * half} characters) ... {text[-half:]}"
    return escaped(text, kept="\n\t\xa0")


out = _PlainConsole(stderr=False)
err = _PlainConsole(stderr=True)


@final
class StatusLine:
    """The progress of a command: a status line on terminals, and lines that stay for results everywhere.

    Where there is no terminal, a line every `TELLS_EVERY` seconds says what is going on.
    """

    def __init__(self, status: Status) -> None:
        self._status, self._began = status, time.monotonic()
        self._text: str | Callable[[], str] = "starting"
        self._over = threading.Event()
        if not err.is_terminal:
            threading.Thread(target=self._tell, args=(TELLS_EVERY,), daemon=True).start()

    def __rich__(self) -> Text:
        """What is going on, as the status line shows it whenever it is drawn."""
        return Text(visible(self._text if isinstance(self._text, str) else self._text()))

    def now(self, text: str | Callable[[], str]) -> None:
        """Show in the status line what is going on."""
        self._text = text
        self._status.update(self)

    def done(self, text: str) -> None:
        """Print a result on a line of its own."""
        err.print(text)

    def end(self) -> None:
        """Nothing is going on any more."""
        self._over.set()

    def _tell(self, seconds: float) -> None:
        while not self._over.wait(seconds):
            print_message(f"{self.__rich__()} ({time.monotonic() - self._began:.0f} s)")


@contextmanager
def working() -> Generator[Progress]:
    """Show the progress of the work in the block."""
    with err.status("starting") as status:
        line = StatusLine(status)
        try:
            yield line
        finally:
            line.end()


def print_message(text: str) -> None:
    """Print a message on standard error, exactly as it stands."""
    err.print(text)


def print_notes(remarks: Iterable[str]) -> None:
    """Print remarks on standard error, one per line."""
    for remark in remarks:
        print_message(f"note: {remark}")


def print_problems(problems: Iterable[Problem]) -> None:
    """Print what is wrong with a request or a file on standard error, one problem per line."""
    for problem in problems:
        err.print("macrostep: ", end="", style="red")
        print_message(str(problem))
