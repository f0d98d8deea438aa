"""Screenshots of a recording, taken by a Rerun viewer that listens at a URL."""
# pyright: basic
# rerun's viewer client carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import contextlib
import time as clock
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from rerun.experimental import ViewerClient

from components.interfaces.problem import Problem, raise_if_any

_ANSWERS_WITHIN: Final = 900.0
"""[s] The time within which a viewer that lives must answer, and load a recording, on a machine that is busy."""
_NEAR: Final = 1e-6
"""[s] How far outside of a recording a time may be: a rounding error."""
_EMPTY_AFTER: Final = 300
"""The answers of a viewer that loads nothing and shows nothing, after which there is nothing to show."""
_HAS_ROWS_WITHIN: Final = 5.0
"""[s] The time within which the timeline of a recording with rows can be moved."""
_DRAWS_WITHIN: Final = 120.0
"""[s] The time after which a picture is taken even though it still changes."""


def screenshots(  # noqa: PLR0913 - what a picture is taken of, and how
    url: str,
    source: Path | str,
    times: Sequence[float | None],
    settle: float,
    lives: Callable[[], bool] = lambda: True,
    tab: str | None = None,
) -> Iterator[bytes]:
    """Open something in the viewer at a URL and take pictures of the window.

    Args:
        url: Where the viewer listens.
        source: The recording to open, or the URL of a page of a catalog.
        times: One picture is taken at each of these times [s] on the timeline `sim_time`; None is where the viewer
            opens.
        settle: Pause [s] between loading the recording and the first picture.
        lives: Whether the viewer's program runs; it is not waited for when it has ended.
        tab: The beginning of the name of the tab that is opened; the one that the recording opens, if not given.

    Yields:
        The content of one PNG file for each of the `times`.

    Raises:
        ConnectionError: The viewer does not answer.
        ValueError: The viewer finds nothing to show, or no such tab.
        RequestError: There are times outside of the recording.
    """
    try:
        viewer = _retried(lambda: ViewerClient.connect(url), _ANSWERS_WITHIN, lives)
        opened = str(source.resolve()) if isinstance(source, Path) else source
        _retried(lambda: viewer.open(opened), _ANSWERS_WITHIN, lives)
        if isinstance(source, Path) and not _loads(viewer, lives):
            raise ValueError("nothing that the viewer can show")
        _refuse_outside(viewer, times)
        if tab is not None:
            _open_tab(viewer, tab)
        clock.sleep(settle)
        for time in times:
            if time is not None:
                move = partial(viewer.set_time, "sim_time", duration=time, play_state="paused")
                # A run without rows has no timeline to move; a viewer that is gone shows in the next line.
                with contextlib.suppress(RuntimeError, OSError):
                    _retried(move, _HAS_ROWS_WITHIN, lives)
            yield _still_picture(viewer)
    except (RuntimeError, OSError) as error:
        raise ConnectionError(str(error).partition("\n")[0]) from error


def _retried(action: Callable[[], Any], seconds: float, lives: Callable[[], bool]) -> Any:
    """The result of an action that may fail until a deadline has passed, or the viewer has ended."""
    deadline = clock.monotonic() + seconds
    while True:
        try:
            return action()
        except (RuntimeError, OSError):
            if clock.monotonic() > deadline or not lives():
                raise
            clock.sleep(0.1)


def _loads(viewer: ViewerClient, lives: Callable[[], bool]) -> bool:
    """Wait until a recording is loaded and has views; tells whether that happens before very many answers."""
    answers = 0
    while answers < _EMPTY_AFTER and lives():
        state = viewer.get_state()
        if state.recordings and state.views and not state.loading:
            return True
        answers += not state.loading
        clock.sleep(0.1)
    return False


def _refuse_outside(viewer: ViewerClient, times: Sequence[float | None]) -> None:
    """Refuse times outside of the recording, where the viewer would show its end as if that was the time."""
    timelines = [line for recording in viewer.get_state().recordings for line in recording.timelines]
    for whole in (line for line in timelines if line.name == "sim_time"):
        if whole.start is None or whole.end is None:  # a recording without rows
            continue
        first, last = whole.start * 1e-9, whole.end * 1e-9
        valid, remedy = f"{first:g} to {last:g} s", f"The last row is at {last:g} s."
        outside = [t for t in times if t is not None and not first - _NEAR <= t <= last + _NEAR]
        raise_if_any(Problem("--at", f"{time:g} s, when nothing was recorded", valid, remedy) for time in outside)


def _open_tab(viewer: ViewerClient, beginning: str) -> None:
    """Open a tab of the screen by the beginning of its name, whatever its case."""
    known = viewer.get_blueprint().blueprint
    parts = {path.strip("/"): part for path, archetypes in known.items() for part in archetypes.values()}
    screens = [p for p in parts.values() if p.get("container_kind") == "Tabs" and isinstance(p.get("contents"), list)]
    tabs = {parts[tab]["display_name"]: tab for tab in screens[0]["contents"]} if screens else {}
    found = next((tab for name, tab in tabs.items() if name.lower().startswith(beginning.lower())), None)
    if found is None:
        raise ValueError(f"no tab `{beginning}`, but {', '.join(tabs) or 'none'}")
    screens[0]["active_tab"] = found
    viewer.set_blueprint(known, of="recording")


def _still_picture(viewer: ViewerClient) -> bytes:
    """The first picture that equals its predecessor, so that all views are drawn in it."""
    deadline, last = clock.monotonic() + _DRAWS_WITHIN, b""
    while True:
        clock.sleep(0.3)
        picture = viewer.take_screenshot()
        if picture == last or clock.monotonic() > deadline:
            return picture
        last = picture
