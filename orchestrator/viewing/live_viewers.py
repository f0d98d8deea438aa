"""What shows a live recording: a window, fed through its standard input, or a page that `live_server` serves."""

from __future__ import annotations

import os
import secrets
import subprocess
import threading
import time
import webbrowser
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import ExitStack, suppress
from html import escape
from pathlib import Path
from types import TracebackType
from typing import Final, Self, final

from typing_extensions import override

from fmus.toolchain.child_death import ChildDiedError, ChildSilentError
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.typed_messages import UnreadableMessageError
from orchestrator.viewing.live_server import STALLS_AFTER, WATCHED, LiveFile, growing
from orchestrator.viewing.rerun_program import (
    LOOPBACK,
    free_port,
    has_display,
    listens,
    page_address,
    serve,
    web_address,
)

_STARTS_WITHIN: Final = 60.0
"""[s] The time within which a viewer that lives must listen, before the run begins, on a machine that is busy."""
_NOWHERE: Final = f"http://{LOOPBACK}:1/live.rrd"
"""With an address, Rerun serves its page alone, and no server beside it that takes streams."""
_PAUSE: Final = 0.05


class ViewerStartError(RuntimeError):
    """A viewer that did not start."""


class LiveViewer(ABC):
    """A viewer of a file that grows; use it in a `with` statement."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._program: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    @property
    def is_there(self) -> bool:
        """Whether its program has not ended."""
        return self._program is not None and self._program.poll() is None

    @abstractmethod
    def complete(self) -> bool:
        """Say that nothing more is written, and wait as long as the rest is taken; return whether all of it was."""

    @abstractmethod
    def wait_for_watcher(self) -> None:
        """Wait until somebody sees what is shown."""

    @abstractmethod
    def stay(self) -> None:
        """Wait until the viewer is not needed any more, where nobody could close it."""


@final
class LiveWindow(LiveViewer):
    """The viewer's window, which opens with the first rows; it stays open when this process ends.

    Args:
        path: The file.
        tell: Called with each line of text for the user.

    Raises:
        ViewerStartError: It did not start.
    """

    def __init__(self, path: Path, tell: Callable[[str], None]) -> None:
        super().__init__()
        port = free_port(0)
        tell(
            f"live in the viewer; any program on this machine that finds its port {port} can draw into its window and"
            " photograph it"
        )
        self._program = program = serve(port, ["--expect-data-soon", "-"], stays=True, fed=True)
        if program.stdin is None or not listens(port, _STARTS_WITHIN, program):
            program.kill()
            program.communicate()
            raise ViewerStartError
        self._pipe, self._path = program.stdin, path
        self._complete, self._fed, self._took_all = threading.Event(), 0, False
        self._stack.callback(self._complete.set)
        self._thread = threading.Thread(target=self._feed, daemon=True)
        self._thread.start()

    def _feed(self) -> None:
        with suppress(OSError), self._pipe:  # it has been closed by its user
            for part in growing(self._path, self._complete):
                left = memoryview(part)
                while left:
                    done = os.write(self._pipe.fileno(), left)
                    left, self._fed = left[done:], self._fed + done
            self._took_all = True

    @override
    def complete(self) -> bool:
        self._complete.set()
        fed = -1
        while self._thread.is_alive() and fed != self._fed:
            fed = self._fed
            self._thread.join(STALLS_AFTER)
        return self._took_all

    @override
    def wait_for_watcher(self) -> None:
        """The window is open."""

    @override
    def stay(self) -> None:
        """A person closes the window."""


@final
class LivePage(LiveViewer):
    """A page for the browser, and the process that gives it the file.

    Args:
        path: The file.
        tell: Called with each line of text for the user.
        opens: Whether to open the browser.

    Raises:
        ViewerStartError: It did not start.
    """

    def __init__(self, path: Path, tell: Callable[[str], None], *, opens: bool) -> None:
        super().__init__()
        with self._stack:
            page = self._serve_page(path.parent)
            file = LiveFile(path, secrets.token_urlsafe(16), page)
            address = web_address(page, f"http://{LOOPBACK}:{self._serve_file(file)}{file.place}")
            shown = opens and has_display()
            why = "" if opens or has_display() else "no display here; "
            tell(f"{why}live in the browser at {address}")
            tell("whoever has this address can watch on this machine, nobody can write")
            if shown:
                _open(address, path.parent / "live.html")
            self._opened, self._tell = opens, tell
            self._stack = self._stack.pop_all()

    def _serve_page(self, folder: Path) -> str:
        """Start the program that serves the page, which holds no data, and return its address."""
        said = folder / "said"
        with said.open("wb") as file:
            how = ["--serve-web", "--web-viewer-port", "0", _NOWHERE]
            self._program = program = serve(0, how, environment={**os.environ, "RUST_LOG": "info"}, said=file)
        self._stack.callback(program.wait)
        self._stack.callback(program.kill)  # it has nothing to save, and a stopped process would not react otherwise
        ends = time.monotonic() + _STARTS_WITHIN
        while (page := page_address(said.read_text("utf-8", "replace"))) is None:
            if program.poll() is not None or time.monotonic() > ends:
                raise ViewerStartError
            time.sleep(_PAUSE)
        return page

    def _serve_file(self, file: LiveFile) -> int:
        """Start the process that gives the file away, and return its port."""
        self._server = ChildProcess("orchestrator.viewing.live_server", int)
        self._stack.callback(self._server.close)
        self._stack.callback(self._server.kill)
        try:
            return self._server.ask(file, _STARTS_WITHIN)
        except (ChildDiedError, ChildSilentError, UnreadableMessageError) as error:
            raise ViewerStartError from error

    @override
    def wait_for_watcher(self) -> None:
        self._tell("the run begins when somebody opens the address")
        with suppress(ChildDiedError, ChildSilentError, UnreadableMessageError):
            while self.is_there and not self._server.ask(WATCHED, _STARTS_WITHIN):
                time.sleep(_PAUSE)

    @override
    def complete(self) -> bool:
        with suppress(ChildDiedError, ChildSilentError, UnreadableMessageError):
            return not self._server.ask(None, _STARTS_WITHIN)
        return False

    @override
    def stay(self) -> None:
        if self._opened and self.is_there and self._program is not None:
            self._tell("the page stays until Ctrl-C")
            with suppress(KeyboardInterrupt):
                self._program.wait()


def _open(address: str, file: Path) -> None:
    """Open an address by a file that only its user can read: the commands of programs are seen by all users."""
    file.touch(0o600)
    file.write_text(f'<meta http-equiv="refresh" content="0; url={escape(address)}">', "utf-8")
    webbrowser.open(file.as_uri())
