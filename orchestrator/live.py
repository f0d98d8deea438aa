"""Watching a run while it steps: a viewer or a server on this machine alone, and a process that streams to it.

Viewer and server are processes of Rerun's own program, which listens where it is told to; the stream comes from a
process of ours that can be ended at any moment, because the file is written by another one.
"""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self
from urllib.parse import quote, urlsplit

from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.recording_process import TO_VIEWER, RecordingProcess, Request
from orchestrator.viewing import viewer

if TYPE_CHECKING:  # slow to import, and only the name is needed
    from orchestrator.master import Simulation

LOOPBACK: Final = "127.0.0.1"
PORT: Final = 9876
"""The port that viewers look at when they are not told another"""
WEB_PORT: Final = 9090
_STARTS_WITHIN: Final = 20.0
"""[s] a viewer is waited for before the run begins; once it runs, nothing waits for it"""
_ANSWERS_WITHIN: Final = 2.0
"""[s] for a viewer that is already there"""
_FOLLOWS_WITHIN: Final = 1.5
"""[s] after the last tick in which a viewer may take what is left"""
_URL: Final = re.compile(r"rerun(\+https?)?://[^/\s]+/proxy")


@dataclass(frozen=True)
class Wish:
    """How a person wants to watch: in the viewer, in a browser, in neither, or in a viewer that is already there."""

    viewer: bool = True
    web: bool = False
    url: str | None = None

    def check(self) -> None:
        """Raises `RequestError` for a URL that is none."""
        if self.url is not None and not _URL.fullmatch(self.url):
            remedy = "A viewer says it when it starts."
            raise refuse(f"--connect {self.url}", "no address of a viewer", f"rerun+http://HOST:{PORT}/proxy", remedy)


def wish(*, live: bool, viewer: bool, web: bool, url: str | None) -> Wish | None:
    """What the options of the command ask for; None without `live`. Raises `RequestError`."""
    if not live:
        options = {"--no-viewer": not viewer, "--web": web, "--connect": url is not None}
        raise_if_any(Problem(name, "no --live", "with --live only") for name, given in options.items() if given)
        return None
    if url is not None and (web or not viewer):
        raise refuse("--connect", "--web or --no-viewer too", "one of them")
    made = Wish(viewer, web, url)
    made.check()
    return made


class Live:
    """The stream of one run; use it in a `with` statement. Nothing that goes wrong with it reaches the run."""

    def __init__(self, wish: Wish, tell: Callable[[str], None]) -> None:
        self._wish, self._tell = wish, tell
        self._server: subprocess.Popen[bytes] | None = None
        self._url = wish.url
        self._stays = False

    def __enter__(self) -> Self:
        self._process = RecordingProcess(TO_VIEWER).__enter__()
        if self._url is None:
            self._start()
        elif not answers(self._url):
            self._tell(f"no viewer answers at {self._url}; the run goes on without it")
            self._url = None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.__exit__(kind, error, trace)
        if self._server is not None and not self._stays:
            self._server.kill()  # it keeps nothing, and one that was stopped would not hear anything softer
            self._server.wait()

    def _start(self) -> None:
        port = free_port(PORT)
        if port != PORT:
            self._tell(f"port {PORT} is taken, by another viewer perhaps; this one has {port}")
        self._url = f"rerun+http://{LOOPBACK}:{port}/proxy"
        window = self._wish.viewer and not self._wish.web and has_display()
        if window:
            how = ["--expect-data-soon"]
            self._tell(f"live in the viewer; another one can join at {self._url}")
        elif self._wish.web:
            web = free_port(WEB_PORT)
            how = ["--web-viewer" if has_display() else "--serve-web", "--web-viewer-port", str(web)]
            self._tell(f"live in the browser at {web_address(web, self._url)}")
        else:
            how = ["--serve-grpc"]
            why = "no display here; " if self._wish.viewer else ""
            self._tell(f"{why}live at {self._url}, look with: rerun {self._url}")
        self._stays = window
        self._server = serve(port, how, stays=window)
        if not listens(port, _STARTS_WITHIN, self._server):
            self._tell("the viewer did not start; the run goes on without it")
            self._url = None

    def begin(self, request: Request, simulation: Simulation) -> None:
        """Stream `simulation` from now on, until `end`."""
        if self._url is not None:
            self._process.begin(replace(request, sink=self._url), simulation)

    def wait_until_open(self) -> None:
        """Wait until the viewer can show rows as they come."""
        if self._url is not None:
            self._process.wait_until_open()

    def end(self, about: Mapping[str, str]) -> None:
        """There will be no more rows; comes back at once."""
        self._deadline = time.monotonic() + _FOLLOWS_WITHIN
        self._process.end(about)

    def wait(self) -> str:
        """Let the viewer take what is left, but not for long; what it did not get, in a line, or nothing."""
        problem = self._process.wait(max(0.0, self._deadline - time.monotonic()))
        return "the viewer did not take the whole run in time; the recording has it" if problem else ""

    def stay(self) -> None:
        """Keep a page in the browser up until Ctrl-C; it has no process of its own that a person could close."""
        if self._wish.web and self._server is not None and self._server.poll() is None:
            self._tell("the page stays until Ctrl-C")
            with suppress(KeyboardInterrupt):
                self._server.wait()


def serve(port: int, how: list[str], *, stays: bool = False) -> subprocess.Popen[bytes]:
    """Start Rerun's program with a server on `port` of this machine alone; only one that `stays` may outlive us."""
    command = [viewer.program(), "--bind", LOOPBACK, "--port", str(port), *how]
    # a session of its own: Ctrl-C in the terminal is for the run, and a window stays open after it
    return subprocess.Popen(  # noqa: S603 - the program that rerun-sdk brings
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=None if stays else viewer.end_with_parent(),  # noqa: PLW1509 - one call into libc, which takes no locks
    )


def listens(port: int, within: float, server: subprocess.Popen[bytes]) -> bool:
    """Wait until somebody listens on `port`; no longer than the server runs."""
    deadline = time.monotonic() + within
    while time.monotonic() < deadline and server.poll() is None:
        with socket.socket() as probe:
            probe.settimeout(1)
            if probe.connect_ex((LOOPBACK, port)) == 0:
                return True
        time.sleep(0.05)
    return False


def answers(url: str) -> bool:
    """Whether somebody listens at a URL."""
    parts = urlsplit(url)
    try:
        with socket.create_connection((parts.hostname or "", parts.port or PORT), _ANSWERS_WITHIN):
            return True
    except (OSError, ValueError):
        return False


def free_port(wanted: int) -> int:
    """`wanted` if nobody listens there, else some port that is free."""
    for port in (wanted, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise refuse("--live", "no free port on this machine", "a machine with one")


def has_display() -> bool:
    """Whether a window can open here."""
    if sys.platform.startswith("linux"):
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True


def web_address(port: int, url: str) -> str:
    """The page of the web viewer on `port` that shows what is streamed to `url`."""
    return f"http://{LOOPBACK}:{port}/?url={quote(url, safe='')}"
