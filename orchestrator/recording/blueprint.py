"""The screen of `pictures.screen` as a blueprint, the viewer's own description of a layout."""
# pyright: basic
# rerun's blueprint carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.encodings import TextLogColumn, TimelineColumn

from orchestrator.pictures import palette
from orchestrator.pictures import screen as screens
from orchestrator.recording.axes import AxisRange, axis_range


class Layout(rrb.Blueprint):
    """A blueprint that leaves nothing behind when it has been sent.

    Rerun sends a blueprint by a stream of its own in memory, which keeps itself alive, with two threads, until somebody
    disconnects it.
    """

    def send(self, stream: rr.RecordingStream) -> None:
        """Send it to a recording."""
        stream.send_blueprint(self)
        self._inner.disconnect()

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        self._inner = stream
        super()._log_to_stream(stream)


def blueprint(
    screen: screens.ViewGroup, extremes: Mapping[str, AxisRange] | None = None, *, followed: bool = False
) -> Layout:
    """The viewer's layout for a screen, with its own panels collapsed.

    Args:
        screen: What stands where.
        extremes: The smallest and the largest value of each series, by entity, as far as they are known; the viewer
            chooses the range of the other axes.
        followed: Whether the viewer shows the newest row while more come.
    """
    playing = "following" if followed else None
    return Layout(
        _view(screen, extremes or {}),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="sim_time", play_state=playing),
    )


def _view(view: screens.View, extremes: Mapping[str, AxisRange]) -> Any:
    match view:
        case screens.ViewGroup():
            return _group(view, extremes)
        case screens.Series():
            return _series(view, extremes)
        case screens.Scenery():
            return _scenery(view)
        case screens.Plane():
            return rrb.Spatial2DView(
                origin=view.origin,
                name=view.title,
                background=palette.GROUND,
                visual_bounds=rrb.VisualBounds2D(x_range=[-view.x, view.x], y_range=[-view.y, view.y]),
                overrides=_trails(view.trails, view.past),
            )
        case screens.Panel():
            return _panel(view)


def _group(group: screens.ViewGroup, extremes: Mapping[str, AxisRange]) -> Any:
    parts, name = [_view(part, extremes) for part in group.parts], group.title or None
    match group.kind:
        case "row":
            return rrb.Horizontal(*parts, column_shares=group.shares, name=name)
        case "column":
            return rrb.Vertical(*parts, row_shares=group.shares, name=name)
        case "grid":
            return rrb.Grid(*parts, grid_columns=group.columns, name=name)
        case _:
            return rrb.Tabs(*parts, active_tab=0, name=name)


def _series(view: screens.Series, extremes: Mapping[str, AxisRange]) -> rrb.View:
    known = [] if view.is_high else [extremes[entity] for entity in view.contents if entity in extremes]
    ends = axis_range(known)
    return rrb.TimeSeriesView(
        origin="/",
        contents=view.contents,
        name=view.title,
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),  # zooming into one plot shows the same seconds in all plots
        axis_y=None if ends is None else rrb.ScalarAxis(range=ends),
        plot_legend=None if view.legend else rrb.PlotLegend(visible=False),
    )


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


def _panel(view: screens.Panel) -> rrb.View:
    match view.kind:
        case "states":
            return rrb.StateTimelineView(origin=view.origin, name=view.title)
        case "log":
            return rrb.TextLogView(origin=view.origin, name=view.title, columns=_log_columns())
        case _:
            return rrb.TextDocumentView(origin=view.origin, name=view.title)


def _log_columns() -> rrb.TextLogColumns:
    return rrb.TextLogColumns(
        timeline_columns=[TimelineColumn("sim_time")],
        text_log_columns=[TextLogColumn("Body")],
    )


def _trails(entities: Sequence[str], past: float | None) -> Any:
    """Overrides by which entities show the last `past` seconds, or all of the past where it is None."""
    start = rrb.TimeRangeBoundary.infinite()
    if past is not None:
        start = rrb.TimeRangeBoundary.cursor_relative(seconds=-past)
    ends: dict[str, Any] = {"start": start, "end": rrb.TimeRangeBoundary.cursor_relative()}
    timelines = ("sim_time", "tick") if past is None else ("sim_time",)
    ranges = rrb.VisibleTimeRanges([rrb.VisibleTimeRange(timeline, **ends) for timeline in timelines])
    return {entity: [ranges] for entity in entities}
