"""CVODE around a model in Python, against its analytic solution; around real FMUs in `test_model_exchange`."""

from __future__ import annotations

import math

import pytest
from fmpy.fmi1 import FMICallException

from fmus.units.cvode_integrator import CvodeIntegrator, IntegrationError


class Decay:
    """``x' = -x`` with ``x(0) = 1`` and an event where x is 0.5."""

    n_states = 1
    n_indicators = 1

    def __init__(self):
        self.x, self.time, self.fails = 1.0, 0.0, False

    def get_states(self, x, n):
        assert n == 1
        x[0] = self.x

    def set_states(self, x, n):
        self.x = x[0]

    def get_derivatives(self, dx, n):
        if self.fails:
            raise FMICallException("fmi3GetContinuousStateDerivatives", 3)
        dx[0] = -self.x

    def get_indicators(self, z, n):
        z[0] = self.x - 0.5

    def get_nominals(self, x, n):
        x[0] = 1.0

    def set_time(self, t):
        self.time = t


@pytest.fixture
def model():
    return Decay()


@pytest.fixture
def integrator(model):
    made = CvodeIntegrator(model, 0.0, 1e-8)
    yield made
    made.close()
    made.close()


def advanced(integrator, target):
    """Internal steps up to `target`: their ends, and where a state event was."""
    ends, roots = [], []
    while not ends or ends[-1] < target:
        time, root = integrator.advance(target)
        ends.append(time)
        roots += [time] * root
    return ends, roots


def test_it_goes_in_steps_of_its_own_and_never_beyond_the_target(model, integrator):
    ends, roots = advanced(integrator, 0.5)
    assert len(ends) > 3
    assert ends == sorted(ends)
    assert ends[-1] == pytest.approx(0.5, rel=1e-15)
    assert roots == []
    assert (model.time, model.x) == (ends[-1], pytest.approx(math.exp(-0.5), rel=1e-6))


def test_a_state_event_ends_a_step(model, integrator):
    _, roots = advanced(integrator, 1.0)
    assert roots == [pytest.approx(math.log(2), rel=1e-6)]
    assert model.x == pytest.approx(math.exp(-1.0), rel=1e-6)


def test_an_fmu_that_fails_ends_the_integration_with_what_it_said(model, integrator):
    model.fails = True
    with pytest.raises(IntegrationError, match=r"CVODE cannot go on at 0 s: .*fmi3GetContinuousStateDerivatives"):
        integrator.advance(1.0)
