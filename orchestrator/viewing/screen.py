"""What stands where on the viewer's screen, as plain data: views, and rows, columns and tabs of them.

The first tab answers a person's questions about a run, or about several in one; the next holds all signals, the last
says where the runs come from. What the runs do not have is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from orchestrator.viewing import friction, layout
from orchestrator.viewing.layout import Plot
from orchestrator.viewing.run_picture import MICROSECONDS, RunPicture
from orchestrator.viewing.shapes import entity

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
class Timeline:
    """States over time."""

    title: str
    origin: str


@dataclass(frozen=True)
class Log:
    """Lines of a log."""

    title: str
    origin: str


@dataclass(frozen=True)
class Document:
    """A page of text."""

    title: str
    origin: str


@dataclass(frozen=True)
class Group:
    """Views side by side (`row`), below each other (`column`), in a `grid`, or behind `tabs`; shares of the room."""

    kind: str
    parts: Sequence[View]
    shares: Sequence[float] | None = None
    title: str = ""
    columns: int = 1


View: TypeAlias = Series | Scenery | Plane | Timeline | Log | Document | Group


def screen(runs: Sequence[RunPicture], differences: Sequence[Series] = ()) -> Group:
    """The screen for one run, or for several side by side."""
    tabs: list[View] = []
    if any(not run.who.is_empty for run in runs):
        title, scenery, answers = "Run" if len(runs) == 1 else "Runs", _scenery(runs), _answers(runs, differences)
        rows = Group("column", [answers], None, title)
        tabs.append(rows if scenery is None else Group("column", [scenery, answers], [3, 5], title))
    plots: list[View] = [*_joined([(run, layout.buses(run.system)) for run in runs])]
    if not tabs:
        plots += _what_there_is(runs)
    tabs.append(Group("grid", plots, title="All signals", columns=4))
    tabs.append(Document("About this run" if len(runs) == 1 else "About these runs", "/about"))
    return Group("tabs", tabs)


def _what_there_is(runs: Sequence[RunPicture]) -> list[View]:
    """What stands beside the signals of systems without vehicle, traffic and controller."""
    found: list[View] = [*_wall_time(runs)]
    if any(signal.states or signal.is_text for run in runs for signal in run.signals):
        found.append(Timeline("Modes and texts", "/states"))
    return found


def _wall_time(runs: Sequence[RunPicture]) -> list[Series]:
    times = [entity("performance", run.run, "step_time") for run in runs if run.timed]
    return [Series(f"Wall time per step [{MICROSECONDS}]", times)] if times else []


def _scenery(runs: Sequence[RunPicture]) -> View | None:
    """Bird's eye view, following view and friction circles."""
    placed = [run for run in runs if run.scene is not None]
    circles = [run for run in runs if friction.is_known(run.system, run.who)]
    views: list[View] = []
    if placed and (scene := placed[0].scene) is not None:
        y = (scene.y_left + scene.y_right) / 2
        origin = entity("world", placed[0].run, "follow")
        trails = [entity("world", run.run, "trail") for run in placed]
        bodies, flat = (
            [entity("world", run.run, *what) for run in placed for what in hidden]
            for hidden in (
                (("ego", "body"), ("obstacles", "body")),
                (("ego", "footprint"), ("obstacles", "footprint"), ("path", "waypoints")),
            )
        )
        above, behind = "Bird's eye view: x to the right, y up", "Following view"
        views = [
            Scenery(above, origin, (12, y, 15), (12, y, 0), (0, 1, 0), bodies, trails),
            Scenery(behind, origin, (-12, y, 6), (12, y, 0), (0, 0, 1), flat, trails),
        ]
    if circles:
        trails = [entity("friction", run.run, "past") for run in circles]
        title = "Friction circles, limit = 1"
        views.append(Plane(title, "/friction", 2 * friction.APART, 1.6, trails, 2.0))
    if not views:
        return None
    return Group("row", views, [5, 2, 2] if len(views) == 3 else None)  # noqa: PLR2004 - all three


def _answers(runs: Sequence[RunPicture], differences: Sequence[Series]) -> View:
    """Series grouped by question, a column each; then what happened."""
    several = len(runs) > 1
    columns: dict[str, list[View]] = {question: [] for question in layout.QUESTIONS}
    for question, plots in _by_question(runs).items():
        columns[question] += _joined(plots)
    erring = [entity("derived", run.run, "path_error") for run in runs if layout.has_path_error(run.system)]
    if erring:
        columns[layout.HARD].append(Series("Path error [m], left positive", erring, several))
    columns[layout.FAST] += [*differences, *_wall_time(runs)]
    columns["When was what?"] = [Timeline("Modes and solver status", "/states"), Log("Events", "/events")]
    asked = [
        Group("column", [replace(views[0], title=f"{question} {views[0].title}"), *views[1:]])
        for question, views in columns.items()
        if views
    ]
    return Group("row", asked, [1] * (len(asked) - 1) + [1.3])


def _by_question(runs: Sequence[RunPicture]) -> dict[str, list[tuple[RunPicture, Sequence[Plot]]]]:
    """The plots of each question, run by run; in a comparison one signal each, so that a colour is a run."""
    found: dict[str, list[tuple[RunPicture, Sequence[Plot]]]] = {}
    for run in runs:
        for question, plots in layout.questions(run.system).items():
            own = plots if len(runs) == 1 else [one for plot in plots for one in plot.split(run.limits)]
            found.setdefault(question, []).append((run, own))
    return found


def _joined(plots: Sequence[tuple[RunPicture, Sequence[Plot]]]) -> list[Series]:
    """The plots of all runs, those with the same title in one view; with a legend if that is short."""
    contents: dict[str, list[str]] = {}
    series: dict[str, int] = {}
    for run, found in plots:
        sizes = {signal.path: len(signal.columns) for signal in run.signals}
        for plot in found:
            entities = [entity("signals", run.run, *path.split(".")) for path in plot.signals]
            limits = [entity(layout.limit_parts(x)[0], run.run, *layout.limit_parts(x)[1:]) for x in plot.limits]
            contents.setdefault(plot.title, []).extend([*entities, *limits])
            crowd = _LEGEND_AT_MOST * len(plot.limits) if run.run else 0  # limits would hide the runs
            series[plot.title] = series.get(plot.title, 0) + sum(sizes[path] for path in plot.signals) + crowd
    return [Series(title, parts, 1 < series[title] <= _LEGEND_AT_MOST) for title, parts in contents.items()]
