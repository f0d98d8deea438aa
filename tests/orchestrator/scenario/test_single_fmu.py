"""One FMU, run by itself."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.stepping.whole_run import simulate


def loaded(path, **options):
    return load(str(path), Options(**options), SILENT)


@pytest.mark.parametrize("version", [2, 3])
def test_inputs_stay_at_what_is_set_and_the_rest_at_its_start(built_fmus, version):
    """Against FMPy's own simulation of the same FMU with the same input."""
    import fmpy  # noqa: PLC0415

    path = built_fmus / f"fmi{version}" / "bicycle.fmu"
    made = loaded(path, settings=["fmu.actuation.delta_f=0.02", "fmu.m=1500"], stop_time=2.0)
    frame = simulate(made.system, h=made.h, until=made.until)
    theirs = fmpy.simulate_fmu(
        str(path),
        stop_time=2.0,
        output_interval=0.1,
        start_values={"actuation.delta_f": 0.02, "m": 1500.0},
        output=["state.x", "state.y", "state.r"],
    )
    for name in ("state.x", "state.y", "state.r"):
        np.testing.assert_allclose(frame[f"fmu.{name}"], theirs[name], rtol=0, atol=1e-9)
    assert "nothing drives the inputs fmu.actuation.delta_f = 0.02, fmu.actuation.T_r = 0.0" in made.remarks
    assert made.sources == {"fmu.m": {"value": 1500, "unit": "kg", "source": "--set"}}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "stop time: found none in the FMU; valid: a number of seconds. Say how long with --stop-time."),
        ({"step": 0.0, "stop_time": 1.0}, "step: found 0 s; valid: a positive number of seconds"),
        (
            {"settings": ["plant.m=1"], "stop_time": 1.0},
            "--set plant: found an unknown unit; valid: fmu. Write --set fmu.NAME=VALUE.",
        ),
        (
            {"settings": ["fmu.actuation.T_r=[1, 2]"], "stop_time": 1.0},
            "fmu.actuation.T_r: found shape (2,); valid: shape ()",
        ),
    ],
)
def test_what_is_missing_or_wrong_is_told(built_fmus, options, message):
    with pytest.raises(RequestError) as error:
        loaded(built_fmus / "fmi2" / "bicycle.fmu", **options)
    assert str(error.value) == message
