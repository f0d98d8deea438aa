"""What stands where on the viewer's screen, as plain data: views, and rows, columns and tabs of them.

The first tab answers a person's questions about a run, or about several in one; the next holds all signals, the last
says where the runs come from. What the runs do not have, or did not record, is left out.

A legend hides the curves below it: where there is room, a title says the colours and the limits instead. In a
comparison a colour is a run, which the title of the tab says once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Final, TypeAlias

from orchestrator.pictures import friction, palette, plots
from orchestrator.pictures.plots import Limit, Plot
from orchestrator.pictures.run_picture import MICROSECONDS, RunPicture

_IN_A_FIFTH, _IN_A_QUARTER = 44, 58
"""characters; of a longer title a view in this share of a window shows only the beginning"""
_OVER_ROAD: Final = (60, 40)
"""[m] x and z of the eye that has no vehicle to follow: most of the road in one view"""
_LEGEND_AT_MOST: Final = 6
"""series; a longer legend would hide what it explains, and a series says its name when it is pointed at"""


@dataclass(frozen=True)
class Series:
    """Series over time, by their entities."""

    title: str
    contents: Sequence[str]
    legend: bool = False


@dataclass(frozen=True)
class Scenery:
    """The world around a moving frame `origin`, seen from `eye` towards `target`; `trails` show all of the past."""

    title: str
    origin: str
    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float]
    hidden: Sequence[str]
    trails: Sequence[str]


@dataclass(frozen=True)
class Plane:
    """A plane from (-x, -y) to (x, y); `trails` show the last `past` seconds."""

    title: str
    origin: str
    x: float
    y: float
    trails: Sequence[str]
    past: float


@dataclass(frozen=True)
class Panel:
    """What stands at `origin` and below it: `states` over time, lines of a `log`, or a `page` of text."""

    kind: str
    title: str
    origin: str


@dataclass(frozen=True)
class ViewGroup:
    """Views side by side (`row`), below each other (`column`), in a `grid`, or behind `tabs`; shares of the room."""

    kind: str
    parts: Sequence[View]
    shares: Sequence[float] | None = None
    title: str = ""
    columns: int = 1


View: TypeAlias = Series | Scenery | Plane | Panel | ViewGroup


def screen(runs: Sequence[RunPicture], differences: Sequence[Series] = ()) -> ViewGroup:
    """The screen for one run, or for several side by side."""
    scenery, asked = _scenery(runs), _asked(runs)
    tabs: list[View] = []
    if scenery is not None or asked:
        parts = [view for view in (scenery, _answers(runs, asked, differences)) if view is not None]
        tabs.append(ViewGroup("column", parts, [1, 2] if len(parts) > 1 else None, _named(runs)))
    series: list[View] = [*_joined([(run, plots.buses(run.signals)) for run in runs], by_bus=True)]
    if not tabs:
        series += [*differences, *_wall_time(runs), *_what_happened(runs)]
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


def _what_happened(runs: Sequence[RunPicture]) -> list[View]:
    """States over time, and the log."""
    found: list[View] = []
    if any(run.has_states for run in runs):
        found.append(Panel("states", "Modes and solver status", "/states"))
    if any(run.has_events for run in runs):
        found.append(Panel("log", "Events", "/events"))
    return found


def _wall_time(runs: Sequence[RunPicture]) -> list[Series]:
    times = [run.at("performance", "step_time") for run in runs if run.timed]
    return [Series(f"Wall time per step [{MICROSECONDS}]", times)] if times else []


def _scenery(runs: Sequence[RunPicture]) -> View | None:
    """Bird's eye view, following view and friction circles."""
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
    return ViewGroup("row", views, [5, 2, 2] if len(views) == 3 else None)  # noqa: PLR2004 - all three


def _asked(runs: Sequence[RunPicture]) -> dict[str, list[View]]:
    """The series that answer each question; a question without an answer is not there."""
    found: dict[str, list[View]] = {}
    for question, answers in _by_question(runs).items():
        found[question] = [*_joined(answers)]
    if erring := [run.at("derived", "path_error") for run in runs if run.has_path_error]:
        found.setdefault(plots.HARD, []).append(Series("Path error [m], left positive", erring))
    return {question: found[question] for question in plots.QUESTIONS if question in found}


def _answers(runs: Sequence[RunPicture], asked: Mapping[str, list[View]], differences: Sequence[Series]) -> View | None:
    """A column for each question, under its name; then what happened."""
    columns = dict(asked)
    if more := [*differences, *_wall_time(runs)]:
        columns[plots.FAST] = [*columns.get(plots.FAST, ()), *more]
    shares = [1.0] * len(columns)
    if happened := _what_happened(runs):
        columns[_WHEN], shares = happened, [*shares, 1.1]
    # a tab is the only head that the viewer gives to a column
    headed = [ViewGroup("tabs", [ViewGroup("column", views, title=question)]) for question, views in columns.items()]
    return ViewGroup("row", headed, shares) if headed else None


_WHEN: Final = "When was what?"


def _by_question(runs: Sequence[RunPicture]) -> dict[str, list[tuple[RunPicture, Sequence[Plot]]]]:
    """The plots of each question, run by run; in a comparison one signal each, so that a colour is a run."""
    found: dict[str, list[tuple[RunPicture, Sequence[Plot]]]] = {}
    for run in runs:
        for question, answers in plots.questions(run.system, run.signals).items():
            own = answers if len(runs) == 1 else [one for plot in answers for one in plot.split(run.limits)]
            found.setdefault(question, []).append((run, own))
    return found


def _joined(plots: Sequence[tuple[RunPicture, Sequence[Plot]]], *, by_bus: bool = False) -> list[Series]:
    """The plots of all runs, those with the same title in one view; titles are those of questions or `by_bus`."""
    found: dict[str, list[tuple[RunPicture, Plot]]] = {}
    for run, own in plots:
        for plot in own:
            found.setdefault(plot.title, []).append((run, plot))
    return [_series(title, same, by_bus=by_bus) for title, same in found.items()]


def _series(title: str, same: Sequence[tuple[RunPicture, Plot]], *, by_bus: bool) -> Series:
    """The plots of all runs in one view: its series named by the title if there is room, else by a short legend."""
    contents: list[str] = []
    for run, plot in same:
        contents += [run.at("signals", *path.split(".")) for path in plot.signals]
        contents += [run.at(*plots.limit_parts(limit)) for limit in plot.limits]
    limits = [limit for _, plot in same for limit in plot.limits]
    names = list(dict.fromkeys(name for run, plot in same for path in plot.signals for name in run.series_names[path]))
    whole, listed = _with_limits(title, limits), ", ".join(names)
    if len(names) == 1 and not by_bus:
        return Series(whole, contents)
    named, room = f"{title}: {listed}", _IN_A_QUARTER
    if not by_bus:  # a small window cuts the end, which here tells least
        quantity, _, unit = title.rpartition(" [")
        named, room = _with_limits(f"{listed} [{unit}", limits) + f": {quantity.lower()}", _IN_A_FIFTH
    if len(named) <= room:
        return Series(named, contents)
    is_alone = not same[0][0].run
    return Series(whole, contents, legend=is_alone and len(names) <= _LEGEND_AT_MOST)


def _with_limits(title: str, limits: Sequence[Limit]) -> str:
    """The title with the values of the limits that are drawn; their unit is that of the title, if there is one."""
    bounds = sorted({limit.value for limit in limits if limit.binds})
    match bounds:
        case []:
            pass
        case [low, high] if low == -high:
            title += f" \N{PLUS-MINUS SIGN}{high:.4g}"
        case [low, high] if low < 0 < high:
            title += f" {low:.4g} to {high:.4g}"
        case [high] if high > 0:
            title = f"{title.removesuffix(' [1]')} \N{LESS-THAN OR EQUAL TO} {high:.4g}"
        case _:
            title += f", limits {', '.join(f'{value:.4g}' for value in bounds)}"
    wanted: dict[str, list[str]] = {}
    for limit in (limit for limit in limits if not limit.binds):
        values = wanted.setdefault(limit.label.partition(" [")[0], [])
        values += [text for text in [f"{limit.value:.4g}"] if text not in values]
    return title + "".join(f", {name} {' and '.join(values)}" for name, values in wanted.items())
