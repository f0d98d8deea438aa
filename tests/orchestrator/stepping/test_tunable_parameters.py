"""Tunable parameters that are written while a system runs, with `orchestrator/stepping/writing.py`."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from orchestrator.mapping.mapped import mapped
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, library, pack, scalar
from tests.fmus.model_exchange_models import ball2, ball3
from tests.orchestrator.ssps import echo_library

WAYS = {
    "blocks": {"mode": "blocks"},
    "fmi2": {"mode": Version.FMI2},
    "fmi3": {"mode": Version.FMI3},
    "isolated": {"isolate": ["plant", "controller"]},
    "clocked": {"algorithm": "clocked"},
}


def driven(**options):
    replacements = {"controller": "stanley"}
    made = prepare("static", Options(stop_time=2.0, replacements=replacements, settings=["plant.y_start=1"], **options))
    with Simulation(made.system, h=made.h, until=made.until, algorithm=made.algorithm) as simulation:
        for tick in simulation:
            if tick.tick == 5:
                simulation.write("plant.C_alpha_f", 6000.0)
                simulation.write("controller.k", 2.5)
            if tick.tick == 12:
                simulation.release("plant.C_alpha_f")
        return simulation.frame()


def test_own_units_act_on_them_alike_however_they_run():
    frames = {name: driven(**options) for name, options in WAYS.items()}
    expected = frames["blocks"]
    for name, frame in frames.items():
        assert list(frame) == list(expected)
        np.testing.assert_allclose(frame.astype(float), expected.astype(float), rtol=0, atol=1e-9, err_msg=name)
    assert expected["plant.C_alpha_f"].tolist() == [12000.0] * 6 + [6000.0] * 7 + [12000.0] * 8
    assert expected["controller.k"].iloc[5:7].tolist() == [expected["controller.k"][0], 2.5]
    assert expected["controller.actuation.delta_f"].iloc[6] != pytest.approx(
        expected["controller.actuation.delta_f"].iloc[5], rel=0.2
    )


def theirs(path):
    """`k`, a tunable array `a` of the same lengths as FMI 2.0 has them, and the fixed `c` come out after a step."""
    tunable = {"variability": "tunable"}
    variables = [
        scalar("k", 1, "parameter", of_start="1", of_max="9", **tunable),
        scalar("a[1]", 2, "parameter", of_start="1", **tunable),
        scalar("a[2]", 3, "parameter", of_start="2", **tunable),
        scalar("c", 4, "parameter", variability="fixed", of_start="7"),
        scalar("n", 1, "parameter", "Integer", of_start="5", **tunable),
        *(scalar(f"y[{i}]", 100 + i, "output") for i in range(1, 5)),
    ]
    unknown = [f'<Unknown index="{i}" dependencies=""/>' for i in range(6, 10)]
    text = description2(variables, unknown, initial=unknown)
    return pack(path, Version.FMI2, text, echo_library(Version.FMI2))


@pytest.mark.parametrize("isolated", [None, 30.0])
def test_values_act_from_the_next_step_on(tmp_path, isolated):
    parameters = {"k": 1, "a": [1.0, 2.0], "c": 7.0, "n": 5}
    system = System({"fmu": Fmu(theirs(tmp_path / "a.fmu"), parameters, isolated=isolated)}, {})
    with Simulation(system, h=0.1, until=0.6) as simulation:
        simulation.write("fmu.n", 6)
        for tick in simulation:
            if tick.tick == 2:
                simulation.write("fmu.k", 3.5)
                simulation.write("fmu.a", [5.0, 6.0])
            if tick.tick == 4:
                simulation.release("fmu.a")
        frame = simulation.frame()
    assert frame["fmu.y[1]"].tolist() == [0, 1, 1, 3.5, 3.5, 3.5, 3.5]
    assert frame["fmu.y[3]"].tolist() == [0, 2, 2, 6, 6, 2, 2]
    assert frame["fmu.y[4]"].tolist() == [0, 7, 7, 7, 7, 7, 7]
    assert frame["fmu.k"].tolist() == [1, 1, 1, 3.5, 3.5, 3.5, 3.5]
    assert frame["fmu.a[2]"].tolist() == [2, 2, 2, 6, 6, 2, 2]
    assert frame["fmu.n"].tolist() == [6] * 7
    assert frame["fmu.n"].dtype == np.int32


def test_what_cannot_be_written_is_refused_with_what_can(tmp_path):
    system = System({"fmu": Fmu(theirs(tmp_path / "a.fmu"))}, {})
    with Simulation(system, h=0.1, until=0.6) as simulation:
        for call in (lambda: simulation.write("fmu.c", 1.0), lambda: simulation.release("fmu.c")):
            with pytest.raises(RequestError) as error:
                call()
            assert str(error.value) == (
                "fmu.c: found a parameter that is fixed while the system runs; valid: an input, or a tunable parameter"
                " of `fmu`: a, k, n. Set it before the run: --set fmu.c=VALUE."
            )
        with pytest.raises(RequestError, match=r"fmu.kk: found no such input; valid: nothing. Did you mean `fmu.k`"):
            simulation.write("fmu.kk", 1.0)
        with pytest.raises(RequestError, match=r"fmu.k: found 10; valid: finite number <= 9"):
            simulation.write("fmu.k", 10)


@pytest.mark.parametrize("version", [Version.FMI2, Version.FMI3], ids="fmi{}".format)
def test_model_exchange_takes_them_in_event_mode(tmp_path, version):
    """A ball that falls from 1 m, on which gravity ceases at 0.2 s."""
    made = library(tmp_path, version, f'#include "me{version}.c"', '-DMODEL="ball.h"')
    path = pack(tmp_path / "ball.fmu", version, ball2() if version is Version.FMI2 else ball3(), made)
    with Simulation(System({"ball": Fmu(path)}, {}), h=0.1, until=0.4) as simulation:
        for tick in simulation:
            if tick.tick == 2:
                simulation.write("ball.g", 0.0)
        frame = simulation.frame()
    np.testing.assert_allclose(frame["ball.v"], [0, -0.981, -1.962, -1.962, -1.962], atol=1e-9)
    np.testing.assert_allclose(np.diff(frame["ball.h"])[2:], -0.1962, atol=1e-9)


def test_a_mapped_fmu_takes_them_under_its_own_names(built_fmus):
    made = prepare("static", Options(mode="blocks", stop_time=0.5))
    plant = made.system.units["plant"]
    fmu = mapped("plant", made.system.sockets["plant"], Fmu(built_fmus / "fmi2" / "bicycle.fmu", plant.parameters))
    with Simulation(System({**made.system.units, "plant": fmu}, made.system.wiring), h=0.1, until=0.5) as simulation:
        simulation.step()
        simulation.write("plant.m", 1000.0)
        simulation.run()
        assert simulation.frame()["plant.m"].tolist() == [2000.0] + [1000.0] * 5


def test_a_unit_that_refuses_a_value_ends_the_run(tmp_path):
    refusing = library(
        tmp_path,
        Version.FMI2,
        "int instance; void *fmi2Instantiate() { return &instance; }"
        "int fmi2SetReal(void *c, const unsigned *vr, unsigned long n, const double *v) { return v[0] > 2 ? 3 : 0; }",
    )
    path = pack(
        tmp_path / "a.fmu",
        Version.FMI2,
        description2([scalar("k", 1, "parameter", variability="tunable", of_start="1")]),
        refusing,
    )
    with Simulation(System({"fmu": Fmu(path)}, {}), h=0.1, until=0.6) as simulation:
        simulation.step()
        with pytest.raises(SimulationError) as error:
            simulation.write("fmu.k", 3.0)
        assert str(error.value) == "tick 0 (t = 0 s), unit `fmu`: setting the parameter k to 3.0 (status 3)"
