"""The world of one run as shapes: road, ego vehicle and trail, obstacles and their boundaries, path, plan, corridor."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from components.interfaces.maths import Array
from orchestrator.pictures import drawing, palette
from orchestrator.pictures.drawing import Boxes
from orchestrator.pictures.shapes import (
    Car,
    Colour,
    Lines,
    LineStyle,
    Memory,
    Points,
    PointStyle,
    Pose,
    Shape,
    Solids,
    SolidStyle,
    Still,
    Style,
    Surface,
    entity,
)
from orchestrator.pictures.signals import (
    OBSTACLE_SIGNALS,
    PATH_SIGNALS,
    PLAN_SIGNALS,
    POSE_SIGNALS,
    BusSignals,
    Recorded,
    SignalColumns,
)
from orchestrator.results.path_geometry import path_lines
from orchestrator.system.scene import ROAD_AT_MOST, Scene
from orchestrator.system.shown import BusPaths

FLAT: Final = 0.02
"""[m] Height of the footprints, which are drawn from above, where bodies would hide the ends of a vehicle."""

_NAME_DISTANCE: Final = 0.7
"""[m] Distance of the name of a vehicle from its side."""
_NAME_SPACING: Final = 1.1
"""[m] Distance between the names of several runs."""

_PARTS: Final[Mapping[str, BusSignals]] = {
    "ego": POSE_SIGNALS,
    "obstacles": OBSTACLE_SIGNALS,
    "path": PATH_SIGNALS,
    "plan": PLAN_SIGNALS,
}
"""The parts of the world, and the signals that they are drawn from."""


def recorded_parts(recorded: Recorded, buses: BusPaths) -> set[str]:
    """Which of the parts `ego`, `obstacles`, `path` and `plan` can be drawn.

    Args:
        recorded: What is recorded of a run.
        buses: The buses of its system.
    """
    return {part for part, signals in _PARTS.items() if recorded.bus(buses, *signals)}


class World:
    """What is drawn of the world of a run.

    Args:
        buses: The buses of its system.
        scene: The road, and the size of the ego vehicle.
        run: The run's part of the entity paths; empty for a run on its own.
        colour: In a comparison, the colour of the run, which its trail, path and plan have; None for a run on its own.
        number: The place of the run in a comparison. The names of the vehicles stand in this order below each other:
            on the road for the view from above, in the air for the view that follows.
    """

    def __init__(self, buses: BusPaths, scene: Scene, run: str, colour: Colour | None, number: int = 0) -> None:
        self._below = number * _NAME_SPACING
        self._buses, self._scene, self._run, self._colour = buses, scene, run, colour
        self._memory = Memory()
        self._road = (0.0, 0.0)

    def _at(self, *parts: str) -> str:
        return entity("world", self._run, *parts)

    def styles(self, parts: set[str]) -> Iterator[Style]:
        """What holds from the start.

        Args:
            parts: The parts that are recorded, as `recorded_parts` gives them.
        """
        own = self._colour
        path, plan = (palette.PATH, palette.PLAN) if own is None else (palette.paler(own, 0.3), own)
        corridor = palette.CORRIDOR if own is None else palette.paler(own)
        if "ego" in parts:
            for name, height in (("footprint", FLAT), ("body", drawing.HEIGHT)):
                yield Car(
                    entity=self._at("ego", name),
                    length=self._scene.ego_length,
                    width=self._scene.ego_width,
                    height=height,
                    colour=own or palette.EGO,
                    label=self._run or "ego",
                    label_at=self._label_at(name),
                    shared=own is not None,
                )
            yield PointStyle(entity=self._at("trail"), size=0.15, of_world=True, colour=own)
        if "obstacles" in parts:
            yield SolidStyle(entity=self._at("obstacles", "footprint"), colour=palette.OBSTACLE)
            yield SolidStyle(entity=self._at("obstacles", "body"), colour=palette.OBSTACLE)
            yield LineStyle(entity=self._at("obstacles", "boundary"), size=1.5, colour=own or palette.BOUNDARY)
        if "path" in parts:
            yield LineStyle(entity=self._at("path"), size=1.5, colour=path)
            yield PointStyle(
                entity=self._at("path", "waypoints"), size=4, colour=palette.WAYPOINT if own is None else path
            )
        if "plan" in parts:
            yield LineStyle(entity=self._at("plan"), size=2, colour=plan)
            yield PointStyle(entity=self._at("plan", "points"), size=3.5, colour=plan)
            yield LineStyle(entity=self._at("plan", "corridor"), size=2, colour=corridor)

    def shapes(
        self, columns: SignalColumns, error: Array | None, boxes: tuple[Boxes, Array] | None
    ) -> Iterator[Shape | Style]:
        """The world in a batch of rows; the road is drawn anew where they reach beyond it.

        Args:
            columns: The rows.
            error: The path error [m] in each row, `(n,)`; None where it is not known.
            boxes: The obstacles, and all that is known of them, as `drawing.obstacles` gives them.
        """
        ego = columns.bus(self._buses, *POSE_SIGNALS)
        places = [np.array([0.0, 100.0]), *([] if ego is None else [ego[0]]), *([] if boxes is None else [boxes[0].x])]
        yield from self._road_to(np.concatenate(places))
        if ego is not None:
            yield from self._ego(ego, error)
        if boxes is not None:
            yield from self._obstacles(*boxes)
        yield from self._path(columns)
        yield from self._plan(columns, ego)

    def _label_at(self, name: str) -> tuple[float, float, float]:
        side = -self._scene.ego_width / 2 - _NAME_DISTANCE
        return (0, side - self._below, FLAT) if name == "footprint" else (0, side, drawing.HEIGHT - self._below)

    def _road_to(self, x: Array) -> Iterator[Style]:
        places = np.clip(x[np.isfinite(x)], *ROAD_AT_MOST)
        needed = (places.min(initial=0) - drawing.ROAD_BEFORE, places.max(initial=0) + drawing.ROAD_BEFORE)
        if needed[0] >= self._road[0] and needed[1] <= self._road[1]:
            return
        low = float(min(self._road[0], 100 * np.floor(needed[0] / 100)))
        high = float(max(self._road[1], 100 * np.ceil(needed[1] / 100)))
        self._road = (low, high)
        sides = self._scene.y_right, self._scene.y_left
        yield Surface(entity=self._at("road"), x=self._road, y=sides, colour=palette.ROAD)
        edges = np.array([[[low, y, 0], [high, y, 0]] for y in sides])
        yield Still(entity=self._at("road", "edges"), strips=edges, colour=palette.EDGE, size=0.08, of_world=True)
        marks = drawing.raised(drawing.lane_marks(self._scene, low, high), 0)
        yield Still(entity=self._at("road", "lanes"), strips=marks, colour=palette.MARK, size=0.06, of_world=True)

    def _ego(self, ego: tuple[Array, ...], error: Array | None) -> Iterator[Shape]:
        x, y, psi = ego
        places = np.column_stack([x, y, np.zeros_like(x)])
        yield Pose(entity=self._at("ego"), places=places, rotations=drawing.quaternions(psi))
        yield Pose(entity=self._at("follow"), places=places * [1, 0, 1])
        colours = None
        if self._colour is None:
            plain = np.tile(np.array(palette.EGO, dtype=np.uint8), (len(x), 1))
            colours = drawing.rgba(plain if error is None else drawing.error_colours(error))
        yield Points(entity=self._at("trail"), places=drawing.raised(places[:, :2], 0.1), colours=colours)

    def _obstacles(self, boxes: Boxes, known: Array) -> Iterator[Shape]:
        rows = self._memory.news("obstacles", known)
        boxes = boxes.where(rows)
        place, size = np.column_stack([boxes.x, boxes.y]), np.column_stack([boxes.length, boxes.width]) / 2
        turned = drawing.quaternions(boxes.psi)
        for name, height in (("footprint", FLAT), ("body", drawing.HEIGHT)):
            half = np.full((len(place), 1), height / 2)
            yield Solids(
                entity=self._at("obstacles", name),
                rows=rows,
                counts=boxes.count,
                centres=np.hstack([place, half]),
                halves=np.hstack([size, half]),
                rotations=turned,
            )
        yield Lines(
            entity=self._at("obstacles", "boundary"),
            rows=rows,
            counts=boxes.count,
            strips=drawing.raised(drawing.boundaries(boxes, self._scene.l_gap), 0.03),
            labels=[f"#{i}" for i in boxes.id],
        )

    def _path(self, columns: SignalColumns) -> Iterator[Shape]:
        path = columns.bus(self._buses, *PATH_SIGNALS)
        if path is None:
            return
        rows = self._memory.news("path", np.column_stack(path))
        x, y = path[0][rows], path[1][rows]
        strips = [drawing.raised(line, 0.04) for line in path_lines(x, y)]
        yield Lines(entity=self._at("path"), rows=rows, strips=strips)
        labels = drawing.waypoint_labels(x, y) if self._colour is None else None
        points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.05)])
        counts = [x.shape[1]] * len(x)
        yield Points(entity=self._at("path", "waypoints"), rows=rows, places=points, labels=labels, counts=counts)

    def _plan(self, columns: SignalColumns, ego: tuple[Array, ...] | None) -> Iterator[Shape]:
        plan = columns.bus(self._buses, *PLAN_SIGNALS)
        if plan is None:
            return
        x, y, x_d, upper, lower = plan
        ahead = np.stack([x, y, np.full_like(x, 0.06)], axis=-1)
        each = [x.shape[1]] * len(x)
        yield Points(entity=self._at("plan", "points"), places=ahead.reshape(-1, 3), counts=each)
        if ego is not None:
            start = np.column_stack([ego[0], ego[1], np.full(len(x), 0.06)])[:, None, :]
            yield Lines(entity=self._at("plan"), strips=np.concatenate([start, ahead], axis=1))
        height = np.full_like(x, 0.05)
        sides = np.stack([np.stack([x_d, side, height], axis=-1) for side in (upper, lower)], axis=1)
        strips = sides.reshape(-1, *sides.shape[2:])
        yield Lines(entity=self._at("plan", "corridor"), strips=strips, counts=[2] * len(x))
