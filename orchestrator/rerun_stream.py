"""A run as a Rerun recording: the world in 3D, every signal as a series, and a layout that a person understands.

The only file that imports `rerun`. `/world/...` is geometry in the road frame, z up; `/signals/<unit>/<bus>/<signal>`
holds every recorded signal, an array as one entity with a series per element; `/states/...` shows modes,
`/derived/...` what is computed from signals, `/limits/...` known limits, `/about` where the run comes from.
What does not change from one tick to the next is sent once: the viewer shows the latest value.
"""
# pyright: basic
# rerun's column helpers carry few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from orchestrator import layout, pictures
from orchestrator.layout import Limit, Plot
from orchestrator.path_geometry import path_lines
from orchestrator.pictures import Array, Columns
from orchestrator.scene import Scene
from orchestrator.system import System

_LEGEND_AT_MOST = 6
"""series; a longer legend would hide what it explains, and a series says its name when it is pointed at"""
_MICROSECONDS = "\N{MICRO SIGN}s"
_GROUND = (28, 32, 30)
_FLAT = 0.02
"""[m] height of the footprints: from above, bodies would hide where a vehicle ends"""
_EGO = (70, 150, 255)
_HEADING = (10, 25, 60)
_OBSTACLE = (215, 95, 45)
_BOUNDARY = (255, 195, 150)
_PATH = (190, 145, 255)
_PLAN = (255, 255, 255)
_CORRIDOR = (250, 205, 70)
_LIMIT = (150, 150, 150)
_STATES = {"converged": (70, 170, 110), "iteration_limit": (230, 170, 50), "fallback": (220, 70, 60)}
_SERIES = ((90, 160, 240), (240, 150, 60), (70, 185, 125), (225, 95, 95), (170, 130, 230), (80, 200, 210))


class RerunStream:
    """One recording on disk, fed with batches of consecutive rows.

    The scenery, styles and layout are written at once; every batch is sent in columns, one call per entity.
    """

    def __init__(  # noqa: PLR0913 - what a recording is made of
        self, path: Path, system: System, scene: Scene | None, *, name: str, h: float, about: Mapping[str, str]
    ) -> None:
        self._system, self._who = system, pictures.cast(system)
        self._signals, self._limits = pictures.signals(system), layout.limits(system)
        self._scene = None if self._who.is_empty else scene
        self._h = h
        self._ticks: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._times: list[rr.TimeColumn] = []
        self._last: dict[str, Array] = {}
        self._road = (0.0, 0.0)
        self._stream = rr.RecordingStream("macrostep")
        self._stream.set_log_time_enabled(False)
        self._stream.set_sinks(rr.FileSink(str(path)))
        self._stream.send_blueprint(blueprint(system, scene))
        self._stream.send_recording_name(name)
        self._static("/about", rr.TextDocument(_about(name, about), media_type="text/markdown"))
        self._style_series()
        if self._scene is not None:
            self._style_world(self._scene)

    def log(self, frame: pd.DataFrame, step_times: NDArray[np.float64]) -> None:
        """Send consecutive rows of `Simulation.frame()`, and the wall time [s] that each of their steps took."""
        if frame.empty:
            return
        columns = Columns(frame, self._signals)
        self._ticks = np.rint(columns.time / self._h).astype(np.int64)
        self._times = self._instants(self._ticks)
        self._send_signals(columns)
        self._scalars("/performance/step_time", np.asarray(step_times, dtype=float)[: len(frame)] * 1e6)
        error = pictures.errors(columns, self._who)
        if error is not None:
            self._scalars("/derived/path_error", error)
        if self._scene is not None:
            self._send_ego(columns, self._scene, error)
            self._send_obstacles(columns, self._scene)
            self._send_path(columns)
            self._send_plan(columns)

    def close(self) -> None:
        """Write what is left, and the file's footer."""
        self._stream.flush()
        self._stream.disconnect()

    def _static(self, path: str, *what: Any) -> None:
        self._stream.log(path, *what, static=True)

    def _send(self, path: str, columns: Iterable[Any], rows: NDArray[Any] | None = None) -> None:
        """Send columns for some rows of this batch, or for all."""
        if rows is None:
            self._stream.send_columns(path, self._times, columns)
        elif len(ticks := self._ticks[rows]):
            self._stream.send_columns(path, self._instants(ticks), columns)

    def _instants(self, ticks: NDArray[np.int64]) -> list[rr.TimeColumn]:
        nanoseconds = np.rint(ticks * self._h * 1e9).astype("timedelta64[ns]")  # TimeColumn itself truncates
        return [rr.TimeColumn("sim_time", duration=nanoseconds), rr.TimeColumn("tick", sequence=ticks)]

    def _scalars(self, path: str, values: NDArray[Any], rows: NDArray[Any] | None = None) -> None:
        self._send(path, rr.Scalars.columns(scalars=np.asarray(values, dtype=float)), rows)

    def _changed(self, path: str, values: Array) -> NDArray[np.bool_]:
        """Which rows are news at `path`, also with respect to the batch before."""
        rows = pictures.changed(values, self._last.get(path))
        self._last[path] = values[-1].copy()
        return rows

    def _style_series(self) -> None:
        seen: Counter[str] = Counter()
        for signal in self._signals:
            self._static(_entity("signals", signal.path), _lines(signal.labels, first=seen[signal.bus]))
            seen[signal.bus] += len(signal.columns)
            if names := list(signal.states.values()):
                colours = [_STATES.get(name, _SERIES[i % len(_SERIES)]) for i, name in enumerate(names)]
                self._static(_entity("states", signal.path), rr.StateConfiguration(values=names, colors=colours))
        for limit in self._limits:
            self._static(_limit(limit), rr.SeriesLines(names=limit.label, colors=_LIMIT, widths=1.0))
        if layout.has_path_error(self._system):
            self._static("/derived/path_error", _lines(["path error [m]"]))
        self._static("/performance/step_time", _lines([f"time per step [{_MICROSECONDS}]"]))

    def _style_world(self, scene: Scene) -> None:
        self._static("/world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
        if self._who.plant is not None:
            self._style_ego(scene)
        solid = rr.Boxes3D.from_fields(colors=_OBSTACLE, fill_mode="solid")
        styles = [
            ("obstacles", "/footprint", solid),
            ("obstacles", "/body", solid),
            ("obstacles", "/boundary", rr.LineStrips3D.from_fields(colors=_BOUNDARY, radii=_points(1.5))),
            ("path", "", rr.LineStrips3D.from_fields(colors=_PATH, radii=_points(1.5))),
            ("path", "/waypoints", rr.Points3D.from_fields(colors=_PATH, radii=_points(4))),
            ("plan", "", rr.LineStrips3D.from_fields(colors=_PLAN, radii=_points(2))),
            ("plan", "/points", rr.Points3D.from_fields(colors=_PLAN, radii=_points(3.5))),
            ("plan", "/corridor", rr.LineStrips3D.from_fields(colors=_CORRIDOR, radii=_points(2))),
        ]
        buses = {signal.bus.rpartition(".")[2] for signal in self._signals}
        for bus, entity, style in styles:
            if bus in buses:
                self._static(f"/world/{bus}{entity}", style)
        self._extend_road(scene, np.array([0.0, 100.0]))

    def _style_ego(self, scene: Scene) -> None:
        length, width = scene.ego_length, scene.ego_width
        self._static("/world/ego/footprint", _box(length, width, _FLAT, _EGO))
        self._static("/world/ego/body", _box(length, width, pictures.HEIGHT, _EGO))
        for name, z in (("footprint", _FLAT), ("body", pictures.HEIGHT)):
            arrow = rr.Arrows3D(
                origins=[[-0.3 * length, 0, z + 0.05]], vectors=[[0.7 * length, 0, 0]], colors=_HEADING, radii=0.14
            )
            self._static(f"/world/ego/{name}/heading", arrow)
        self._static("/world/trail", rr.Points3D.from_fields(radii=0.15))

    def _extend_road(self, scene: Scene, x: Array) -> None:
        """Draw the road anew where the places `x` reach beyond it."""
        places = np.clip(x[np.isfinite(x)], *pictures.ROAD_AT_MOST)
        needed = (places.min(initial=0) - pictures.ROAD_BEFORE, places.max(initial=0) + pictures.ROAD_BEFORE)
        if needed[0] < self._road[0] or needed[1] > self._road[1]:
            low = min(self._road[0], 100 * np.floor(needed[0] / 100))
            high = max(self._road[1], 100 * np.ceil(needed[1] / 100))
            self._road = (float(low), float(high))
            y_r, y_l = scene.y_right, scene.y_left
            surface = rr.Mesh3D(
                vertex_positions=[[low, y_r, -0.02], [high, y_r, -0.02], [high, y_l, -0.02], [low, y_l, -0.02]],
                triangle_indices=[[0, 1, 2], [0, 2, 3]],
                vertex_colors=[(58, 61, 66)] * 4,
            )
            self._static("/world/road", surface)
            edges = rr.LineStrips3D(
                [[[low, y, 0], [high, y, 0]] for y in (y_r, y_l)], colors=(225, 225, 225), radii=0.08
            )
            self._static("/world/road/edges", edges)
            marks = pictures.lane_marks(scene, low, high)
            self._static(
                "/world/road/lanes", rr.LineStrips3D(pictures.raised(marks, 0), colors=(190, 190, 190), radii=0.06)
            )

    def _send_signals(self, columns: Columns) -> None:
        for signal in columns.signals:
            values = columns.of(signal.path)
            self._scalars(_entity("signals", signal.path), values)
            if names := signal.states:
                entity = _entity("states", signal.path)
                rows = self._changed(entity, values[:, None])
                states = [names.get(int(value), str(value)) for value in values[rows]]
                self._send(entity, rr.StateChange.columns(state=states), rows)
        ends = np.unique([0, len(self._ticks) - 1])
        for limit in self._limits:
            self._scalars(_limit(limit), np.full(len(ends), limit.value), ends)

    def _send_ego(self, columns: Columns, scene: Scene, error: Array | None) -> None:
        state = columns.bus(self._who.plant, "state", "x", "y", "psi")
        if state is None:
            return
        x, y, psi = state
        self._extend_road(scene, x)
        place = np.column_stack([x, y, np.zeros_like(x)])
        turned = rr.Transform3D.columns(translation=place, quaternion=pictures.quaternions(psi))
        self._send("/world/ego", turned)
        self._send("/world/follow", rr.Transform3D.columns(translation=place * [1, 0, 1]))
        colours = (
            np.tile(np.array(_EGO, dtype=np.uint8), (len(x), 1)) if error is None else pictures.error_colours(error)
        )
        self._send(
            "/world/trail",
            rr.Points3D.columns(positions=pictures.raised(place[:, :2], 0.1), colors=pictures.rgba(colours)),
        )

    def _send_obstacles(self, columns: Columns, scene: Scene) -> None:
        found = pictures.obstacles(columns, self._who)
        if found is None:
            return
        boxes, known = found
        self._extend_road(scene, boxes.x)
        rows = self._changed("/world/obstacles", known)
        boxes = boxes.where(rows)
        place, size = np.column_stack([boxes.x, boxes.y]), np.column_stack([boxes.length, boxes.width]) / 2
        for name, height in (("footprint", _FLAT), ("body", pictures.HEIGHT)):
            half = np.full((len(place), 1), height / 2)
            solid = rr.Boxes3D.columns(
                centers=np.hstack([place, half]),
                half_sizes=np.hstack([size, half]),
                quaternions=pictures.quaternions(boxes.psi),
            )
            self._send(f"/world/obstacles/{name}", solid.partition(boxes.count), rows)
        strips = pictures.raised(pictures.outlines(boxes, scene.l_gap), 0.03)
        around = rr.LineStrips3D.columns(strips=strips, labels=[f"#{i}" for i in boxes.id])
        self._send("/world/obstacles/boundary", around.partition(boxes.count), rows)

    def _send_path(self, columns: Columns) -> None:
        path = columns.bus(self._who.controller, "path", "x", "y")
        if path is None:
            return
        rows = self._changed("/world/path", np.column_stack(path))
        x, y = path[0][rows], path[1][rows]
        strips = [pictures.raised(line, 0.04) for line in path_lines(x, y)]
        self._send("/world/path", rr.LineStrips3D.columns(strips=strips), rows)
        labels = [label for row in zip(x, y, strict=True) for label in pictures.waypoint_labels(*row)]
        points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.05)])
        waypoints = rr.Points3D.columns(positions=points, labels=labels).partition([x.shape[1]] * len(x))
        self._send("/world/path/waypoints", waypoints, rows)

    def _send_plan(self, columns: Columns) -> None:
        ego = columns.bus(self._who.plant, "state", "x", "y")
        plan = columns.bus(self._who.controller, "plan", "x", "y", "x_d", "y_upper", "y_lower")
        if plan is None:
            return
        x, y, x_d, upper, lower = plan
        ahead: NDArray[Any] = np.stack([x, y, np.full_like(x, 0.06)], axis=-1)
        points = rr.Points3D.columns(positions=ahead.reshape(-1, 3)).partition([x.shape[1]] * len(x))
        self._send("/world/plan/points", points)
        if ego is not None:
            start = np.column_stack([*ego, np.full(len(x), 0.06)])[:, None, :]
            self._send("/world/plan", rr.LineStrips3D.columns(strips=np.concatenate([start, ahead], axis=1)))
        height = np.full_like(x, 0.05)
        sides = np.stack([np.stack([x_d, side, height], axis=-1) for side in (upper, lower)], axis=1)
        strips: Any = sides.reshape(-1, *sides.shape[2:])
        self._send("/world/plan/corridor", rr.LineStrips3D.columns(strips=strips).partition([2] * len(x)))


def blueprint(system: System, scene: Scene | None) -> rrb.Blueprint:
    """The layout of a system's recordings: the scene over the questions, all signals, and where the run comes from."""
    sizes = {signal.path: len(signal.columns) for signal in pictures.signals(system)}
    plots = [_plot(p, legend=sum(sizes[path] for path in p.signals) <= _LEGEND_AT_MOST) for p in layout.buses(system)]
    signals = rrb.Grid(*plots, name="All signals")
    tabs: list[Any] = [signals, rrb.TextDocumentView(origin="/about", name="About this run")]
    if scene is not None and not pictures.cast(system).is_empty:
        y = (scene.y_left + scene.y_right) / 2
        views = rrb.Horizontal(_birds_eye(y), _chase(y), column_shares=[5, 2])
        tabs.insert(0, rrb.Vertical(views, _answers(system), row_shares=[3, 5], name="Run"))
    elif not pictures.cast(system).is_empty:
        tabs.insert(0, rrb.Vertical(_answers(system), name="Run"))
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="sim_time"),
    )


def _scene_view(name: str, hidden: Iterable[str], eye: rrb.EyeControls3D) -> rrb.View:
    """The world around the vehicle; the trail shows the whole past."""
    past: dict[str, Any] = {"start": rrb.TimeRangeBoundary.infinite(), "end": rrb.TimeRangeBoundary.cursor_relative()}
    trail = rrb.VisibleTimeRanges([rrb.VisibleTimeRange(timeline, **past) for timeline in ("sim_time", "tick")])
    return rrb.Spatial3DView(
        origin="/world/follow",
        contents=["/world/**", *(f"- /world/{entity}/**" for entity in hidden)],
        name=name,
        background=rrb.Background(color=_GROUND, kind="SolidColor"),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=eye,
        overrides={"/world/trail": [trail]},
    )


def _birds_eye(y: float) -> rrb.View:
    eye = rrb.EyeControls3D(position=(12, y, 15), look_target=(12, y, 0), eye_up=(0, 1, 0))
    return _scene_view("Bird's eye view: x to the right, y up", ["ego/body", "obstacles/body"], eye)


def _chase(y: float) -> rrb.View:
    eye = rrb.EyeControls3D(position=(-12, y, 6), look_target=(12, y, 0), eye_up=(0, 0, 1))
    return _scene_view("Following view", ["ego/footprint", "obstacles/footprint", "path/waypoints"], eye)


def _answers(system: System) -> rrb.Container:
    """Series grouped by question, a column each."""
    views: list[Any] = [_plot(plot, legend=len(plot.signals) > 1) for plot in layout.questions(system)]
    if layout.has_path_error(system):
        views.append(_series("How hard was it? Path error [m], left positive", ["/derived/path_error"]))
    time = _series(f"How fast was it? Wall time per step [{_MICROSECONDS}]", ["/performance/step_time"])
    modes = rrb.StateTimelineView(origin="/states", name="Modes and solver status")
    views.append(rrb.Vertical(modes, time) if any(s.states for s in pictures.signals(system)) else time)
    return rrb.Grid(*views, grid_columns=4)


def _plot(plot: Plot, *, legend: bool) -> rrb.View:
    contents = [_entity("signals", path) for path in plot.signals] + [_limit(limit) for limit in plot.limits]
    return _series(plot.title, contents, legend=legend)


def _series(title: str, contents: list[str], *, legend: bool = False) -> rrb.View:
    corner = rrb.PlotLegend(corner="lefttop", visible=legend)
    return rrb.TimeSeriesView(origin="/", contents=contents, name=title, plot_legend=corner)


@lru_cache(maxsize=4096)
def _entity(root: str, path: str) -> str:
    return str(rr.new_entity_path([root, *path.split(".")]))


def _limit(limit: Limit) -> str:
    return f"{_entity('limits', limit.signal)}/{'lower' if limit.value < 0 else 'upper'}"


def _lines(names: list[str], *, first: int = 0) -> rr.SeriesLines:
    colours = [_SERIES[(first + i) % len(_SERIES)] for i in range(len(names))]
    return rr.SeriesLines(names=names, colors=colours, widths=[1.5] * len(names))


def _box(length: float, width: float, height: float, colour: tuple[int, int, int]) -> rr.Boxes3D:
    half = [length / 2, width / 2, height / 2]
    return rr.Boxes3D(half_sizes=[half], centers=[[0, 0, half[2]]], colors=colour, fill_mode="solid")


def _points(size: float) -> Any:
    return rr.Radius.ui_points(size)


def _about(name: str, about: Mapping[str, str]) -> str:
    rows = "\n".join(f"| {key} | {value} |" for key, value in about.items())
    return f"# {name}\n\n| | |\n|---|---|\n{rows}\n"
