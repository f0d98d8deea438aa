"""The layout of the viewer's screen, as plain data: views, and rows, columns and tabs of views.

The first tab answers a person's questions about a run, or about several runs; the next holds all signals, the last says
where the runs come from. What the runs do not have, or did not record, is left out.

A legend hides the curves below it: where there is room, a title names the colours and the limits instead. In a
comparison each run has a colour, which the title of the tab names once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Final, TypeAlias

from orchestrator.pictures import friction, palette, plots
from orchestrator.pictures.driven import driven
from orchestrator.pictures.plots import Limit, Plot, titled
from orchestrator.pictures.run_picture import MICROSECONDS, RunPicture

_FIFTH_TITLE, _QUARTER_TITLE = 44, 58
"""Characters of the longest title that a view in this share of the window shows completely."""
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
    scenery, asked = _scenery(runs), _asked(runs)
    tabs: list[View] = []
    if scenery is not None or asked:
        parts = [view for view in (scenery, _answers(runs, asked, differences)) if view is not None]
        tabs.append(ViewGroup("column", parts, [1, 2] if len(parts) > 1 else None, _named(runs)))
    series: list[View] = [*_joined([(run, plots.by_bus(run.signals)) for run in runs], by_bus=True)]
    if followed := [run.at("signals", *c.path.split(".")) for run in runs for c in driven(run.system)]:
        series.append(Series("Inputs that follow the table", followed, legend=len(followed) <= _LONGEST_LEGEND))
    if not tabs:
        series += [*differences, *_wall_time(runs), *_states_and_log(runs)]
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
        title = "Friction circles, limit = 1"
        views.append(Plane(title, "/friction", 2 * friction.APART, 1.6, trails, 2.0))
    if not views:
        return None
    return ViewGroup("row", views, [5, 2, 2] if len(views) == _PARTS_OF_SCENERY else None)


def _asked(runs: Sequence[RunPicture]) -> dict[str, list[View]]:
    """The series that answer each question; questions without an answer are left out."""
    views: dict[str, list[View]] = {}
    for question, answers in _by_question(runs).items():
        views[question] = [*_joined(answers)]
    if path_errors := [run.at("derived", "path_error") for run in runs if run.has_path_error]:
        views.setdefault(plots.HARD, []).append(Series("Path error [m], left positive", path_errors))
    if gaps := [run.at("derived", "gap_obstacle") for run in runs if run.has_gap]:
        views.setdefault(plots.FAST, []).append(Series("Gap [m] to the nearest obstacle", gaps))
    return {question: views[question] for question in plots.QUESTIONS if question in views}


def _answers(runs: Sequence[RunPicture], asked: Mapping[str, list[View]], differences: Sequence[Series]) -> View | None:
    """A column for each question, with the question as its title; then a column for states and log."""
    columns = dict(asked)
    if more := [*differences, *_wall_time(runs)]:
        columns[plots.FAST] = [*columns.get(plots.FAST, ()), *more]
    shares = [1.0] * len(columns)
    if states_and_log := _states_and_log(runs):
        columns[_WHEN], shares = states_and_log, [*shares, 1.35]
    # The viewer shows the title of a column only where it is a tab.
    headed = [
        ViewGroup("tabs", [ViewGroup("column", views, _SHARES.get((question, len(views))), question)])
        for question, views in columns.items()
    ]
    return ViewGroup("row", headed, shares) if headed else None


_WHEN: Final = "When was what?"
_SHARES: Final = {(_WHEN, 3): [1.0, 1.45, 0.95]}
"""Shares of the room of a column's views, by its title and their number; else they are equal."""


def _by_question(runs: Sequence[RunPicture]) -> dict[str, list[tuple[RunPicture, Sequence[Plot]]]]:
    """The plots of each question, run by run; in a comparison each plot shows one signal, because a colour is a run."""
    grouped: dict[str, list[tuple[RunPicture, Sequence[Plot]]]] = {}
    for run in runs:
        for question, answers in plots.questions(run.system, run.signals).items():
            own = answers if len(runs) == 1 else [one for plot in answers for one in plot.split(run.limits)]
            grouped.setdefault(question, []).append((run, own))
    return grouped


def _joined(plots: Sequence[tuple[RunPicture, Sequence[Plot]]], *, by_bus: bool = False) -> list[Series]:
    """The plots of all runs, those with the same title in one view; titles are those of questions or `by_bus`."""
    grouped: dict[str, list[tuple[RunPicture, Plot]]] = {}
    for run, own in plots:
        for plot in own:
            title = titled(plot.quantity, plot.unit) if by_bus else plot.title
            grouped.setdefault(title, []).append((run, plot))
    return [_series(same, by_bus=by_bus) for same in grouped.values()]


def _series(same: Sequence[tuple[RunPicture, Plot]], *, by_bus: bool) -> Series:
    """Plots of the same title in one view, whose title names the series if there is room; else a short legend does."""
    contents: list[str] = []
    for run, plot in same:
        contents += [run.at("signals", *signal.parts) for signal in plot.signals]
        contents += [run.at(*plots.limit_parts(limit)) for limit in plot.limits if limit.is_near]
    limits = [limit for _, plot in same for limit in plot.limits]
    names = list(
        dict.fromkeys(name for run, plot in same for signal in plot.signals for name in run.series_names[signal.path])
    )
    run, plot = same[0]
    listed = ", ".join(names) if by_bus or len(names) > 1 else plot.signals[0].name
    named, room = f"{titled(plot.quantity, plot.unit)}: {listed}", _QUARTER_TITLE
    if not by_bus:  # a small window cuts off the end, where the quantity tells least
        named, room = f"{_with_limits(listed, plot.unit, limits)}: {plot.quantity.lower()}", _FIFTH_TITLE
    if len(named) <= room:
        return Series(named, contents)
    whole = _with_limits(plot.quantity, plot.unit, limits)
    return Series(whole, contents, legend=not run.run and len(names) <= _LONGEST_LEGEND)


def _with_limits(quantity: str, unit: str | None, limits: Sequence[Limit]) -> str:
    """The title of a quantity with the values of its limits, whose unit of measurement is that of the quantity."""
    title = titled(quantity, unit)
    bounds = sorted({limit.value for limit in limits if limit.binds})
    match bounds:
        case []:
            pass
        case [low, high] if low == -high:
            title += f" \N{PLUS-MINUS SIGN}{high:.4g}"
        case [low, high] if low < 0 < high:
            title += f" {low:.4g} to {high:.4g}"
        case [high] if high > 0:
            title = f"{quantity if unit == '1' else title} \N{LESS-THAN OR EQUAL TO} {high:.4g}"
        case _:
            title += f", limits {', '.join(f'{value:.4g}' for value in bounds)}"
    desired: dict[str, list[str]] = {}
    for limit in (limit for limit in limits if not limit.binds):
        values = desired.setdefault(limit.name, [])
        values += [text for text in [f"{limit.value:.4g}"] if text not in values]
    return title + "".join(f", {name} {' and '.join(values)}" for name, values in desired.items())
