"""Watching a run while it steps: a process writes a file of its own, which a window or a page in the browser follows.

Nothing that is streamed is at an address that another program could guess. Only with `--connect` it goes to a viewer's
own server, which a person has started. The process that writes can be ended at any moment, because another process
writes the recording of the run.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from components.interfaces.problem import Problem, raise_if_any, refuse
from fmus.toolchain.scratch import scratch_folder
from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.process import TO_VIEWER, RecordingProcess
from orchestrator.viewing.live_viewers import LivePage, LiveViewer, LiveWindow, ViewerStartError
from orchestrator.viewing.rerun_program import PORT, answers, has_display, tell_of_usage_data

if TYPE_CHECKING:  # slow to import, and only the name is needed
    from orchestrator.stepping.master import Simulation

_FOLLOWS_WITHIN: Final = 1.5
"""[s] The time after the last tick within which a viewer at an address must have received the whole run."""
_PAUSE: Final = 0.2
"""[s] The time after which it is asked again whether a viewer is there."""
_URL: Final = re.compile(r"rerun(\+https?)?://([^/\s:]+|\[[0-9a-f:]+\])(:(?P<port>\d+))?/proxy", re.IGNORECASE)


@dataclass(frozen=True)
class LiveOptions:
    """How a run is watched; with neither a window nor the browser, the address of a page is told."""

    viewer: bool = True
    """Whether to open a window."""
    web: bool = False
    """Whether to open the browser instead."""
    url: str | None = None
    """The address of a viewer that is already running, to use instead."""
    wait: bool = False
    """Whether the run begins only when somebody has opened the page, or when a viewer answers at the address."""

    def check(self) -> None:
        """Check the address.

        Raises:
            RequestError: It is not the address of a viewer.
        """
        parts = None if self.url is None else _URL.fullmatch(self.url)
        if self.url is not None and (parts is None or not 0 < int(parts["port"] or PORT) < 2**16):
            remedy = "A viewer says it when it starts."
            raise refuse(f"--connect {self.url}", "no address of a viewer", f"rerun+http://HOST:{PORT}/proxy", remedy)


def live_options(*, live: bool, viewer: bool, web: bool, url: str | None, wait: bool = False) -> LiveOptions | None:
    """How a run is watched, from the options of the command.

    Args:
        live: Whether to watch the run at all.
        viewer: Whether a window may open.
        web: Whether to use the browser.
        url: The address of a viewer that is already running.
        wait: Whether the run waits for somebody who watches.

    Returns:
        The options; None without `live`.

    Raises:
        RequestError: Options exclude each other or need `live`, or the address is not that of a viewer.
    """
    if not live:
        given = {"--no-viewer": not viewer, "--web": web, "--connect": url is not None, "--wait": wait}
        raise_if_any(Problem(name, "no --live", "with --live only") for name, is_given in given.items() if is_given)
        return None
    if url is not None and (web or not viewer):
        raise refuse("--connect", "--web or --no-viewer too", "one of them")
    options = LiveOptions(viewer, web, url, wait)
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
        self._sink: Path | str | None = options.url
        self._viewer: LiveViewer | None = None

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            folder = Path(stack.enter_context(scratch_folder("live")))
            self._process = stack.enter_context(RecordingProcess(TO_VIEWER))
            if self._options.url is None:
                self._start(stack, folder / "live.rrd")
            elif not self._answers(self._options.url):
                self._tell(f"no viewer answers at {self._options.url}; the run goes on without it")
                self._sink = None
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def _start(self, stack: ExitStack, path: Path) -> None:
        tell_of_usage_data(self._tell)
        window = self._options.viewer and not self._options.web and has_display()
        try:
            viewer = LiveWindow(path, self._tell) if window else LivePage(path, self._tell, opens=self._options.web)
        except ViewerStartError:
            self._give_up()
        else:
            self._viewer, self._sink = stack.enter_context(viewer), path

    def _answers(self, url: str) -> bool:
        there = answers(url)
        if self._options.wait and not there:
            self._tell(f"the run begins when a viewer answers at {url}")
            while not (there := answers(url)):
                time.sleep(_PAUSE)
        return there

    def _give_up(self) -> None:
        self._tell("the viewer did not start; the run goes on without it")
        self._sink = None

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Stream a simulation from now on, until `end`.

        Args:
            request: What to record; it goes to the viewer instead of the sink that it names.
            simulation: The simulation.
        """
        if self._sink is not None and self._viewer is not None and not self._viewer.is_there:
            self._give_up()  # a viewer listens before it opens its window, and ends when it cannot open it
        if self._sink is not None:
            self._process.begin(replace(request, sink=self._sink, followed=True), simulation)

    def wait_until_open(self) -> None:
        """Wait until the viewer can show rows as they come."""
        if self._sink is not None:
            self._process.wait_until_open()
        if self._options.wait and self._sink is not None and self._viewer is not None:
            self._viewer.wait_for_watcher()

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
        if self._sink is None:
            return ""
        if self._viewer is None:
            behind = bool(self._process.wait(max(0.0, self._deadline - time.monotonic())))
        else:
            behind = bool(self._process.wait()) or not self._viewer.complete()
        return "the viewer did not take the whole run in time; the recording has it" if behind else ""

    def stay(self) -> None:
        """Keep serving the page in the browser until Ctrl-C, because it has no window that a person could close."""
        if self._viewer is not None:
            self._viewer.stay()
