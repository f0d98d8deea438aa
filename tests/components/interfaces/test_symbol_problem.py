"""Equations that do with signals what only numbers can do (`symbol_problem.py`, `fmus/lowering.py`)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest

from components import PLANT, Continuous, PlantInputs, PlantOutputs, VehicleState, block, quantity
from components.interfaces import maths
from components.interfaces.problem import RequestError
from fmus.lowering import lower


def vehicle(acceleration: Any, start: Any = lambda v: v) -> Any:
    """The class of a point mass whose acceleration is a function of its speed and its torque."""

    class Own(Continuous[PlantInputs, VehicleState, PlantOutputs]):
        """A point mass."""

        m: float = quantity("kg", "mass", min=1)

        def start(self) -> VehicleState:
            return VehicleState(x=start(0.0), y=0.0, psi=0.0, v_x=1.0, v_y=0.0, r=0.0)

        def derivative(self, x: VehicleState, u: PlantInputs) -> VehicleState:
            zero = 0.0 * x.x
            a = acceleration(x.v_x, u.actuation.T_r / self.m)
            return VehicleState(x=x.v_x, y=zero, psi=zero, v_x=a, v_y=zero, r=zero)

        def output(self, x: VehicleState, u: PlantInputs) -> PlantOutputs:
            return PlantOutputs(state=x)

    return block(PLANT)(Own)


def refusal(acceleration: Any, **given: Any) -> str:
    with pytest.raises(RequestError) as error:
        lower(vehicle(acceleration, **given))
    return str(error.value)


def braked(v: float, a: float) -> float:
    if v > 0:
        return a
    return 0.0


def waited(v: float, a: float) -> float:
    while a > v:
        a -= 1
    return a


@pytest.mark.parametrize(
    ("acceleration", "line"),
    [
        (braked, "if v > 0:"),
        (waited, "while a > v:"),
        (max, "max"),
        (lambda v, a: v and a, ""),
        (lambda v, a: not v, ""),
    ],
)
def test_a_decision_on_a_signal_says_what_to_write_instead_and_in_which_line(acceleration, line):
    text = refusal(acceleration)
    assert text.startswith(f"block `own`, {Path(__file__).name}, line ")
    assert "found a decision on a signal" in text
    assert "`maths.where(condition, a, b)`. `from components import maths`" in text
    if line.endswith(":"):
        assert f"(`{line}`)" in text
        number = int(text.partition("line ")[2].partition(":")[0])
        assert Path(__file__).read_text("utf-8").splitlines()[number - 1].strip() == line


@pytest.mark.parametrize(
    "acceleration",
    [
        lambda v, a: math.sin(v),
        lambda v, a: float(v),
        lambda v, a: int(a),
        lambda v, a: [1.0, 2.0][v],
        lambda v, a: range(v)[0],
    ],
)
def test_a_function_of_numbers_is_refused_instead_of_giving_nan(acceleration):
    text = refusal(acceleration)
    assert "found a function of numbers, given a signal (`" in text
    assert "valid: a function of `maths`, such as `maths.sin`" in text


def test_the_functions_of_maths_are_taken_and_casadi_is_left_as_it_was():
    before = casadi.SX.__float__
    lowered = lower(vehicle(lambda v, a: maths.where(v > 0, maths.sin(a), maths.fmax(v, a))))
    x = lowered.step([0, 0, 0, 1, 0, 0], [0, 0], [1], 0.1)
    assert float(x[0]) == pytest.approx(0.1)
    assert casadi.SX.__float__ is before
    assert math.isnan(float(casadi.SX.sym("v")))


def test_what_is_not_declared_is_refused():
    text = refusal(braked_not, start=lambda v: maths.vector([v, v]))
    assert text == "block `own`, VehicleState: x: found 2 values; valid: 1"
    with pytest.raises(RequestError, match=r"block `own`: found float from its equations; valid: VehicleState"):
        lower(type("Own", (vehicle(braked_not),), {"start": lambda _: 0.0}))


def braked_not(v: float, a: float) -> float:
    return 0.0 * v + a


def test_errors_of_another_kind_stay_what_they_are():
    with pytest.raises(ZeroDivisionError):
        lower(vehicle(lambda v, a: 1 / 0))


@pytest.mark.filterwarnings("error")
def test_functions_of_numpy_that_casadi_has_too_are_its_own_without_a_warning():
    mode = casadi.GlobalOptions.getNumpyMode()
    lowered = lower(vehicle(lambda v, a: np.sin(v) + np.clip(a, -1.0, 1.0) + np.where(a > 0, np.hypot(v, a), 0.0)))
    assert lowered is not None
    assert casadi.GlobalOptions.getNumpyMode() == mode
