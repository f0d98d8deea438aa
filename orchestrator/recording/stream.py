"""A run as a Rerun recording: sends the shapes of `run_picture` and the layout of `screen` to files and viewers.

The only file that imports `rerun`, whose API moves fast: plain data comes in, archetypes go out. What does not change
from one tick to the next is sent once: the viewer shows the latest value.
"""
# pyright: basic
# rerun's column helpers carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import contextlib
import time as clock
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray
from rerun.blueprint.encodings import TextLogColumn, TimelineColumn
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from orchestrator.pictures import pages, palette
from orchestrator.pictures import screen as screens
from orchestrator.pictures import shapes as s
from orchestrator.pictures.run_picture import RunPicture
from orchestrator.system.scene import Scene
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd


class RerunStream:
    """One recording on disk, or to the viewer at a URL, fed with batches of consecutive rows.

    The scenery, styles and layout are written at once; every batch is sent in columns, one call per entity.
    `recorded` are the columns that come in the same batches, everything in every batch if not given.
    Streams with the same `recording_id` are one recording to a viewer.
    """

    def __init__(  # noqa: PLR0913 - what a recording is made of
        self,
        sink: Path | str,
        system: System,
        scene: Scene | None,
        *,
        name: str,
        h: float,
        about: Mapping[str, str],
        recorded: Sequence[Collection[str]] | None = None,
        recording_id: str | None = None,
    ) -> None:
        self._picture, self._h = RunPicture(system, scene, recorded=recorded), h
        self._name, self._last = name, 0
        page = s.Page(entity="/about", text=pages.page(name, about, system))
        screen = screens.screen([self._picture])
        self._stream = _opened(sink, name, screen, [page, *self._picture.styles()], recording_id)

    def log(self, frame: pd.DataFrame | Mapping[str, Any], step_times: NDArray[np.float64] | None) -> None:
        """Send consecutive rows of `Simulation.frame()`, and the wall time [s] that each of their steps took.

        Signals that are recorded at different ticks come one after the other, each with their own rows.
        """
        ticks = np.rint(np.asarray(frame["time"]) / self._h).astype(np.int64)
        if not len(ticks):
            return
        self._last = max(self._last, int(ticks[-1]))
        send_shapes(self._stream, ticks, self._h, self._picture.shapes(frame, step_times))

    def flush(self) -> None:
        """Write what has been logged, so that it survives this process."""
        self._stream.flush()

    def close(self, about: Mapping[str, str] | None = None) -> None:
        """Write what is left, the run's provenance as it is known in the end, and the file's footer.

        A `fault` in it is told in the log too, at the last tick.
        """
        if about is not None:
            if "fault" in about:
                send_shapes(self._stream, np.array([self._last]), self._h, [self._picture.fault(about["fault"])])
            send_style(self._stream, s.Page(entity="/about", text=pages.page(self._name, about, self._picture.system)))
        self._stream.flush()
        self._stream.disconnect()


def write(
    path: Path,
    name: str,
    screen: screens.Group,
    styles: Iterable[s.Style],
    batches: Iterable[tuple[NDArray[np.int64], float, Iterable[s.Shape | s.Style]]],
) -> None:
    """A whole recording at once: each batch by its ticks, its macro step [s] and its shapes."""
    stream = _opened(path, name, screen, styles)
    for ticks, h, shapes in batches:
        send_shapes(stream, ticks, h, shapes)
    stream.flush()
    stream.disconnect()


def _opened(
    sink: Path | str, name: str, screen: screens.Group, styles: Iterable[s.Style], recording_id: str | None = None
) -> rr.RecordingStream:
    """A recording with all that stands from the start."""
    stream = rr.RecordingStream("macrostep", recording_id=recording_id)
    stream.set_log_time_enabled(False)
    stream.set_sinks(rr.GrpcSink(sink) if isinstance(sink, str) else rr.FileSink(str(sink)))
    stream.send_blueprint(blueprint(screen))
    stream.send_recording_name(name)
    for style in styles:
        send_style(stream, style)
    return stream


def read_series(path: Path) -> dict[str, tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Ticks (n,) and values (n, elements) of every series in a recording, by entity."""
    parts: dict[str, list[tuple[Any, Any]]] = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names and not chunk.is_static:
            values = np.array(batch.column("Scalars:scalars").to_pylist(), dtype=float)
            ticks = np.array(batch.column("tick").cast("int64").to_pylist(), dtype=np.int64)
            parts.setdefault(chunk.entity_path, []).append((ticks, values))
    found: dict[str, tuple[NDArray[np.int64], NDArray[np.float64]]] = {}
    for entity, chunks in parts.items():
        ticks, first = np.unique(np.concatenate([ticks for ticks, _ in chunks]), return_index=True)
        found[entity] = ticks, np.concatenate([values for _, values in chunks])[first]
    return found


def screenshots(url: str, recording: Path, times: Sequence[float | None], settle: float) -> Iterator[bytes]:
    """Open a recording in the viewer at `url`, and after `settle` [s] give a PNG of the window at each time [s].

    Raises `ConnectionError` when the viewer does not answer, and `ValueError` when it finds nothing to show.
    """
    try:
        viewer = _patiently(lambda: ViewerClient.connect(url), _ANSWERS_WITHIN)
        _patiently(lambda: viewer.open(str(recording.resolve())), _ANSWERS_WITHIN)
        if not _loads(viewer):
            raise ValueError("nothing that the viewer can show")
        clock.sleep(settle)
        for time in times:
            if time is not None:
                # a run without rows has no time; that the viewer is gone shows in the next line
                with contextlib.suppress(RuntimeError, OSError):
                    _patiently(
                        partial(viewer.set_time, "sim_time", duration=time, play_state="paused"), _HAS_ROWS_WITHIN
                    )
            yield _still_picture(viewer)
    except (RuntimeError, OSError) as error:
        raise ConnectionError(str(error).partition("\n")[0]) from error


def _patiently(action: Callable[[], Any], seconds: float) -> Any:
    """The result of an action that may fail for a while."""
    deadline = clock.monotonic() + seconds
    while True:
        try:
            return action()
        except (RuntimeError, OSError):
            if clock.monotonic() > deadline:
                raise
            clock.sleep(0.1)


def _loads(viewer: ViewerClient) -> bool:
    """Wait until a recording is loaded and has views; whether that comes."""
    deadline = clock.monotonic() + _ANSWERS_WITHIN
    while clock.monotonic() < deadline:
        state = viewer.get_state()
        if state.recordings and state.views and not state.loading:
            return True
        clock.sleep(0.1)
    return False


def _still_picture(viewer: ViewerClient) -> bytes:
    """A picture that is the same as the one before: all views are drawn."""
    deadline, last = clock.monotonic() + _DRAWS_WITHIN, b""
    while True:
        clock.sleep(0.3)
        picture = viewer.take_screenshot()
        if picture == last or clock.monotonic() > deadline:
            return picture
        last = picture


_ANSWERS_WITHIN, _HAS_ROWS_WITHIN, _DRAWS_WITHIN = 30.0, 5.0, 10.0
"""[s]"""


def send_shapes(
    stream: rr.RecordingStream, ticks: NDArray[np.int64], h: float, shapes: Iterable[s.Shape | s.Style]
) -> None:
    """Send the shapes of consecutive rows, one call each."""
    all_rows = _instants(ticks, h)
    for shape in shapes:
        if isinstance(shape, s.Style):
            send_style(stream, shape)
        elif shape.rows is None:
            stream.send_columns(shape.entity, all_rows, _columns(shape))
        elif len(some := ticks[shape.rows]):
            stream.send_columns(shape.entity, _instants(some, h), _columns(shape))


def _instants(ticks: NDArray[np.int64], h: float) -> list[rr.TimeColumn]:
    nanoseconds = np.rint(ticks * h * 1e9).astype("timedelta64[ns]")  # TimeColumn itself truncates
    return [rr.TimeColumn("sim_time", duration=nanoseconds), rr.TimeColumn("tick", sequence=ticks)]


def _columns(shape: s.Shape) -> Any:
    """A shape as columns of components."""
    made: Any
    match shape:
        case s.Values():
            made = rr.Scalars.columns(scalars=np.asarray(shape.values, dtype=float))
        case s.States():
            made = rr.StateChange.columns(state=shape.names)
        case s.Messages():
            made = rr.TextLog.columns(text=shape.texts, level=shape.levels)
        case s.Pose():
            made = rr.Transform3D.columns(translation=shape.places, quaternion=shape.rotations)
        case s.Points():
            kind = rr.Points2D if shape.places.shape[-1] == _PLANE else rr.Points3D
            made = kind.columns(positions=shape.places, colors=shape.colours, labels=shape.labels)
        case s.Lines():
            flat = len(shape.strips) and shape.strips[0].shape[-1] == _PLANE
            kind = rr.LineStrips2D if flat else rr.LineStrips3D
            made = kind.columns(strips=shape.strips, colors=shape.colours, labels=shape.labels)
        case s.Solids():
            made = rr.Boxes3D.columns(
                centers=shape.centres, half_sizes=shape.halves, quaternions=shape.rotations, labels=shape.labels
            )
        case _:
            raise TypeError(type(shape).__name__)
    return made if not isinstance(shape, s.Several) or shape.counts is None else made.partition(shape.counts)


_PLANE = 2
"""Coordinates of a point of a plane"""


def send_style(stream: rr.RecordingStream, style: s.Style) -> None:
    """Send what stands from the start."""
    for below, archetype in _still(style):
        stream.log(style.entity + below, archetype, static=True)


def _still(style: s.Style) -> list[tuple[str, Any]]:
    """A style as archetypes, with where each stands below the style's entity."""
    match style:
        case s.SeriesStyle():
            widths = [style.width] * len(style.names)
            found: Any = rr.SeriesLines(names=style.names, colors=style.colours, widths=widths)
        case s.StateStyle():
            found = rr.StateConfiguration(values=list(style.names), colors=style.colours)
        case s.PointStyle():
            kind = rr.Points2D if style.plane else rr.Points3D
            found = kind.from_fields(colors=style.colour, radii=_radius(style.size, of_world=style.of_world))
        case s.LineStyle():
            kind = rr.LineStrips2D if style.plane else rr.LineStrips3D
            found = kind.from_fields(colors=style.colour, radii=_radius(style.size))
        case s.SolidStyle():
            found = rr.Boxes3D.from_fields(colors=style.colour, fill_mode="solid")
        case s.Still():
            kind = rr.LineStrips2D if style.strips[0].shape[-1] == _PLANE else rr.LineStrips3D
            radius = _radius(style.size, of_world=style.of_world)
            found = kind(style.strips, colors=style.colour, radii=radius, labels=style.labels)
        case s.Surface():
            (x_min, x_max), (y_min, y_max), z = style.x, style.y, -0.02
            corners = [[x_min, y_min, z], [x_max, y_min, z], [x_max, y_max, z], [x_min, y_max, z]]
            found = rr.Mesh3D(
                vertex_positions=corners, triangle_indices=[[0, 1, 2], [0, 2, 3]], vertex_colors=[style.colour] * 4
            )
        case s.Page():
            found = rr.TextDocument(style.text, media_type="text/markdown")
        case s.Car():
            return _car(style)
        case _:
            raise TypeError(type(style).__name__)
    return [("", found)]


def _car(car: s.Car) -> list[tuple[str, Any]]:
    half = [car.length / 2, car.width / 2, car.height / 2]
    box = rr.Boxes3D(
        half_sizes=[half],
        centers=[[0, 0, half[2]]],
        colors=car.colour,
        fill_mode="TransparentFillMajorWireframe" if car.shared else "solid",
    )
    arrow = rr.Arrows3D(
        origins=[[-0.3 * car.length, 0, car.height + 0.05]],
        vectors=[[0.7 * car.length, 0, 0]],
        colors=palette.HEADING,
        radii=0.14,
    )
    name = rr.Points3D([car.label_at], radii=0.01, colors=palette.NAME, labels=[car.label], show_labels=True)
    return [("", box), ("/heading", arrow), ("/name", name)]


def _radius(size: float, *, of_world: bool = False) -> Any:
    return size if of_world else rr.Radius.ui_points(size)


def blueprint(screen: screens.Group) -> rrb.Blueprint:
    """The viewer's layout for a screen."""
    return rrb.Blueprint(
        _view(screen),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="sim_time"),
    )


def _view(view: screens.View) -> Any:
    made: Any
    match view:
        case screens.Group():
            made = _group(view)
        case screens.Series():
            legend = rrb.PlotLegend(visible=view.legend)
            axis = rrb.TimeAxis(link="LinkToGlobal")  # who looks closer at one plot sees the same seconds in all
            made = rrb.TimeSeriesView(
                origin="/", contents=view.contents, name=view.title, axis_x=axis, plot_legend=legend
            )
        case screens.Scenery():
            made = _scenery(view)
        case screens.Plane():
            made = rrb.Spatial2DView(
                origin=view.origin,
                name=view.title,
                background=palette.GROUND,
                visual_bounds=rrb.VisualBounds2D(x_range=[-view.x, view.x], y_range=[-view.y, view.y]),
                overrides=_trails(view.trails, view.past),
            )
        case screens.Panel(kind="states"):
            made = rrb.StateTimelineView(origin=view.origin, name=view.title)
        case screens.Panel(kind="log"):
            made = rrb.TextLogView(origin=view.origin, name=view.title, columns=_log_columns())
        case screens.Panel():
            made = rrb.TextDocumentView(origin=view.origin, name=view.title)
    return made


def _group(group: screens.Group) -> Any:
    parts, name = [_view(part) for part in group.parts], group.title or None
    match group.kind:
        case "row":
            return rrb.Horizontal(*parts, column_shares=group.shares, name=name)
        case "column":
            return rrb.Vertical(*parts, row_shares=group.shares, name=name)
        case "grid":
            return rrb.Grid(*parts, grid_columns=group.columns, name=name)
        case _:
            return rrb.Tabs(*parts, active_tab=0, name=name)


def _scenery(view: screens.Scenery) -> rrb.View:
    return rrb.Spatial3DView(
        origin=view.origin,
        contents=["/world/**", *(f"- {entity}/**" for entity in view.hidden)],
        name=view.title,
        background=rrb.Background(color=palette.GROUND, kind="SolidColor"),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(position=view.eye, look_target=view.target, eye_up=view.up),
        overrides=_trails(view.trails, None),
    )


def _log_columns() -> rrb.TextLogColumns:
    return rrb.TextLogColumns(
        timeline_columns=[TimelineColumn("sim_time")],
        text_log_columns=[TextLogColumn(kind) for kind in ("LogLevel", "Body")],
    )


def _trails(entities: Sequence[str], past: float | None) -> Any:
    """Entities that show the last `past` seconds, or all of the past."""
    start = rrb.TimeRangeBoundary.infinite()
    if past is not None:
        start = rrb.TimeRangeBoundary.cursor_relative(seconds=-past)
    ends: dict[str, Any] = {"start": start, "end": rrb.TimeRangeBoundary.cursor_relative()}
    timelines = ("sim_time", "tick") if past is None else ("sim_time",)
    shown = rrb.VisibleTimeRanges([rrb.VisibleTimeRange(timeline, **ends) for timeline in timelines])
    return {entity: [shown] for entity in entities}
