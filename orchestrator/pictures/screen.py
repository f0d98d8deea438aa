"""The layout of the viewer's screen, as plain data: views, and rows, columns and tabs of views.

The first tab answers a person's questions about a run, or about several runs; the next holds all signals, the last says
where the runs come from. What the runs do not have, or did not record, is left out.

Of a title beside the viewer's buttons about 14 characters are seen in a window of 1280 pixels, so that a plot of the
first tab shows one signal, and its title is the signal's name and unit; the page about the run says what it is and what
limits it. A legend hides the curves below it: where there is room, a title names the colours instead. In a comparison
each run has a colour, which the title of the tab names once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Final, TypeAlias

from orchestrator.pictures import friction, palette, plots
from orchestrator.pictures.driven import driven
from orchestrator.pictures.plots import Plot, titled
from orchestrator.pictures.run_picture import MICROSECONDS, RunPicture

_QUARTER_TITLE: Final = 34
"""Characters of the longest title that a view in a quarter of a window of 1280 pixels shows completely."""
_OVER_ROAD: Final = (60, 40)
"""[m] The x and z of the eye where there is no vehicle to follow, so that one view shows most of the road."""
_LONGEST_LEGEND: Final = 6
"""Series; a longer legend would hide what it explains, and the viewer names a series that is pointed at."""
_PARTS_OF_SCENERY: Final = 3
"""Views in a complete scenery: bird's eye view, following view and friction circles."""


@dataclass(frozen=True)
class Series:
    """Series over time."""

    title: str
    contents: Sequence[str]
    """Their entities."""
    legend: bool = False
    is_high: bool = False
    """Whether its axis has room for enough numbers, whatever its range."""


@dataclass(frozen=True)
class Scenery:
    """The world, seen by an eye that moves with a frame."""

    title: str
    origin: str
    """The entity of the frame."""
    eye: tuple[float, float, float]
    """[m] The place of the eye in the frame."""
    target: tuple[float, float, float]
    """[m] The point in the frame that the eye looks at."""
    up: tuple[float, float, float]
    hidden: Sequence[str]
    """Entities that this view does not show."""
    trails: Sequence[str]
    """Entities that show all of their past."""


@dataclass(frozen=True)
class Plane:
    """A plane from (-x, -y) to (x, y)."""

    title: str
    origin: str
    """The entity whose parts are shown."""
    x: float
    y: float
    trails: Sequence[str]
    """Entities that show their past."""
    past: float
    """[s] The length of the past that they show."""


@dataclass(frozen=True)
class Panel:
    """What stands at an entity and below it."""

    kind: str
    """`states` over time, the lines of a `log`, or a `page` of text."""
    title: str
    origin: str
    """The entity."""


@dataclass(frozen=True)
class ViewGroup:
    """Several views."""

    kind: str
    """Side by side (`row`), below each other (`column`), in a `grid`, or behind `tabs`."""
    parts: Sequence[View]
    shares: Sequence[float] | None = None
    """Share of the room for each part; equal if not given."""
    title: str = ""
    columns: int = 1
    """The number of columns of a grid."""


View: TypeAlias = Series | Scenery | Plane | Panel | ViewGroup


def screen(runs: Sequence[RunPicture], differences: Sequence[Series] = ()) -> ViewGroup:
    """The screen for one run, or for several runs in the same views.

    Args:
        runs: What is drawn of each run.
        differences: Views of the differences between runs.
    """
    parts = [view for view in (_scenery(runs), _answers(runs, differences)) if view is not None]
    tabs: list[View] = []
    if parts:
        seen = ViewGroup("column", parts, [1, 2] if len(parts) > 1 else None)
        told = _told(runs)
        tabs.append(ViewGroup("row", [seen, *told], [3, 1] if told else None, _named(runs)))
    series: list[View] = [*_by_bus(runs)]
    if followed := [run.at("signals", *c.path.split(".")) for run in runs for c in driven(run.system)]:
        series.append(Series("Inputs that follow the table", followed, legend=len(followed) <= _LONGEST_LEGEND))
    series += _wall_time(runs)
    if not parts:
        series += [*differences, *_states_and_log(runs)]
    if series:
        columns = min(4, ceil(sqrt(len(series))))
        tabs.append(ViewGroup("grid", series, title="All signals", columns=columns))
    tabs.append(Panel("page", "About this run" if len(runs) == 1 else "About these runs", "/about"))
    return ViewGroup("tabs", tabs)


def _named(runs: Sequence[RunPicture]) -> str:
    """The title for one run, or for several by their colours."""
    if len(runs) == 1:
        return "Run"
    return "Runs: " + ", ".join(f"{run.run} {palette.run_name(i)}" for i, run in enumerate(runs))


def _states_and_log(runs: Sequence[RunPicture]) -> list[View]:
    """States over time, and the log."""
    views: list[View] = []
    if any(run.has_states for run in runs):
        views.append(Panel("states", "Modes and solver status", "/states"))
    if len(runs) == 1 and runs[0].tells_values:
        views.append(Panel("page", "Values at the time cursor", "/now"))
    if any(run.has_events for run in runs):
        views.append(Panel("log", "Events", "/events"))
    return views


def _wall_time(runs: Sequence[RunPicture]) -> list[Series]:
    times = [run.at("performance", "step_time") for run in runs if run.timed]
    return [Series(f"Wall time [{MICROSECONDS}] per step", times)] if times else []


def _scenery(runs: Sequence[RunPicture]) -> View | None:
    """Bird's eye view, following view and friction circles, as far as there is something to show in them."""
    placed = [run for run in runs if run.scene is not None]
    circles = [run for run in runs if run.has_friction]
    views: list[View] = []
    if placed and (scene := placed[0].scene) is not None:
        y = (scene.y_left + scene.y_right) / 2
        followed = next((run.at("world", "follow") for run in placed if run.has_place), None)
        x, z = (12, 15) if followed else _OVER_ROAD
        trails = [run.at("world", "trail") for run in placed]
        bodies, flat = (
            [run.at("world", *what) for run in placed for what in hidden]
            for hidden in (
                (("ego", "body"), ("obstacles", "body")),
                (("ego", "footprint"), ("obstacles", "footprint"), ("path", "waypoints")),
            )
        )
        above, behind = "Bird's eye view: x to the right, y up", "Following view"
        views = [
            Scenery(above, followed or "/world", (x, y, z), (x, y, 0), (0, 1, 0), bodies, trails),
            Scenery(behind, followed or "/world", (-12, y, 6), (12, y, 0), (0, 0, 1), flat, trails),
        ]
    if circles:
        trails = [run.at("friction", "past") for run in circles]
        title = "Friction \N{LESS-THAN OR EQUAL TO} 1"
        views.append(Plane(title, "/friction", 2 * friction.APART, 1.6, trails, 2.0))
    if not views:
        return None
    return ViewGroup("row", views, [5, 2, 2] if len(views) == _PARTS_OF_SCENERY else None)


def _asked(runs: Sequence[RunPicture]) -> dict[str, list[View]]:
    """The series that answer each question, one signal in each; questions without an answer are left out."""
    signals: dict[str, dict[str, list[str]]] = {}
    for run in runs:
        for question, answers in plots.questions(run.system, run.signals).items():
            for plot in (one for answer in answers for one in answer.split(run.limits)):
                title = titled(plot.signals[0].name, plot.unit)
                signals.setdefault(question, {}).setdefault(title, []).extend(_entities(run, plot))
    views: dict[str, list[View]] = {
        question: [Series(title, contents) for title, contents in series.items()]
        for question, series in signals.items()
    }
    if path_errors := [run.at("derived", "path_error") for run in runs if run.has_path_error]:
        views.setdefault(plots.HARD, []).append(Series("path error [m]", path_errors))
    if gaps := [run.at("derived", "gap_obstacle") for run in runs if run.has_gap]:
        views.setdefault(plots.FAST, []).append(Series("gap [m]", gaps))
    return {question: views[question] for question in plots.QUESTIONS if question in views}


def _entities(run: RunPicture, plot: Plot) -> list[str]:
    """What a plot shows: its signals, and the limits that are near."""
    return [run.at("signals", *signal.parts) for signal in plot.signals] + [
        run.at(*plots.limit_parts(limit)) for limit in plot.limits if limit.is_near
    ]


def _answers(runs: Sequence[RunPicture], differences: Sequence[Series]) -> View | None:
    """A column for each question, with the question as its title."""
    columns = _asked(runs)
    if differences:
        columns[plots.FAST] = [*columns.get(plots.FAST, ()), *differences]
    return ViewGroup("row", [_headed(question, views) for question, views in columns.items()]) if columns else None


def _told(runs: Sequence[RunPicture]) -> list[View]:
    """The column of states, values and log, if there are any; it is as high as the window, because the log is long."""
    views = _states_and_log(runs)
    shares = [_TOLD_SHARES[view.kind] for view in views if isinstance(view, Panel)]
    return [_headed("When was what?", views, shares)] if views else []


def _headed(title: str, views: Sequence[View], shares: Sequence[float] | None = None) -> View:
    """Views below each other, as a tab, because the viewer shows the title of a column only where it is one."""
    return ViewGroup("tabs", [ViewGroup("column", views, shares, title)])


_TOLD_SHARES: Final = {"states": 1.0, "page": 1.2, "log": 1.5}
"""Shares of the room of states, values and log."""


def _by_bus(runs: Sequence[RunPicture]) -> list[Series]:
    """All signals by bus and unit of measurement, those of all runs in one view."""
    grouped: dict[str, list[tuple[RunPicture, Plot]]] = {}
    for run in runs:
        for plot in plots.by_bus(run.signals):
            grouped.setdefault(titled(plot.quantity, plot.unit), []).append((run, plot))
    return [_of_bus(title, same) for title, same in grouped.items()]


def _of_bus(title: str, same: Sequence[tuple[RunPicture, Plot]]) -> Series:
    """The signals of one bus, whose title names the series if there is room; else a short legend does."""
    contents = [name for run, plot in same for name in _entities(run, plot)]
    names = list(
        dict.fromkeys(name for run, plot in same for signal in plot.signals for name in run.series_names[signal.path])
    )
    paths = list(dict.fromkeys(signal.path for _, plot in same for signal in plot.signals))
    if len(paths) == len(names) == 1:
        return Series(titled(paths[0], same[0][1].unit), contents)
    named = f"{title}: {', '.join(names)}"
    if len(named) <= _QUARTER_TITLE:
        return Series(named, contents)
    return Series(title, contents, legend=not same[0][0].run and len(names) <= _LONGEST_LEGEND)
