"""The world of a run as shapes."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.scenario import Options, prepare
from orchestrator.viewing import pictures, shapes
from orchestrator.viewing.signals import Columns, Recorded, cast, signals
from orchestrator.viewing.world import World, recorded_parts

STATIC = prepare("static", Options(mode="blocks"))
WHO = cast(STATIC.system)


def _columns(x):
    n = len(x)
    rows = {"time": np.arange(n) * 0.1, "plant.state.x": np.array(x, dtype=float)}
    rows |= {f"plant.state.{name}": np.zeros(n) for name in ("y", "psi", "v_x", "v_y", "r")}
    return Columns(rows, signals(STATIC.system))


@pytest.fixture
def world():
    return World(WHO, STATIC.scene, "", None)


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
    np.testing.assert_array_equal(colours(world, error), pictures.rgba(pictures.error_colours(error)))
    other = World(WHO, STATIC.scene, "other", (1, 2, 3))
    assert colours(other, error) is None
    trail = next(s for s in other.styles({"ego"}) if s.entity == "/world/other/trail")
    assert trail.colour == (1, 2, 3)


def test_vehicles_have_names_and_can_be_seen_through_beside_others(world):
    cars = [style for style in world.styles({"ego"}) if isinstance(style, shapes.Car)]
    assert [(car.label, car.shared) for car in cars] == [("ego", False)] * 2
    other = World(WHO, STATIC.scene, "other", (1, 2, 3))
    cars = [style for style in other.styles({"ego"}) if isinstance(style, shapes.Car)]
    assert [(car.label, car.shared, car.colour) for car in cars] == [("other", True, (1, 2, 3))] * 2


def test_the_names_of_runs_stand_apart_from_above_and_from_behind():
    worlds = [World(WHO, STATIC.scene, name, (1, 2, 3), i) for i, name in enumerate("abc")]
    cars = [[style for style in world.styles({"ego"}) if isinstance(style, shapes.Car)] for world in worlds]
    for i, axis in ((0, 1), (1, 2)):  # the footprint is seen from above, where y is up; the body from behind
        places = np.array([found[i].label_at for found in cars])
        assert (np.diff(places[:, axis]) < -1).all()
        np.testing.assert_array_equal(np.delete(np.ptp(places, axis=0), axis), 0)
        assert (places[:, 1] < -STATIC.scene.ego_width / 2).all(), "beside the vehicle"


def test_only_parts_that_are_recorded_are_drawn(world):
    assert list(world.styles(set())) == []
    recorded = Recorded(STATIC.system, [["plant.state.x", "plant.state.y", "plant.state.psi"]])
    assert recorded_parts(recorded, WHO) == {"ego"}
    assert recorded_parts(Recorded(STATIC.system), WHO) == {"ego", "obstacles", "path", "plan"}
