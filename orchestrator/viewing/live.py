"""Watching a run while it steps: a viewer or a server on this machine only, and a process that streams to it.

Viewer and server are processes of Rerun's own program. The process that streams can be ended at any moment, because
another process writes the file.
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
"""[s] The time within which a viewer must start before the run begins; the running simulation does not wait for it."""
_FOLLOWS_WITHIN: Final = 1.5
"""[s] The time after the last tick within which the viewer must have received the whole run."""
_URL: Final = re.compile(r"rerun(\+https?)?://([^/\s:]+|\[[0-9a-f:]+\])(:(?P<port>\d+))?/proxy", re.IGNORECASE)


@dataclass(frozen=True)
class LiveOptions:
    """How a run is watched; with neither a viewer nor the browser there is only a server."""

    viewer: bool = True
    """Whether to open a window."""
    web: bool = False
    """Whether to open the browser instead."""
    url: str | None = None
    """The address of a viewer that is already running, to use instead."""

    def check(self) -> None:
        """Check the address.

        Raises:
            RequestError: It is not the address of a viewer.
        """
        parts = None if self.url is None else _URL.fullmatch(self.url)
        if self.url is not None and (parts is None or not 0 < int(parts["port"] or PORT) < 2**16):
            remedy = "A viewer says it when it starts."
            raise refuse(f"--connect {self.url}", "no address of a viewer", f"rerun+http://HOST:{PORT}/proxy", remedy)


def live_options(*, live: bool, viewer: bool, web: bool, url: str | None) -> LiveOptions | None:
    """How a run is watched, from the options of the command.

    Args:
        live: Whether to watch the run at all.
        viewer: Whether a window may open.
        web: Whether to use the browser.
        url: The address of a viewer that is already running.

    Returns:
        The options; None without `live`.

    Raises:
        RequestError: Options exclude each other or need `live`, or the address is not that of a viewer.
    """
    if not live:
        given = {"--no-viewer": not viewer, "--web": web, "--connect": url is not None}
        raise_if_any(Problem(name, "no --live", "with --live only") for name, is_given in given.items() if is_given)
        return None
    if url is not None and (web or not viewer):
        raise refuse("--connect", "--web or --no-viewer too", "one of them")
    options = LiveOptions(viewer, web, url)
    options.check()
    return options


class LiveStream:
    """The stream of one run to a viewer; use it in a `with` statement. No failure of the stream affects the run.

    Args:
        options: How the run is watched.
        tell: Called with each line of text for the user.
    """

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
            self._server.kill()  # it has nothing to save, and a stopped process would not react to another signal
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
            self._give_up()

    def _give_up(self) -> None:
        self._tell("the viewer did not start; the run goes on without it")
        self._url = None

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Stream a simulation from now on, until `end`.

        Args:
            request: What to record; it goes to the viewer instead of the sink that it names.
            simulation: The simulation.
        """
        if self._url is not None and self._server is not None and self._server.poll() is not None:
            self._give_up()  # a viewer listens before it opens its window, and ends when it cannot open it
        if self._url is not None:
            self._process.begin(replace(request, sink=self._url), simulation)

    def wait_until_open(self) -> None:
        """Wait until the viewer can show rows as they come."""
        if self._url is not None:
            self._process.wait_until_open()

    def end(self, about: Mapping[str, str]) -> None:
        """Tell the stream that there are no more rows; returns at once.

        Args:
            about: The run's provenance as it is known at the end.
        """
        self._deadline = time.monotonic() + _FOLLOWS_WITHIN
        self._process.end(about)

    def wait(self) -> str:
        """Wait until the viewer has taken the whole run, but not for long.

        Returns:
            A line that says that it has not; empty if it has.
        """
        problem = self._process.wait(max(0.0, self._deadline - time.monotonic()))
        return "the viewer did not take the whole run in time; the recording has it" if problem else ""

    def stay(self) -> None:
        """Keep serving the page in the browser until Ctrl-C, because it has no window that a person could close."""
        if self._options.web and self._server is not None and self._server.poll() is None:
            self._tell("the page stays until Ctrl-C")
            with suppress(KeyboardInterrupt):
                self._server.wait()
