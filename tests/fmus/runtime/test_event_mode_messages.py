"""What a controller FMU of FMI 3.0 says when event mode and its clock are used wrongly."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import pytest
from fmpy import fmi3

from fmus.toolchain.version import Version
from tests.fmus.fmu_driver import FmuDriver, refused

Built = Mapping[tuple[str, Version], Path]
Drive = Callable[..., FmuDriver]
H: Final = 0.1
FMI3: Final = Version.FMI3
UNKNOWN: Final = 4_000_000


@pytest.fixture
def ticking(drive: Drive) -> FmuDriver:
    """The controller in Event Mode at the start."""
    driver = drive("mpc", FMI3, event_mode=True)
    driver.start()
    return driver


def test_clock_outside_event_mode(ticking: FmuDriver) -> None:
    ticking.fmu.enterStepMode()
    refused(ticking, ticking.tick, "the instance is in step mode; valid: in event mode")


def test_clock_in_initialization_mode(drive: Drive) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.enter()
    refused(driver, driver.tick, "the instance is in initialization mode; valid: in event mode")


def test_event_mode_that_is_not_in_use(drive: Drive) -> None:
    driver = drive("mpc", FMI3)
    driver.start()
    text = "found event mode not in use; valid: with eventModeUsed at instantiation"
    for call in (driver.fmu.enterEventMode, driver.fmu.enterStepMode, driver.fmu.updateDiscreteStates):
        refused(driver, call, text)
    refused(driver, driver.tick, text)


def test_event_mode_of_a_model_without_one(built: Built, drive: Drive) -> None:
    driver = drive("bicycle", FMI3)
    for call in (driver.fmu.enterEventMode, driver.fmu.enterStepMode, driver.fmu.updateDiscreteStates):
        refused(driver, call, "not supported by this FMU")
    messages: list[str] = []
    with pytest.raises(Exception, match="instantiate"):
        FmuDriver(built["bicycle", FMI3], messages=messages, event_mode=True)
    assert messages[-1].partition(": ")[2] == (
        "found event mode in use; valid: without, as the modelDescription.xml says"
    )


def test_calls_that_belong_to_another_mode(ticking: FmuDriver) -> None:
    text = "the instance is in event mode; valid: in step mode, after initialization"
    refused(ticking, ticking.fmu.enterEventMode, text)
    refused(ticking, lambda: ticking.step(0.0, H), text)
    text = "the instance is in event mode; valid: in initialization mode, as the interval is fixed"
    refused(ticking, lambda: ticking.set_interval(0.2), text)
    ticking.fmu.enterStepMode()
    text = "the instance is in step mode; valid: in event mode"
    refused(ticking, ticking.fmu.updateDiscreteStates, text)
    refused(ticking, ticking.fmu.enterStepMode, text)
    text = "the instance is in step mode; valid: in initialization mode or event mode"
    refused(ticking, ticking.interval, text)


def test_a_tunable_parameter_out_of_its_range_in_event_mode(ticking: FmuDriver) -> None:
    (before,) = ticking.get("b_3")
    refused(ticking, lambda: ticking.set("b_3", -1.0), "parameter `b_3` is -1; valid: 0 <= finite number")
    assert ticking.get("b_3") == [before]


def test_step_mode_in_the_middle_of_a_tick(ticking: FmuDriver) -> None:
    ticking.tick()
    text = "found the clock still active; valid: after fmi3UpdateDiscreteStates, which ends its tick"
    refused(ticking, ticking.fmu.enterStepMode, text)


def test_a_tick_taken_back_and_a_second_one(ticking: FmuDriver) -> None:
    ticking.tick()
    ticking.set("ego.v_x", 10.0)
    text = "found `sample` deactivated in its tick; valid: active until fmi3UpdateDiscreteStates"
    refused(ticking, lambda: ticking.tick(active=False), text)
    ticking.fmu.updateDiscreteStates()
    refused(ticking, ticking.tick, "found a second tick of `sample` at time 0; valid: one")


@pytest.mark.parametrize(("value", "shown"), [(0.0, "0"), (-0.1, "-0.1"), (math.nan, "nan"), (math.inf, "inf")])
def test_interval_that_is_none(drive: Drive, value: float, shown: str) -> None:
    driver = drive("mpc", FMI3, event_mode=True)
    driver.enter()
    text = f"found the interval {shown} of `sample`; valid: a finite number above 0"
    refused(driver, lambda: driver.set_interval(value), text)


def test_variables_that_are_no_clock_and_a_clock_that_is_no_number(ticking: FmuDriver) -> None:
    unknown = f"found the value reference {UNKNOWN}; valid: those in the modelDescription.xml"
    refused(ticking, lambda: ticking.interval(UNKNOWN), unknown)
    refused(ticking, lambda: ticking.fmu.setClock([UNKNOWN], [True]), unknown)
    text = "found `time` of type Float64; valid: variables of the type this function is for"
    refused(ticking, lambda: ticking.interval(0), text)
    reference = ticking.clock
    text = "found `sample` of type Clock; valid: variables of the type this function is for"
    refused(ticking, lambda: ticking.fmu.getBoolean([reference]), text)


def test_the_clock_is_unknown_to_fmi2(drive: Drive) -> None:
    reference = drive("mpc", FMI3).clock
    driver = drive("mpc", Version.FMI2)
    driver.start()
    text = f"found the value reference {reference}; valid: those in the modelDescription.xml"
    refused(driver, lambda: driver.fmu.getReal([reference]), text)


def test_an_interval_as_a_fraction(ticking: FmuDriver) -> None:
    reference = (fmi3.fmi3ValueReference * 1)(ticking.clock)
    one = (fmi3.fmi3UInt64 * 1)(1)
    refused(ticking, lambda: ticking.fmu.setIntervalFraction(reference, one, one), "not supported by this FMU")


def test_a_state_of_an_instance_that_uses_event_mode_otherwise(drive: Drive) -> None:
    without, with_it = drive("coast", FMI3), drive("coast", FMI3, event_mode=True)
    for driver, other, found, valid in ((without, with_it, "with", "without"), (with_it, without, "without", "with")):
        state = other.take()
        text = f"found a state of an instance {found} event mode; valid: {valid}, as this instance"
        refused(driver, lambda driver=driver, state=state: driver.restore(state), text)
        other.release(state)


def test_a_sample_that_ends_in_no_number_because_of_an_input(drive: Drive) -> None:
    driver = drive("two_level_mp", FMI3, event_mode=True)
    driver.start()
    driver.tick()
    driver.set("ego.v_x", math.nan)
    text = "at time 0 `plan.x[1]` is nan, not a finite number; so is input `ego.v_x`: nan"
    refused(driver, driver.fmu.updateDiscreteStates, text)
    text = "the instance is in error (reset it, or restore an earlier state); valid: in event mode"
    refused(driver, driver.fmu.updateDiscreteStates, text)
