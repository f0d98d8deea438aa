"""Friction circles: shares along and across, against the forces they come from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.sockets import PlantInputs
from orchestrator.pictures import friction
from orchestrator.pictures.signals import Recorded, SignalColumns, signals
from orchestrator.scenario.catalogue import default_values
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.shown import shown

STATIC = prepare("static", Options(mode="blocks"))
BUSES = shown(STATIC.system)
VEHICLE = BLOCKS["bicycle"](**default_values(BLOCKS["bicycle"]))


def _columns(tyre, T_r):
    rows = {"time": np.zeros(1)} | {f"plant.tyre.{n}": np.array([getattr(tyre, n)]) for n in ("mu_f", "mu_r")}
    rows |= {f"plant.tyre.{n}": np.array([getattr(tyre, n)]) for n in ("F_cf", "F_cr", "alpha_f", "alpha_r")}
    rows |= {"controller.actuation.T_r": np.array([T_r]), "controller.actuation.delta_f": np.zeros(1)}
    return SignalColumns(rows, signals(STATIC.system))


@given(v_y=st.floats(-1, 1), r=st.floats(-1, 1), delta_f=st.floats(-0.3, 0.3), T_r=st.floats(-160, 200))
def test_shares_are_the_forces_over_the_limit(v_y, r, delta_f, T_r):
    state = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0, v_y=v_y, r=r)
    tyre = VEHICLE.output(state, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r))).tyre
    most = friction.plant_force_limits(STATIC.system, BUSES)
    assert most == pytest.approx([VEHICLE.mu * load for load in VEHICLE.loads()])
    found = friction.shares(_columns(tyre, T_r), BUSES, most)
    along = T_r / VEHICLE.R_w / most[1]
    expected = [[[0, tyre.F_cf / most[0]], [along, tyre.F_cr / most[1]]]]
    np.testing.assert_allclose(found, expected, atol=2e-3 * max(1, tyre.mu_r))
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), [[tyre.mu_f, tyre.mu_r]], atol=1e-6 * max(1, tyre.mu_f))


def test_a_plant_without_known_loads_shows_its_whole_share_across():
    assert friction.force_limits({"m": 1.0, "mu": 1.0}) is None
    tyre = VEHICLE.output(
        VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0, v_y=0.2, r=0.1),
        PlantInputs(actuation=Actuation(delta_f=0.1, T_r=50.0)),
    ).tyre
    found = friction.shares(_columns(tyre, 50.0), BUSES, None)
    signs = np.sign([tyre.F_cf, tyre.F_cr])
    np.testing.assert_allclose(found, [[[0, signs[0] * tyre.mu_f], [0, signs[1] * tyre.mu_r]]], atol=1e-12)


def test_braking_shows_also_where_the_torque_is_not_recorded():
    rows = {"time": np.zeros(2)} | {f"plant.tyre.{n}": np.full(2, 0.5) for n in ("mu_f", "mu_r")}
    rows |= {f"plant.tyre.{n}": np.zeros(2) for n in ("F_cf", "F_cr", "alpha_f", "alpha_r")}
    rows |= {f"plant.motion.{n}": np.array([2.0, -2.0]) for n in ("a_x", "a_y", "r_dot")}
    found = friction.shares(SignalColumns(rows, signals(STATIC.system)), BUSES, None)
    np.testing.assert_allclose(found[:, :, 0], [[0.5, 0.5], [-0.5, -0.5]])


def test_without_a_tyre_bus_there_is_no_circle():
    columns = SignalColumns({"time": np.zeros(1)}, signals(STATIC.system))
    assert friction.shares(columns, BUSES, None) is None
    assert list(friction.shapes(columns, BUSES, None, "")) == []
    idle = prepare("idle", Options(mode="blocks"))
    assert not friction.is_known(Recorded(idle.system), shown(idle.system))
    assert friction.is_known(Recorded(STATIC.system), BUSES)
    assert not friction.is_known(Recorded(STATIC.system, [["plant.tyre.mu_f", "plant.tyre.mu_r"]]), BUSES)
