"""Metrics on signals made by hand, and which rows count for them (`finite_rows.py`)."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.buses import Actuation, Motion, ObstacleList, Plan, Solver, Tyre, VehicleState, Waypoints
from orchestrator.results.metrics import compute, verdicts
from orchestrator.system.scene import Scene

SCENE = Scene(
    ego_length=4.0, ego_width=2.0, y_left=5.0, y_right=-2.0, y_lane=0.0, y_adjacent=3.5, y_third=1e6, l_gap=0.3
)
BUSES = {
    VehicleState: "car.state",
    Tyre: "car.tyre",
    Motion: "car.motion",
    ObstacleList: "others.obstacles",
    Actuation: "driver.actuation",
    Waypoints: "driver.path",
    Plan: "driver.plan",
    Solver: "driver.solver",
}
N = 5


def rows(**changed):
    """A car that stands at the origin; one obstacle in slot 2, 10 m ahead."""
    frame = {"time": np.arange(N) * 0.5}
    frame |= {f"car.state.{s}": np.zeros(N) for s in ("x", "y", "psi", "v_x", "v_y", "r")}
    frame |= {f"driver.actuation.{s}": np.zeros(N) for s in ("delta_f", "T_r")}
    for i in range(8):
        frame[f"others.obstacles.valid[{i + 1}]"] = np.full(N, i == 1)
        frame[f"others.obstacles.x[{i + 1}]"] = np.full(N, 10.0 * i)
        frame |= {f"others.obstacles.{s}[{i + 1}]": np.zeros(N) for s in ("y", "psi", "v")}
        frame |= {
            f"others.obstacles.length[{i + 1}]": np.full(N, 4.0),
            f"others.obstacles.width[{i + 1}]": np.full(N, 2.0),
        }
    return pd.DataFrame({**frame, **{name.replace("__", "."): value for name, value in changed.items()}})


def test_the_gap_to_an_obstacle_is_between_the_boxes_and_invalid_slots_do_not_count():
    assert compute(rows(), BUSES, SCENE)["gap_obstacle"] == pytest.approx(6.0)


def test_a_turned_car_reaches_further():
    psi = np.array([0, 0, np.pi / 2, 0, 0])
    assert compute(rows(car__state__psi=psi, car__state__y=[0, 0, 1.5, 0, 0]), BUSES, SCENE)[
        "gap_edge"
    ] == pytest.approx(1.0)
    assert compute(rows(car__state__x=[0, 1, 2, 3, 4.0]), BUSES, SCENE)["gap_obstacle"] == pytest.approx(2.0)


def test_contact_and_leaving_the_road_turn_the_verdicts():
    fine = compute(rows(), BUSES, SCENE)
    assert verdicts(fine) == {"no_contact": True, "inside_road": True}
    hit = compute(rows(car__state__x=[0, 0, 7.0, 0, 0]), BUSES, SCENE)
    assert hit["gap_obstacle"] == 0
    assert verdicts(hit)["no_contact"] is False
    off = compute(rows(car__state__y=[0, 0, -1.1, 0, 0]), BUSES, SCENE)
    assert off["gap_edge"] == pytest.approx(-0.1)
    assert verdicts(off)["inside_road"] is False


def test_yaw_rate_metrics():
    found = compute(rows(car__state__r=[0, 0.2, -0.1, 0, 0]), BUSES, SCENE)
    assert found["r_peak"] == pytest.approx(0.2)
    assert found["r_total_variation"] == pytest.approx(0.6)
    assert found["r_dot_peak"] == pytest.approx(0.6)
    assert found["r_dot_rms"] == pytest.approx(np.sqrt((0.4**2 + 0.6**2 + 0.2**2) / 4))


def test_friction_and_solver_verdicts():
    tyre = {"car__tyre__mu_f": np.array([0, 0.4, 0.9, 0, 0]), "car__tyre__mu_r": np.full(N, 0.2)}
    solver = {
        "driver__solver__status": np.array([1, 1, 2, 3, 1]),
        "driver__solver__iterations": np.arange(N),
        "driver__solver__kkt": np.full(N, 1e-9),
    }
    found = compute(rows(**tyre, **solver), BUSES, SCENE)
    assert (found["mu_f_max"], found["solver_limits"], found["solver_fallbacks"]) == (0.9, 1, 1)
    assert verdicts(found)["within_friction_limit"] is True
    assert verdicts(found)["solver_converged"] is False
    assert verdicts({**found, "mu_r_max": 1.01})["within_friction_limit"] is False


def test_path_error_is_the_distance_to_the_path_of_the_same_row():
    straight = {f"driver__path__x[{i + 1}]": np.full(N, 10.0 * i - 20) for i in range(15)}
    level = {f"driver__path__y[{i + 1}]": np.full(N, 0.5) for i in range(15)}
    found = compute(rows(**straight, **level, car__state__y=[0.5, 0.5, 0.8, 0.5, 0.1]), BUSES, SCENE)
    assert found["path_error_max"] == pytest.approx(0.4)
    assert found["path_error_rms"] == pytest.approx(np.sqrt((0.3**2 + 0.4**2) / 5))


def test_corridor_violations_count_predicted_points_outside():
    plan = {"driver__plan__y[1]": [0, 1.2, 0, -1.2, 0], "driver__plan__y_upper[1]": np.ones(N)}
    found = compute(rows(**plan, **{"driver__plan__y_lower[1]": -np.ones(N)}), BUSES, SCENE)
    assert found["corridor_violations"] == 2


def test_columns_that_are_no_data_frame_give_the_same():
    columns = {
        "time": np.arange(3) * 0.1,
        "car.state.r": np.array([0, 0.2, np.inf]),
        "car.name": np.array([*"abc"], object),
    }
    found = compute(columns, BUSES, SCENE)
    assert found == compute(pd.DataFrame(columns), BUSES, SCENE)
    assert (found["r_peak"], found["r_dot_peak"]) == (0.2, 2.0)
    assert compute({name: values[2:] for name, values in columns.items()}, BUSES, SCENE) == {}


def test_a_system_without_sockets_has_no_metrics():
    assert compute(rows(), {}, SCENE) == {}


def test_a_bus_that_is_not_finite_takes_nothing_from_the_metrics_of_others():
    tyre = {"car__tyre__mu_f": np.array([np.nan, 0.4, 0.9, 0, 0]), "car__tyre__mu_r": np.full(N, 0.2)}
    absent = {"others__obstacles__x[1]": np.full(N, np.nan)}
    other = {"car__ttc": np.full(N, np.inf)}
    x = [8.0, 0, 0, 0, 0]
    found = compute(rows(**tyre, **absent, **other, car__state__x=x), BUSES, SCENE)
    assert found["mu_f_max"] == 0.9
    assert found["gap_obstacle"] == 0
    assert found["gap_edge"] == compute(rows(), BUSES, SCENE)["gap_edge"]


def test_rows_that_are_no_numbers_do_not_count():
    broken = compute(rows(car__state__x=[0, 0, 0, 0, np.nan]), BUSES, SCENE)
    assert broken == compute(rows(car__state__x=[0.0] * 5).iloc[:-1], BUSES, SCENE)
    assert compute(rows(car__state__x=[np.nan] * 5), BUSES, SCENE) == {}
