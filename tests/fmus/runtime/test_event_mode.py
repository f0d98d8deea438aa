"""A controller FMU of FMI 3.0 with and without event mode: what it computes, and when."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from fmu_manipulation_toolbox.container import FMUContainer
from lxml import etree
from numpy.typing import NDArray

from components import BLOCKS
from components.interfaces.block import Sampled
from components.interfaces.record import Variable
from fmus.export.documentation import documentation
from fmus.export.fmi_variables import fmi_variables_of
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate
from tests.fmus.fmu_driver import FmuDriver

Built = Mapping[tuple[str, Version], Path]
Drive = Callable[..., FmuDriver]
H: Final = 0.1
N: Final = 100
FMI3: Final = Version.FMI3
SAMPLED: Final = [n for n, b in BLOCKS.items() if b.native and issubclass(b, Sampled)]


class Run(NamedTuple):
    """A run of the paper's scenario with in-process blocks: what the controller got and gave, tick by tick."""

    parameters: Mapping[str, Any]
    inputs: Mapping[str, NDArray[np.float64]]
    outputs: NDArray[np.float64]


@pytest.fixture(scope="module")
def real() -> Run:
    made = prepare("static", Options(mode="blocks"))
    frame = simulate(made.system, h=made.h, until=made.until)
    controller = made.system.units["controller"]
    sources = {f"{c.unit}.{c.input}": f"{c.source}.{c.output}" for c in made.system.connections}

    def columns(path: str, v: Variable) -> NDArray[np.float64]:
        return frame[list(Variable(path, v.quantity).elements)].to_numpy(float)

    inputs = {v.name: columns(sources[f"controller.{v.name}"], v) for v in controller.interface.inputs}
    outputs = [columns(f"controller.{v.name}", v) for v in controller.interface.outputs]
    return Run(controller.parameters, inputs, np.concatenate(outputs, axis=1))


def set_inputs(driver: FmuDriver, run: Run, k: int) -> None:
    for name, rows in run.inputs.items():
        driver.set(name, rows[k])


def tick_by_tick(driver: FmuDriver, run: Run, ticks: range) -> NDArray[np.float64]:
    """As an importer with event mode does it: from Event Mode at the first tick to Event Mode after the last."""
    rows: list[NDArray[np.float64]] = []
    for k in ticks:
        driver.tick()
        set_inputs(driver, run, k)
        rows.append(driver.outputs())
        assert driver.fmu.updateDiscreteStates() == (False, False, False, False, False, 0.0)
        driver.fmu.enterStepMode()
        assert driver.fmu.doStep(k * H, H) == (False, False, False, k * H + H)
        driver.fmu.enterEventMode()
    return np.array(rows)


def step_by_step(driver: FmuDriver, run: Run, ticks: range) -> NDArray[np.float64]:
    """As an importer without event mode does it."""
    rows: list[NDArray[np.float64]] = []
    for k in ticks:
        set_inputs(driver, run, k)
        driver.step(k * H, H)
        rows.append(driver.outputs())
    return np.array(rows)


@pytest.fixture
def ticking(drive: Drive) -> FmuDriver:
    """The controller in Event Mode at the start."""
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start()
    return driver


# --- what is computed, and when ---


def test_tick_by_tick_it_equals_the_block_in_a_real_run(drive: Drive, real: Run) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start(real.parameters)
    found = tick_by_tick(driver, real, range(N))
    np.testing.assert_allclose(found, real.outputs[:N], rtol=0, atol=1e-9)
    assert driver.messages == []


@pytest.mark.parametrize("name", ["mpc", "coast"])
def test_with_and_without_event_mode_it_gives_the_same_bits_as_fmi2(drive: Drive, real: Run, name: str) -> None:
    drivers = [drive(name, FMI3, event_mode=True), drive(name, FMI3), drive(name, Version.FMI2)]
    for driver in drivers:
        driver.start(real.parameters if name == "mpc" else {})
    run = real if name == "mpc" else real._replace(inputs={n: v for n, v in real.inputs.items() if n == "ego.x"})
    ways = [tick_by_tick, step_by_step, step_by_step]
    found = [way(driver, run, range(N)).tobytes() for way, driver in zip(ways, drivers, strict=True)]
    assert found[0] == found[1] == found[2]


def test_a_tick_whose_outputs_nobody_reads_counts_like_any_other(drive: Drive, real: Run) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start(real.parameters)
    for k in range(10):
        driver.tick()
        set_inputs(driver, real, k)
        driver.fmu.updateDiscreteStates()
        driver.fmu.enterStepMode()
        driver.step(k * H, H)
        driver.fmu.enterEventMode()
    found = tick_by_tick(driver, real, range(10, 20))
    np.testing.assert_allclose(found, real.outputs[10:20], rtol=0, atol=1e-9)


def test_inputs_set_before_the_clock_or_twice_in_a_tick_count_like_any_other(drive: Drive, real: Run) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start(real.parameters)
    tick_by_tick(driver, real, range(5))
    set_inputs(driver, real, 50)
    driver.tick()
    assert driver.outputs().tobytes() != real.outputs[5].tobytes()
    set_inputs(driver, real, 5)
    found = driver.outputs()
    np.testing.assert_allclose(found, real.outputs[5], rtol=0, atol=1e-9)
    driver.fmu.updateDiscreteStates()
    assert driver.outputs().tobytes() == found.tobytes()


def test_outputs_hold_from_one_tick_to_the_next(drive: Drive, real: Run) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start(real.parameters)
    first = tick_by_tick(driver, real, range(1))[0].tobytes()
    set_inputs(driver, real, 50)
    assert driver.outputs().tobytes() == first
    assert driver.fmu.updateDiscreteStates()[0] is False
    driver.fmu.enterStepMode()
    assert driver.outputs().tobytes() == first
    driver.step(H, 0.02)
    assert driver.outputs().tobytes() == first
    assert driver.get("time") == [H + 0.02]


def test_the_clock_is_active_during_its_tick_only(ticking: FmuDriver) -> None:
    reference = [ticking.clock]
    assert ticking.fmu.getClock(reference) == [False]
    ticking.tick(active=False)
    ticking.tick()
    ticking.tick()
    assert ticking.fmu.getClock(reference) == [True]
    ticking.fmu.updateDiscreteStates()
    assert ticking.fmu.getClock(reference) == [False]


@pytest.mark.parametrize("within_the_tick", [False, True])
def test_the_fmu_state_has_the_tick_and_the_sample_read_in_it(
    drive: Drive, real: Run, *, within_the_tick: bool
) -> None:
    driver, other = (drive("mpc", FMI3, event_mode=True) for _ in range(2))
    driver.start(real.parameters)
    tick_by_tick(driver, real, range(7))
    if within_the_tick:
        driver.tick()
        set_inputs(driver, real, 7)
        driver.outputs()
    state = driver.take()
    data = driver.serialize(state)
    first = tick_by_tick(driver, real, range(7, 15)).tobytes()
    driver.restore(state)
    assert driver.serialize(state) == data
    assert tick_by_tick(driver, real, range(7, 15)).tobytes() == first
    driver.release(state)
    state = other.deserialize(data)
    other.restore(state)
    assert other.serialize(state) == data
    other.release(state)
    assert other.fmu.getClock([other.clock]) == [within_the_tick]
    if within_the_tick:
        other.fmu.updateDiscreteStates()  # without another read: the state follows from the sample in the FMU state
        other.fmu.enterStepMode()
        other.step(7 * H, H)
        other.fmu.enterEventMode()
    begin = 8 if within_the_tick else 7
    row = len(first) // 8
    assert tick_by_tick(other, real, range(begin, 15)).tobytes() == first[(begin - 7) * row :]


def test_reset_forgets_the_clock(ticking: FmuDriver) -> None:
    set_up = [ticking.take()]
    ticking.tick()
    ticking.fmu.reset()
    ticking.enter()
    ticking.set_interval(0.05)
    ticking.fmu.reset()
    ticking.start()
    assert ticking.interval()[0] == H
    set_up.append(ticking.take())
    assert ticking.serialize(set_up[0]) == ticking.serialize(set_up[1])
    for state in set_up:
        ticking.release(state)


def test_the_importer_may_set_the_interval(drive: Drive) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.enter()
    assert driver.interval() == (H, fmi3.fmi3IntervalUnchanged)
    driver.set_interval(0.05)
    assert driver.interval() == (0.05, fmi3.fmi3IntervalUnchanged)
    shift = (fmi3.fmi3Float64 * 1)(7.0)
    driver.fmu.getShiftDecimal((fmi3.fmi3ValueReference * 1)(driver.clock), shift)
    assert shift[0] == 0.0
    driver.fmu.exitInitializationMode()
    assert driver.interval() == (0.05, fmi3.fmi3IntervalUnchanged)


def test_an_importer_that_uses_event_mode_but_not_the_clock_gets_a_sample_with_every_step(
    drive: Drive, real: Run
) -> None:
    driver, plain = drive("mpc", FMI3, event_mode=True), drive("mpc", FMI3)
    for d in (driver, plain):
        d.start(real.parameters)
    driver.fmu.updateDiscreteStates()
    driver.fmu.enterStepMode()
    expected = step_by_step(plain, real, range(10))
    assert step_by_step(driver, real, range(10)).tobytes() == expected.tobytes()
    assert [text.partition(": ")[2] for text in driver.messages] == [
        "found event mode in use and no tick of the clock at time 0; valid: one at the start; "
        "the model acts with every step instead"
    ]


def simulated(path: Path, **options: Any) -> NDArray[np.float64]:
    """Steering and torque over half a second by FMPy."""
    names = ["actuation.delta_f", "actuation.T_r"]
    rows = fmpy.simulate_fmu(str(path), stop_time=5 * H, step_size=H, output_interval=H, output=names, **options)
    return np.array([rows[name] for name in names])


def test_in_fmpy_it_gives_the_same_with_and_without_event_mode(built: Built) -> None:
    path, values = built["mpc", FMI3], {"ego.v_x": 10.0, "ego.y": 0.5}
    plain = simulated(path, start_values=values)
    assert np.ptp(plain, axis=1).all()
    found = simulated(path, start_values=values, use_event_mode=True, logger=lambda *_: None)
    assert found.tobytes() == plain.tobytes()


def test_in_a_container_of_fmutool_which_uses_event_mode_it_gives_the_same(built: Built, tmp_path: Path) -> None:
    container = FMUContainer("container", built["mpc", FMI3].parent, fmi_version=3)
    for name in ("ego.v_x", "ego.y"):
        container.add_input(name, "mpc.fmu", name)
    for name in ("actuation.delta_f", "actuation.T_r"):
        container.add_output("mpc.fmu", name, name)
    container.make_fmu(tmp_path / "container.fmu", step_size=H)
    values = {"ego.v_x": 10.0, "ego.y": 0.5}
    found = simulated(tmp_path / "container.fmu", start_values=values, logger=lambda *_: None)
    assert found.tobytes() == simulated(built["mpc", FMI3], start_values=values).tobytes()


# --- what is described ---


@pytest.mark.parametrize("name", [n for n in BLOCKS if BLOCKS[n].native])
def test_sampled_blocks_have_a_fixed_periodic_clock_and_others_no_event_mode(built: Built, name: str) -> None:
    with zipfile.ZipFile(built[name, FMI3]) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    (co_simulation,) = root.iter("CoSimulation")
    assert co_simulation.get("hasEventMode") == ("true" if name in SAMPLED else "false")
    clocks = [dict(clock.attrib) for clock in root.iter("Clock")]
    for clock in clocks:
        del clock["valueReference"], clock["description"]
    fixed = {"causality": "input", "variability": "discrete", "intervalVariability": "fixed", "intervalDecimal": "0.1"}
    assert clocks == [{"name": "sample", **fixed}] * (name in SAMPLED)
    assert root.xpath("//@clocks") == []


def test_the_documentation_says_when_a_sampled_block_acts() -> None:
    page = {
        (n, v): documentation(fmi_variables_of(BLOCKS[n], sampled=n == "coast", start=np.zeros(100)), v).decode()
        for n in ("coast", "bicycle")
        for v in WRITTEN_VERSIONS
    }
    assert "its clock <code>sample</code>" in page["coast", FMI3]
    assert "then every 0.1 s" in page["coast", FMI3]
    assert "acts once in each <code>fmi2DoStep</code>" in page["coast", Version.FMI2]
    assert "clock" not in page["coast", Version.FMI2]
    assert "When it acts" not in page["bicycle", FMI3]
