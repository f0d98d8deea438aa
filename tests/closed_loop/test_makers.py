"""FMUs in the manner of each maker run here, and their numbers are those of FMPy's own simulation of the same files."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import warnings

import numpy as np
import pytest
from fmpy import simulate_fmu

from orchestrator import Fmu, Simulation, System
from tests.fmus.makers import MAKERS, description, maker_fmu

CO, ME = "CoSimulation", "ModelExchange"
STEPS = 100
WITH_ME = [name for name in MAKERS if b"<ModelExchange" in description(name)]
FINE = 1e-11
"""The relative tolerance with which both integrate."""


def torque(t):
    return np.sin(3 * t)


def grid(maker):
    return maker.start + maker.h * np.arange(STEPS + 1)


def inputs(maker, value):
    """The values of all inputs; elements of an array of FMI 2.0 are one value here."""
    if maker.torque == "u[1]":
        return {"m.u": [value, maker.held["u[2]"]]}
    return {f"m.{maker.torque}": value} | {f"m.{n}": v for n, v in maker.held.items()}


def ours(name, path, *, moving):
    """The columns of our run; the torque is held at 1, or changes at every communication point where it is `moving`."""
    maker = MAKERS[name]
    source = Fmu(path, maker.parameters, lenient=maker.lenient)
    held = inputs(maker, torque(maker.start) if moving else 1.0)
    times = {"h": maker.h, "start": maker.start, "until": maker.start + STEPS * maker.h}
    with Simulation(System({"m": source}, {}, held=held), tolerance=FINE, **times) as simulation:
        for tick in simulation:
            if moving:
                path, value = next(iter(inputs(maker, torque(tick.time)).items()))
                simulation.write(path, value)
        return simulation.columns()


def theirs(name, path, kind, columns, *, moving):
    """FMPy's run, as columns by our names."""
    maker = MAKERS[name]
    given = np.array([(t, torque(t) if moving else 1.0) for t in grid(maker)], [("time", float), (maker.torque, float)])
    outputs = [n[2:] for n in columns if n != "time"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rows = simulate_fmu(
            str(path),
            validate=False,
            start_time=maker.start,
            stop_time=maker.start + STEPS * maker.h,
            output_interval=maker.h,
            relative_tolerance=FINE,
            fmi_type=kind,
            start_values={**maker.parameters, **maker.held},
            input=given,
            output=outputs,
            record_events=False,
        )
    return {"time": rows["time"]} | {f"m.{n}": rows[n] for n in outputs}


def assert_equal(found, expected):
    assert len(found["time"]) == STEPS + 1
    for name, values in expected.items():
        assert np.asarray(found[name], float) == pytest.approx(np.asarray(values, float), abs=1e-9), name


@pytest.mark.parametrize("name", MAKERS)
def test_co_simulation_is_as_fmpys(name):
    found = ours(name, maker_fmu(name), moving=True)
    assert np.ptp(found[f"m.{MAKERS[name].angle}"]) > 0.01
    assert_equal(found, theirs(name, maker_fmu(name), CO, found, moving=True))


@pytest.mark.parametrize("name", WITH_ME)
def test_model_exchange_is_as_fmpys(name):
    path = maker_fmu(name, ME)
    found = ours(name, path, moving=False)
    assert_equal(found, theirs(name, path, ME, found, moving=False))
