"""Shapes and styles as Rerun archetypes: plain data comes in, calls of `rerun` go out."""
# pyright: basic
# rerun's column helpers carry few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from orchestrator.pictures import palette
from orchestrator.pictures import shapes as s

_PLANE: Final = 2
"""Coordinates of a point of a plane."""


def send_shapes(
    stream: rr.RecordingStream,
    ticks: NDArray[np.int64],
    times: NDArray[np.float64],
    shapes: Iterable[s.Shape | s.Style],
) -> None:
    """Send the shapes of consecutive rows, with one call for each.

    Args:
        stream: The recording.
        ticks: The tick of each row, `(n,)`.
        times: The time of each row [s], `(n,)`.
        shapes: Shapes of these rows; a style among them replaces the one at its entity.
    """
    every_row = _instants(ticks, times)
    for shape in shapes:
        if isinstance(shape, s.Style):
            send_style(stream, shape)
        elif shape.rows is None:
            stream.send_columns(shape.entity, every_row, _columns(shape))
        elif len(selected := ticks[shape.rows]):
            stream.send_columns(shape.entity, _instants(selected, times[shape.rows]), _columns(shape))


def send_style(stream: rr.RecordingStream, style: s.Style) -> None:
    """Send a style as static data, which holds for the whole recording."""
    for suffix, archetype in _static(style):
        stream.log(style.entity + suffix, archetype, static=True)


def _instants(ticks: NDArray[np.int64], times: NDArray[np.float64]) -> list[rr.TimeColumn]:
    nanoseconds = np.rint(times * 1e9).astype("timedelta64[ns]")  # `TimeColumn` itself would truncate
    return [rr.TimeColumn("sim_time", duration=nanoseconds), rr.TimeColumn("tick", sequence=ticks)]


def _columns(shape: s.Shape) -> Any:
    """A shape as columns of components."""
    columns: Any
    match shape:
        case s.SeriesValues():
            columns = rr.Scalars.columns(scalars=np.asarray(shape.values, dtype=float))
        case s.States():
            columns = rr.StateChange.columns(state=shape.names)
        case s.LogLines():
            colours = [palette.LEVELS[level] for level in shape.levels]
            columns = rr.TextLog.columns(text=shape.texts, level=shape.levels, color=colours)
        case s.Texts():
            columns = rr.TextDocument.columns(text=shape.texts)
        case s.Pose():
            columns = rr.Transform3D.columns(translation=shape.places, quaternion=shape.rotations)
        case s.Points():
            points = rr.Points2D if shape.places.shape[-1] == _PLANE else rr.Points3D
            columns = points.columns(positions=shape.places, colors=shape.colours, labels=shape.labels)
        case s.Lines():
            in_plane = len(shape.strips) and shape.strips[0].shape[-1] == _PLANE
            lines = rr.LineStrips2D if in_plane else rr.LineStrips3D
            columns = lines.columns(strips=shape.strips, colors=shape.colours, labels=shape.labels)
        case s.Solids():
            columns = rr.Boxes3D.columns(
                centers=shape.centres, half_sizes=shape.halves, quaternions=shape.rotations, labels=shape.labels
            )
        case _:
            raise TypeError(type(shape).__name__)
    return columns if not isinstance(shape, s.Several) or shape.counts is None else columns.partition(shape.counts)


def _static(style: s.Style) -> list[tuple[str, Any]]:
    """A style as archetypes, each with the suffix that leads from the style's entity to its own."""
    archetype: Any
    match style:
        case s.SeriesStyle():
            widths = [style.width] * len(style.names)
            steps = rr.components.InterpolationMode.StepAfter if style.held else None
            archetype = rr.SeriesLines(names=style.names, colors=style.colours, widths=widths, interpolation_mode=steps)
        case s.StateStyle():
            archetype = rr.StateConfiguration(values=list(style.names), colors=style.colours)
        case s.PointStyle():
            points = rr.Points2D if style.plane else rr.Points3D
            archetype = points.from_fields(colors=style.colour, radii=_radius(style.size, of_world=style.of_world))
        case s.LineStyle():
            lines = rr.LineStrips2D if style.plane else rr.LineStrips3D
            archetype = lines.from_fields(colors=style.colour, radii=_radius(style.size))
        case s.SolidStyle():
            archetype = rr.Boxes3D.from_fields(colors=style.colour, fill_mode="solid")
        case s.Still():
            lines = rr.LineStrips2D if style.strips[0].shape[-1] == _PLANE else rr.LineStrips3D
            radius = _radius(style.size, of_world=style.of_world)
            archetype = lines(style.strips, colors=style.colour, radii=radius, labels=style.labels)
        case s.Surface():
            archetype = _surface(style)
        case s.Page():
            archetype = rr.TextDocument.from_fields(text=style.text or None, media_type="text/markdown")
        case s.Car():
            return _car(style)
        case _:
            raise TypeError(type(style).__name__)
    return [("", archetype)]


def _surface(surface: s.Surface) -> rr.Mesh3D:
    (x_min, x_max), (y_min, y_max), z = surface.x, surface.y, -0.02
    return rr.Mesh3D(
        vertex_positions=[[x_min, y_min, z], [x_max, y_min, z], [x_max, y_max, z], [x_min, y_max, z]],
        triangle_indices=[[0, 1, 2], [0, 2, 3]],
        vertex_colors=[surface.colour] * 4,
    )


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
