"""The controller around the regulator; the regulator itself is in `test_lqr_tracking.py`."""

from __future__ import annotations

import pytest

from components.interfaces.record import pack
from components.interfaces.sockets import ControllerInputs


@pytest.fixture(scope="module")
def lqr(make):
    return make("lqr")


def test_the_gain_is_kept_in_the_state(lqr, vehicle, obstacles):
    start = lqr.start()
    assert pack(start.K).tolist() == pack(lqr.gain()).tolist()
    x, _ = lqr.sample(start, ControllerInputs(ego=vehicle(y=0.2), obstacles=obstacles()))
    assert pack(x.K).tolist() == pack(start.K).tolist()
