"""What an FMU computes: initialization, steps, state, and numbers known from elsewhere."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from components import BLOCKS
from components.interfaces.block import Sampled
from components.interfaces.record import pack, unpack
from fmus.export.fmi_variables import fmi_variables_of
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from tests.fmus.fmu_driver import FmuDriver

Drive = Callable[..., FmuDriver]
VERSIONS = pytest.mark.parametrize("version", WRITTEN_VERSIONS)
EVERY = pytest.mark.parametrize(
    ("name", "version"), [(n, v) for n in BLOCKS if BLOCKS[n].native for v in WRITTEN_VERSIONS]
)
STATES = ("x", "y", "psi", "v_x", "v_y", "r")
H = 0.1


def profile(k: int) -> tuple[float, float]:
    """Steering and torque in macro step k: a swerve, then braking."""
    return 0.03 * np.sin(0.5 * k), 120.0 if k < 25 else -150.0


def bicycle_equations(_t: float, s: NDArray[np.float64], steering: float, torque: float) -> list[float]:
    """Equations (1)-(3) of the paper once more, written from the paper and not from our block."""
    mass, inertia, front, rear, stiffness, wheel = 2000.0, 1300.0, 1.2, 1.05, 12000.0, 0.3
    _, _, yaw, forward, left, rate = s
    slip_front = (left + front * rate) / forward - steering
    slip_rear = (left - rear * rate) / forward
    force_front, force_rear = -stiffness * slip_front, -stiffness * slip_rear
    return [
        forward * np.cos(yaw) - left * np.sin(yaw),
        forward * np.sin(yaw) + left * np.cos(yaw),
        rate,
        (mass * rate * left + 2 * torque / wheel - 2 * force_front * np.sin(steering)) / mass,
        (-mass * rate * forward + 2 * force_rear + 2 * force_front * np.cos(steering)) / mass,
        2 * (front * force_front - rear * force_rear) / inertia,
    ]


@VERSIONS
def test_bicycle_follows_its_differential_equations(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    state = np.array([0.0, 0.0, 0.0, 10.0, 0.0, 0.0])
    for k in range(50):
        steering, torque = profile(k)
        driver.set("actuation.delta_f", steering)
        driver.set("actuation.T_r", torque)
        driver.step(k * H, H)
        exact = solve_ivp(
            bicycle_equations, (0, H), state, method="DOP853", rtol=1e-10, atol=1e-12, args=(steering, torque)
        )
        state = exact.y[:, -1]
    found = [driver.get(f"state.{name}")[0] for name in STATES]
    assert found == pytest.approx(state, abs=1e-6, rel=0)


@VERSIONS
def test_ramp_traffic_follows_the_analytic_ramp(drive: Drive, start_of: Callable[[str], Any], version: Version) -> None:
    start = {name: np.asarray(value, dtype=float) for name, value in start_of("ramp_traffic").items()}
    driver = drive("ramp_traffic", version)
    driver.start()
    for k in range(60):
        driver.step(k * H, H)
    t = 60 * H
    for i in range(3):
        v_0, v_1, a = start["v_start"][i], start["v_final"][i], start["a"][i]
        t_ramp = min(t, abs(v_1 - v_0) / a)
        signed = a * np.sign(v_1 - v_0)
        v = v_0 + signed * t_ramp
        s = v_0 * t_ramp + signed * t_ramp**2 / 2 + v * (t - t_ramp)
        heading = start["psi_start"][i]
        assert driver.get("obstacles.v")[i] == pytest.approx(v, abs=1e-12)
        assert driver.get("obstacles.x")[i] == pytest.approx(start["x_start"][i] + s * np.cos(heading), abs=1e-9)
        assert driver.get("obstacles.y")[i] == pytest.approx(start["y_start"][i] + s * np.sin(heading), abs=1e-9)
    assert driver.get("obstacles.valid").tolist() == [1, 1, 1, 0, 0, 0, 0, 0]
    assert driver.get("obstacles.id").tolist() == [1, 2, 3, 4, 5, 6, 7, 8]


@EVERY
def test_starts_as_its_description_says(
    drive: Drive, start_of: Callable[[str], Any], name: str, version: Version
) -> None:
    driver = drive(name, version)
    driver.enter()
    for parameter, value in start_of(name).items():
        assert driver.get(parameter) == pytest.approx(np.ravel(np.asarray(value, dtype=float)), rel=0, abs=0)


@pytest.mark.parametrize("name", [n for n in BLOCKS if BLOCKS[n].native and not BLOCKS[n].staged])
@VERSIONS
def test_first_outputs_are_those_of_the_block(
    drive: Drive, start_of: Callable[[str], Any], name: str, version: Version
) -> None:
    kind: Any = BLOCKS[name]
    block = kind(**{n: np.asarray(v) if isinstance(v, list) else v for n, v in start_of(name).items()})
    driver = drive(name, version)
    driver.enter()
    column = np.concatenate(
        [np.atleast_1d(np.asarray(v, dtype=float)).ravel() for v in start_of(name).values()] or [[]]
    )
    inputs = fmi_variables_of(kind, sampled=issubclass(kind, Sampled), start=column).inputs
    zero = unpack(kind.input_type, np.array([s for v in inputs for s in v.start]), kind.dimensions())
    expected = pack(block.output(block.start(), zero))
    assert driver.outputs() == pytest.approx(np.asarray(expected, dtype=float), abs=1e-12)


@VERSIONS
def test_parameters_set_in_initialization_mode_change_the_start_state(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.enter()
    assert driver.get("state.v_x") == [10.0]
    driver.set("v_x_start", 12.0)
    assert driver.get("state.v_x") == [12.0]
    driver.fmu.exitInitializationMode()
    assert driver.get("state.v_x") == [12.0]


@VERSIONS
def test_outputs_read_after_a_set_show_the_new_inputs(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    driver.step(0.0, H)
    driver.set("actuation.delta_f", 0.01)
    assert driver.get("tyre.alpha_f") == pytest.approx([-0.01])
    assert driver.get("tyre.F_cf") == pytest.approx([120.0])
    assert driver.get("state.x") == pytest.approx([1.0])


@VERSIONS
def test_outputs_of_a_sampled_block_hold_until_the_next_step(drive: Drive, version: Version) -> None:
    driver = drive("mpc", version)
    driver.start()
    ego(driver, 10.0)
    driver.step(0.0, H)
    held = driver.outputs()
    ego(driver, 14.0)
    assert driver.outputs().tobytes() == held.tobytes()
    driver.step(H, H)
    assert driver.outputs().tobytes() != held.tobytes()


def ego(driver: FmuDriver, speed: float) -> None:
    """A vehicle in its lane, and an obstacle 30 m ahead."""
    driver.set("ego.v_x", speed)
    driver.set("obstacles.valid", [1] + [0] * 7)
    driver.set("obstacles.x", [30.0] + [0.0] * 7)
    driver.set("obstacles.length", [4.6] + [0.0] * 7)
    driver.set("obstacles.width", [1.8] + [0.0] * 7)


@VERSIONS
def test_a_long_step_is_divided_and_a_short_one_is_not(drive: Drive, version: Version) -> None:
    """0.1 s in one go and in ten steps of the longest internal step are the same ten Runge-Kutta steps."""
    whole, parts = drive("bicycle", version), drive("bicycle", version)
    for driver in (whole, parts):
        driver.start()
        driver.set("actuation.delta_f", 0.02)
    whole.step(0.0, 0.1)
    for k in range(10):
        parts.step(k * 0.01, 0.01)
    assert whole.outputs() == pytest.approx(parts.outputs(), rel=1e-14, abs=1e-14)


def run(driver: FmuDriver, ticks: range) -> list[bytes]:
    """Outputs tick by tick, with inputs that change all the time."""
    rows: list[bytes] = []
    for k in ticks:
        steering, torque = profile(k)
        if driver.description.modelName == "bicycle":
            driver.set("actuation.delta_f", steering)
            driver.set("actuation.T_r", torque)
        else:
            ego(driver, 10.0 + 0.1 * k)
        driver.step(k * H, H)
        rows.append(driver.outputs().tobytes())
    return rows


@pytest.mark.parametrize("name", ["bicycle", "mpc"])
@VERSIONS
def test_restored_in_mid_run_it_continues_bit_by_bit(drive: Drive, name: str, version: Version) -> None:
    driver = drive(name, version)
    driver.start()
    run(driver, range(7))
    state = driver.take()
    before = driver.outputs().tobytes()
    first = run(driver, range(7, 15))
    driver.restore(state)
    assert driver.outputs().tobytes() == before
    assert run(driver, range(7, 15)) == first
    driver.release(state)


@pytest.mark.parametrize("name", ["bicycle", "mpc"])
@VERSIONS
def test_serialized_into_another_instance_it_continues_bit_by_bit(drive: Drive, name: str, version: Version) -> None:
    driver, other = drive(name, version), drive(name, version)
    driver.start()
    run(driver, range(7))
    state = driver.take()
    data = driver.serialize(state)
    driver.release(state)
    first = run(driver, range(7, 15))
    state = other.deserialize(data)
    other.restore(state)
    other.release(state)
    assert run(other, range(7, 15)) == first


@VERSIONS
def test_a_state_taken_before_the_first_read_is_as_lazy_as_the_instance(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    driver.set("actuation.delta_f", 0.01)
    state = driver.take()
    expected = driver.outputs().tobytes()
    driver.set("actuation.delta_f", 0.05)
    driver.restore(state)
    driver.release(state)
    assert driver.outputs().tobytes() == expected


@VERSIONS
def test_reset_begins_anew(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start({"v_x_start": 14.0})
    run(driver, range(5))
    driver.fmu.reset()
    driver.start()
    again = run(driver, range(5))
    fresh = drive("bicycle", version)
    fresh.start()
    assert run(fresh, range(5)) == again


@pytest.mark.parametrize("name", ["bicycle", "mpc"])
@VERSIONS
def test_two_instances_in_two_threads_equal_two_in_sequence(drive: Drive, name: str, version: Version) -> None:
    drivers = [drive(name, version) for _ in range(4)]
    for driver in drivers:
        driver.start()
    one_by_one = [run(driver, range(30)) for driver in drivers[:2]]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda driver: run(driver, range(30)), drivers[2:]))
    assert together == one_by_one


def test_both_versions_of_fmi_give_the_same_numbers(drive: Drive) -> None:
    rows = []
    for version in WRITTEN_VERSIONS:
        driver = drive("bicycle", version)
        driver.start()
        rows.append(run(driver, range(20)))
    assert rows[0] == rows[1]


def test_time_is_a_variable_of_fmi3(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI3)
    driver.enter(start_time=2.0)
    driver.fmu.exitInitializationMode()
    driver.step(2.0, 0.5)
    assert driver.get("time") == [2.5]


@VERSIONS
def test_a_tunable_parameter_acts_from_the_next_step_on(drive: Drive, version: Version) -> None:
    driver, plain = drive("bicycle", version), drive("bicycle", version)
    for d in (driver, plain):
        d.start()
        d.set("actuation.T_r", 100.0)
    driver.set("m", 1000.0)
    assert driver.get("motion.a_x") == pytest.approx(2 * plain.get("motion.a_x"))
    driver.step(0.0, H)
    plain.step(0.0, H)
    assert driver.get("state.v_x") - 10 == pytest.approx(2 * (plain.get("state.v_x") - 10))


@VERSIONS
def test_the_rounding_of_a_masters_clock_does_not_reach_the_state(drive: Drive, version: Version) -> None:
    """libcosim takes the step as the difference of two times in nanoseconds: 0.1 s, give or take the last digits."""
    states: list[list[float]] = []
    for noisy in (False, True):
        driver = drive("bicycle", version)
        driver.start()
        driver.set("actuation.delta_f", 0.03)
        for k in range(50):
            step = (k + 1) * 1e8 / 1e9 - k * 1e8 / 1e9 if noisy else H
            driver.step(k * H, step)
        states.append([driver.get(f"state.{name}").item() for name in STATES])
    assert states[0] == states[1]
