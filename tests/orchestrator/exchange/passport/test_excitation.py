"""What an FMU is given while it is measured."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.quantity import Type
from orchestrator.exchange.passport.excitation import amplitudes, course, own_step, usual_steps
from orchestrator.system.source import Fmu
from tests.orchestrator.exchange.passport.measured_fmus import lag


def archive(folder, **description):
    return Fmu(lag(folder, **description), lenient=True).archive


@pytest.mark.parametrize(
    ("u", "reach"),
    [
        ('unit="V" start="1"', 0.05),
        ('unit="V" start="20"', 1.0),
        ('unit="V" start="0" nominal="1000"', 50.0),
        ('unit="V" start="0" min="-10" max="10"', 1.0),
        ('unit="V" start="0" min="0"', 0.05),
    ],
)
def test_inputs_are_moved_by_their_range_their_nominal_value_or_their_size(tmp_path, u, reach):
    assert amplitudes(archive(tmp_path, u=u))[Type.FLOAT64].tolist() == pytest.approx([reach])


def test_a_course_is_the_same_every_time_and_within_the_range(tmp_path):
    fmu = archive(tmp_path, u='unit="V" start="1" min="0" max="1"')
    one, again, other = (course(fmu, 0.1, 50, seed).inputs[Type.FLOAT64] for seed in (1, 1, 2))
    assert one.tobytes() == again.tobytes() != other.tobytes()
    assert one.min() >= 0.95
    assert one.max() <= 1
    held = course(fmu, 0.1, 50, None).inputs[Type.FLOAT64]
    assert np.ptp(held) == 0


def test_other_inputs_keep_their_start_values(built_fmus):
    mpc = Fmu(built_fmus / "fmi3" / "mpc.fmu").archive
    inputs = course(mpc, 0.1, 5, 1).inputs
    assert not inputs[Type.BOOLEAN].any()
    assert not inputs[Type.INT32].any()


def test_the_step_is_that_of_the_fmu(tmp_path):
    assert own_step(archive(tmp_path, experiment='<DefaultExperiment stepSize="0.02"/>')) == 0.02
    assert own_step(archive(tmp_path, experiment='<DefaultExperiment stepSize="0"/>')) == 0.1
    assert own_step(archive(tmp_path, experiment="")) == 0.1


def test_an_fmu_is_not_driven_beyond_its_experiment(tmp_path):
    fmu = archive(tmp_path, experiment='<DefaultExperiment startTime="2" stopTime="4"/>')
    assert usual_steps(fmu, 0.1) == 20
    assert usual_steps(fmu, 0.01) == 100
    assert usual_steps(fmu, 10) == 1


def test_inputs_that_start_outside_their_range_do_not_lie_at_its_end(tmp_path):
    held = course(archive(tmp_path, u='unit="V" start="-1" min="0"'), 0.1, 5, None).inputs[Type.FLOAT64]
    assert held.ravel().tolist() == pytest.approx([0.05] * 5)
