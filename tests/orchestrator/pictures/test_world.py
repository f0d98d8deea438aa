"""The world of a run as shapes."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.pictures import drawing, shapes
from orchestrator.pictures.signals import Recorded, SignalColumns, signals
from orchestrator.pictures.world import World, recorded_parts
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.shown import shown

STATIC = prepare("static", Options(mode="blocks"))
BUSES = shown(STATIC.system)


def _columns(x):
    n = len(x)
    rows = {"time": np.arange(n) * 0.1, "plant.state.x": np.array(x, dtype=float)}
    rows |= {f"plant.state.{name}": np.zeros(n) for name in ("y", "psi", "v_x", "v_y", "r")}
    return SignalColumns(rows, signals(STATIC.system))


@pytest.fixture
def world():
    return World(BUSES, STATIC.scene, "", None)


def test_the_road_is_drawn_anew_only_where_the_run_reaches_beyond_it(world):
    drawn = []
    for x in ([0, 10], [20, 100], [150, 170], [171, 172], [-30, 0]):
        found = world.shapes(_columns(x), None, None)
        drawn.append([shape.x for shape in found if isinstance(shape, shapes.Surface)])
    assert drawn == [[(-100.0, 200.0)], [], [(-100.0, 300.0)], [], []]


def test_a_vehicle_that_is_lost_gets_no_road(world):
    found = world.shapes(_columns([0, 1e8, np.nan]), None, None)
    (surface,) = [shape for shape in found if isinstance(shape, shapes.Surface)]
    assert surface.x[1] <= 1.1e4


def test_the_trail_is_coloured_by_error_alone_and_by_run_beside_others(world):
    def colours(made, error):
        found = {s.entity: s for s in made.shapes(_columns([0, 1]), error, None) if isinstance(s, shapes.Points)}
        return next(shape.colours for entity, shape in found.items() if entity.endswith("trail"))

    error = np.array([0.0, 0.5])
    np.testing.assert_array_equal(colours(world, error), drawing.rgba(drawing.error_colours(error)))
    other = World(BUSES, STATIC.scene, "other", (1, 2, 3))
    assert colours(other, error) is None
    trail = next(s for s in other.styles({"ego"}) if s.entity == "/world/other/trail")
    assert trail.colour == (1, 2, 3)


def test_vehicles_have_names_and_can_be_seen_through_beside_others(world):
    cars = [style for style in world.styles({"ego"}) if isinstance(style, shapes.Car)]
    assert [(car.label, car.shared) for car in cars] == [("ego", False)] * 2
    other = World(BUSES, STATIC.scene, "other", (1, 2, 3))
    cars = [style for style in other.styles({"ego"}) if isinstance(style, shapes.Car)]
    assert [(car.label, car.shared, car.colour) for car in cars] == [("other", True, (1, 2, 3))] * 2


def test_the_names_of_runs_stand_apart_from_above_and_from_behind():
    worlds = [World(BUSES, STATIC.scene, name, (1, 2, 3), i) for i, name in enumerate("abc")]
    cars = [[style for style in world.styles({"ego"}) if isinstance(style, shapes.Car)] for world in worlds]
    for i, axis in ((0, 1), (1, 2)):  # the footprint is seen from above, where y is up; the body from behind
        places = np.array([found[i].label_at for found in cars])
        assert (np.diff(places[:, axis]) < -1).all()
        np.testing.assert_array_equal(np.delete(np.ptp(places, axis=0), axis), 0)
        assert (places[:, 1] < -STATIC.scene.ego_width / 2).all(), "beside the vehicle"


def test_only_parts_that_are_recorded_are_drawn(world):
    assert list(world.styles(set())) == []
    recorded = Recorded(STATIC.system, [["plant.state.x", "plant.state.y", "plant.state.psi"]])
    assert recorded_parts(recorded, BUSES) == {"ego"}
    assert recorded_parts(Recorded(STATIC.system), BUSES) == {"ego", "obstacles", "path", "plan"}


@pytest.fixture(scope="module")
def dynamic():
    """Some rows of a run in which everything moves, with obstacles that turn; and their shapes by entity and kind."""
    made = prepare("dynamic", Options(mode="blocks"))
    with Simulation(made.system, h=made.h, until=3.0) as simulation:
        simulation.run()
        frame = simulation.frame()
    for slot in range(1, 9):
        frame[f"traffic.obstacles.psi[{slot}]"] = 0.1 * slot
    columns, buses = SignalColumns(frame, signals(made.system)), shown(made.system)
    drawn = World(buses, made.scene, "", None).shapes(columns, None, drawing.obstacles(columns, buses))
    return frame, made.scene, {(shape.entity, type(shape)): shape for shape in drawn}


def _columns_of(frame, bus, length):
    return frame[[f"{bus}[{i + 1}]" for i in range(length)]].to_numpy()


def _headings(rotations):
    """Angles about z of quaternions (n, 4), x, y, z, w."""
    np.testing.assert_array_equal(rotations[:, :2], 0)
    return 2 * np.arctan2(rotations[:, 2], rotations[:, 3])


def test_the_vehicle_stands_where_it_is_and_heads_where_it_heads(dynamic):
    frame, _, found = dynamic
    ego, follow = found["/world/ego", shapes.Pose], found["/world/follow", shapes.Pose]
    np.testing.assert_array_equal(ego.places[:, :2], frame[["plant.state.x", "plant.state.y"]])
    assert np.ptp(frame["plant.state.psi"]) > 0.01
    np.testing.assert_allclose(_headings(ego.rotations), frame["plant.state.psi"], atol=1e-6)
    np.testing.assert_array_equal(follow.places[:, 0], frame["plant.state.x"])
    assert not follow.places[:, 1:].any(), "the road does not sway"
    np.testing.assert_array_equal(found["/world/trail", shapes.Points].places[:, :2], ego.places[:, :2])


def test_obstacles_have_their_size_heading_identity_and_safety_boundary(dynamic):
    frame, scene, found = dynamic
    (slot, *_) = [i for i in range(1, 9) if frame[f"traffic.obstacles.valid[{i}]"].all()]
    x, y, psi, length, width, name = (
        frame[f"traffic.obstacles.{signal}[{slot}]"] for signal in ("x", "y", "psi", "length", "width", "id")
    )
    for part in ("footprint", "body"):
        box = found[f"/world/obstacles/{part}", shapes.Solids]
        first = np.cumsum(box.counts) - box.counts
        np.testing.assert_allclose(box.centres[first, :2], np.column_stack([x, y])[box.rows])
        np.testing.assert_allclose(box.halves[first, :2], np.column_stack([length, width])[box.rows] / 2)
        np.testing.assert_allclose(_headings(box.rotations[first]), psi[box.rows], atol=1e-6)
    boundary = found["/world/obstacles/boundary", shapes.Lines]
    assert boundary.labels[0] == f"#{name[0]}"
    away = boundary.strips[0][:, :2] - [x[0], y[0]]
    along, across = away @ [np.cos(psi[0]), np.sin(psi[0])], away @ [-np.sin(psi[0]), np.cos(psi[0])]
    assert along.max() == pytest.approx(length[0] / 2 + scene.l_gap)
    assert across.max() == pytest.approx(width[0] / 2 + scene.l_gap)


def test_path_horizon_and_corridor_are_those_the_controller_shows_at_the_tick(dynamic):
    frame, _, found = dynamic
    rows, horizon = len(frame), sum(name.startswith("controller.plan.x[") for name in frame)
    x, y, x_d, upper, lower = (
        _columns_of(frame, f"controller.plan.{name}", horizon) for name in ("x", "y", "x_d", "y_upper", "y_lower")
    )
    ahead = np.asarray(found["/world/plan", shapes.Lines].strips)[..., :2]
    np.testing.assert_array_equal(ahead[:, 0], frame[["plant.state.x", "plant.state.y"]])
    np.testing.assert_array_equal(ahead[:, 1:], np.stack([x, y], axis=-1))
    points = found["/world/plan/points", shapes.Points]
    np.testing.assert_array_equal(points.places[:, :2], np.stack([x, y], axis=-1).reshape(-1, 2))
    corridor = found["/world/plan/corridor", shapes.Lines]
    assert corridor.counts == [2] * rows
    sides = np.asarray(corridor.strips).reshape(rows, 2, horizon, 3)
    assert (upper > lower).all()
    np.testing.assert_array_equal(sides[:, 0, :, :2], np.stack([x_d, upper], axis=-1))
    np.testing.assert_array_equal(sides[:, 1, :, :2], np.stack([x_d, lower], axis=-1))
    waypoints = found["/world/path/waypoints", shapes.Points]
    each = np.stack([_columns_of(frame, f"controller.path.{name}", 15) for name in "xy"], axis=-1)
    np.testing.assert_array_equal(waypoints.places[:, :2].reshape(-1, 15, 2), each[waypoints.rows])
    assert waypoints.labels[0] == "P0"
