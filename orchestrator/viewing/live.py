"""Watching a run while it steps: a viewer or a server on this machine alone, and a process that streams to it.

Viewer and server are processes of Rerun's own program, which listens where it is told to; the stream comes from a
process of ours that can be ended at any moment, because the file is written by another one.
"""

from __future__ import annotations

import re
import subprocess
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.process import TO_VIEWER, RecordingProcess
from orchestrator.viewing.rerun_program import (
    PORT,
    address,
    answers,
    free_port,
    has_display,
    listens,
    serve,
    web_address,
)

if TYPE_CHECKING:  # slow to import, and only the name is needed
    from orchestrator.stepping.master import Simulation

WEB_PORT: Final = 9090
_STARTS_WITHIN: Final = 20.0
"""[s] a viewer is waited for before the run begins; once it runs, nothing waits for it"""
_FOLLOWS_WITHIN: Final = 1.5
"""[s] after the last tick in which a viewer may take what is left"""
_URL: Final = re.compile(r"rerun(\+https?)?://([^/\s:]+|\[[0-9a-f:]+\])(:(?P<port>\d+))?/proxy", re.IGNORECASE)


@dataclass(frozen=True)
class LiveOptions:
    """How a person wants to watch: in the viewer, in a browser, in neither, or in a viewer that is already there."""

    viewer: bool = True
    web: bool = False
    url: str | None = None

    def check(self) -> None:
        """Raises `RequestError` for a URL that is none."""
        found = None if self.url is None else _URL.fullmatch(self.url)
        if self.url is not None and (found is None or not 0 < int(found["port"] or PORT) < 2**16):
            remedy = "A viewer says it when it starts."
            raise refuse(f"--connect {self.url}", "no address of a viewer", f"rerun+http://HOST:{PORT}/proxy", remedy)


def live_options(*, live: bool, viewer: bool, web: bool, url: str | None) -> LiveOptions | None:
    """What the options of the command ask for; None without `live`. Raises `RequestError`."""
    if not live:
        options = {"--no-viewer": not viewer, "--web": web, "--connect": url is not None}
        raise_if_any(Problem(name, "no --live", "with --live only") for name, given in options.items() if given)
        return None
    if url is not None and (web or not viewer):
        raise refuse("--connect", "--web or --no-viewer too", "one of them")
    made = LiveOptions(viewer, web, url)
    made.check()
    return made


class LiveStream:
    """The stream of one run; use it in a `with` statement. Nothing that goes wrong with it reaches the run."""

    def __init__(self, options: LiveOptions, tell: Callable[[str], None]) -> None:
        self._options, self._tell = options, tell
        self._server: subprocess.Popen[bytes] | None = None
        self._url = options.url
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
        self._url = address(port)
        window = self._options.viewer and not self._options.web and has_display()
        if window:
            how = ["--expect-data-soon"]
            self._tell(f"live in the viewer; another one can join at {self._url}")
        elif self._options.web:
            web = free_port(WEB_PORT)
            how = ["--web-viewer" if has_display() else "--serve-web", "--web-viewer-port", str(web)]
            self._tell(f"live in the browser at {web_address(web, self._url)}")
        else:
            how = ["--serve-grpc"]
            why = "no display here; " if self._options.viewer else ""
            self._tell(f"{why}live at {self._url}, look with: rerun {self._url}")
        self._stays = window
        self._server = serve(port, how, stays=window)
        if not listens(port, _STARTS_WITHIN, self._server):
            self._tell("the viewer did not start; the run goes on without it")
            self._url = None

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
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
        if self._options.web and self._server is not None and self._server.poll() is None:
            self._tell("the page stays until Ctrl-C")
            with suppress(KeyboardInterrupt):
                self._server.wait()
