"""The path between the waypoints, against the controller's own construction of it."""

from __future__ import annotations

import numpy as np
import pytest

from components.controller import dubins
from orchestrator.results.path_geometry import path_error, path_lines


def _path(w: float = 3.5, x_8: float = 62.0) -> dubins.Path:
    shape = dubins.LaneChange(w=w, R=20.39, l_d=4.0)
    return dubins.double_lane_change(shape, x_0=0.0, x_1=20.0, x_8=x_8, x_14=120.0, y_lane=0.0, corner=(27.0, 1.25))


@pytest.mark.parametrize(("w", "x_8"), [(3.5, 62.0), (-3.5, 62.0), (3.5, 20.0 + 17.01), (0.0, 62.0)])
def test_the_error_is_the_distance_from_the_controllers_path(w: float, x_8: float) -> None:
    path = _path(w, x_8)
    x = np.linspace(1.0, 119.0, 237)
    y = np.interp(x, [0, 30, 60, 120], [0.0, 2.9, 3.1, -0.4])
    nearest = np.array([path.point(path.project(a, b)) for a, b in zip(x, y, strict=True)], dtype=float)
    n = len(x)
    found = path_error(np.tile(path.waypoints.x, (n, 1)), np.tile(path.waypoints.y, (n, 1)), x, y)
    np.testing.assert_allclose(np.abs(found), np.hypot(x - nearest[:, 0], y - nearest[:, 1]), atol=1e-9)


def test_the_error_is_positive_to_the_left_also_beyond_the_ends() -> None:
    path = _path()
    x, y = np.array([-5.0, 10.0, 50.0, 130.0]), np.array([0.5, -0.25, 4.0, -1.0])
    found = path_error(np.tile(path.waypoints.x, (4, 1)), np.tile(path.waypoints.y, (4, 1)), x, y)
    np.testing.assert_allclose(found, [0.5, -0.25, 0.5, -1.0], atol=1e-12)


def test_waypoints_of_another_construction_are_joined_by_lines() -> None:
    x, y = np.arange(15.0), np.where(np.arange(15) % 2, 1.0, 0.0)
    np.testing.assert_array_equal(path_lines(x[None, :], y[None, :])[0], np.column_stack([x, y]))
    error = path_error(x[None, :], y[None, :], np.array([6.5]), np.array([0.5]))
    assert error == pytest.approx(0.0, abs=1e-12)


def test_waypoints_that_all_coincide_give_the_distance_across() -> None:
    zero = np.zeros((1, 15))
    assert path_error(zero, zero, np.array([3.0]), np.array([2.0])) == pytest.approx(2.0)


def test_the_line_to_draw_lies_on_the_path_and_is_fine() -> None:
    path = _path()
    line = path_lines(path.waypoints.x[None, :], path.waypoints.y[None, :])[0]
    n = len(line)
    error = path_error(np.tile(path.waypoints.x, (n, 1)), np.tile(path.waypoints.y, (n, 1)), line[:, 0], line[:, 1])
    np.testing.assert_allclose(error, 0.0, atol=1e-9)
    np.testing.assert_allclose(line[[0, -1]], [[0, 0], [120, 0]], atol=1e-9)
    turns = np.diff(np.arctan2(*np.diff(line, axis=0).T[::-1]))
    assert np.abs(turns).max() < np.radians(3)


def test_a_position_that_is_not_a_number_has_no_error() -> None:
    path = _path()
    x, y = np.array([np.inf, 5.0, 5.0]), np.array([0.0, np.nan, 0.5])
    found = path_error(np.tile(path.waypoints.x, (3, 1)), np.tile(path.waypoints.y, (3, 1)), x, y)
    np.testing.assert_array_equal(found, [np.nan, np.nan, 0.5])


def test_waypoints_that_coincide_but_for_rounding_do_not_hide_the_arcs():
    x = np.array([[0.0, 33.04, 40.62, 40.62, 40.62, 44.44, 44.44, 52.02, 83.42, 91.0, 94.82, 102.4, 115, 129, 142]])
    drop = 27.0 * (1 - np.cos(np.arcsin(7.58 / 27.0)))
    y = np.array([[0.0, 0, drop, drop, drop, 3.5 - drop, 3.5 - drop, 3.5, 3.5, 3.5 - drop, drop, 0, 0, 0, 0]])
    y[0, 3] += 4e-16  # what differs is the last bit
    halfway = np.arcsin(7.58 / 27.0) / 2
    on_arc = np.array([33.04 + 27 * np.sin(halfway)]), np.array([27 * (1 - np.cos(halfway))])
    assert abs(path_error(x, y, *on_arc)[0]) < 0.01
