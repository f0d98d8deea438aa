"""FMUs in the manner of each maker run here, and their numbers are those of FMPy's own simulation of the same files."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import warnings

import numpy as np
import pytest
from fmpy import simulate_fmu

from fmus.reading.archive import InterfaceType
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from orchestrator import SILENT, Fmu, Options, RequestError, Simulation, System, load
from tests.fmus.makers import MAKERS, description, maker_fmu, version_of

CO, ME = InterfaceType.CO_SIMULATION, InterfaceType.MODEL_EXCHANGE
STEPS = 100
ME1 = [name for name in MAKERS if version_of(name) is Version.FMI1 and b"<Implementation" not in description(name)]
WITH_ME = [*ME1, *(name for name in MAKERS if b"<ModelExchange" in description(name))]
WITH_CO = [name for name in MAKERS if name not in ME1]
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


def ours(name, path, kind=CO, *, moving, algorithm="sequential"):
    """The columns of our run; the torque is held at 1, or changes at every communication point where it is `moving`."""
    maker = MAKERS[name]
    source = Fmu(path, maker.parameters, lenient=maker.lenient, interface_type=kind)
    held = inputs(maker, torque(maker.start) if moving else 1.0)
    times = {"h": maker.h, "start": maker.start, "until": maker.start + STEPS * maker.h}
    with Simulation(System({"m": source}, {}, held=held), tolerance=FINE, algorithm=algorithm, **times) as simulation:
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
            fmi_type=str(kind),
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


@pytest.mark.parametrize("name", WITH_CO)
def test_co_simulation_is_as_fmpys(name):
    found = ours(name, maker_fmu(name), moving=True)
    assert np.ptp(found[f"m.{MAKERS[name].angle}"]) > 1e-3
    assert_equal(found, theirs(name, maker_fmu(name, complete=True), CO, found, moving=True))


@pytest.mark.parametrize("name", WITH_ME)
def test_model_exchange_is_as_fmpys(name):
    path = maker_fmu(name)
    found = ours(name, path, ME, moving=False)
    assert_equal(found, theirs(name, path, ME, found, moving=False))


@pytest.mark.parametrize("name", WITH_CO)
@pytest.mark.parametrize("algorithm", ["jacobi", "clocked"])
def test_every_algorithm_gives_the_same(name, algorithm):
    found, expected = (ours(name, maker_fmu(name), moving=True, algorithm=a) for a in (algorithm, "sequential"))
    assert {n: v.tolist() for n, v in found.items()} == {n: v.tolist() for n, v in expected.items()}


def test_sources_with_a_function_prefix_are_as_the_library():
    found, expected = (ours("twentysim", maker_fmu("twentysim", sources=s), moving=True) for s in (True, False))
    assert {n: v.tolist() for n, v in found.items()} == {n: v.tolist() for n, v in expected.items()}


@pytest.mark.parametrize("name", ["simulink", "twentysim"])
def test_a_library_that_a_process_holds_once_is_used_twice_in_two(name):
    maker = MAKERS[name]
    units = {n: Fmu(maker_fmu(name), maker.parameters, isolated=patience) for n, patience in (("a", None), ("b", 30.0))}
    held = {f"{n}.{path[2:]}": value for n in units for path, value in inputs(maker, 1.0).items()}
    with Simulation(System(units, {}, held=held), h=maker.h, until=10 * maker.h) as simulation:
        simulation.run()
        rows = simulation.columns()
    assert rows[f"a.{maker.angle}"].tolist() == rows[f"b.{maker.angle}"].tolist()


EXPERIMENTS = {
    "dymola": (0.0, 2.0, None), "dymola3": (0.0, 2.0, 0.02), "openmodelica": (0.0, 1.0, 0.002),
    "simulink": (0.0, 2.0, 0.001), "twentysim": (0.0, 2.0, 0.01), "maplesim": (0.0, 1.5, None),
    "amesim": (0.0, 2.0, 0.01), "hopsan": (0.0, 2.0, None), "hopsan3": (0.0, 2.0, None), "jmodelica": (-0.5, 1.5, None),
    "dymola1": (0.0, 2.0, None), "simulationx1": (0.0, 1.0, None),
}  # fmt: skip


@pytest.mark.parametrize("name", MAKERS)
def test_the_experiment_of_the_file_is_used(name):
    options = Options(lenient=MAKERS[name].lenient)
    request = load(str(maker_fmu(name)), options, SILENT)
    start, until, h = EXPERIMENTS[name]
    assert (request.start, request.until) == (start, until)
    assert h is None or request.h == h


BROKEN = {
    "dymola3": "line 31: found Element 'VendorAnnotations': This element is not expected",
    "hopsan": "line 6: found The unit `s` of variable `timestep` is not defined",
    "hopsan3": "modelDescription.xml: found Exactly one independent variable must be defined",
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_breaks_a_rule_says_so_and_what_to_do(name):
    assert MAKERS[name].lenient
    with pytest.raises(RequestError) as error:
        open_fmu(maker_fmu(name))
    assert BROKEN[name] in str(error.value)
    assert str(error.value).endswith("Have the file corrected by its maker, or run it as it is with --lenient.")
