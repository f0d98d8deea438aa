"""What an FMU says when it is used wrongly: the call, what was found, what would be valid."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import pytest
from fmpy.fmi1 import FMICallException

from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from tests.fmus.fmu_driver import FmuDriver, refused

Built = Mapping[tuple[str, Version], Path]
Drive = Callable[..., FmuDriver]
VERSIONS = pytest.mark.parametrize("version", WRITTEN_VERSIONS)
UNKNOWN: Final = 4_000_000


def float_suffix(driver: FmuDriver) -> str:
    return "Real" if driver.version is Version.FMI2 else "Float64"


@VERSIONS
def test_wrong_token(built: Built, drive: Drive, version: Version) -> None:
    messages: list[str] = []
    with pytest.raises(Exception, match="instantiate"):
        FmuDriver(built["bicycle", version], "of 100 % another", messages)
    token = drive("bicycle", version).description.guid
    shown = "of 100 %% another" if version is Version.FMI2 else "of 100 % another"  # FMI 2.0 formats once more
    text = f'found the token "{shown}"; valid: "{token}", as in the modelDescription.xml of this binary'
    assert messages[-1].partition(": ")[2] == text


@VERSIONS
def test_step_before_initialization(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    text = "the instance is instantiated; valid: in step mode, after initialization"
    refused(driver, lambda: driver.step(0.0, 0.1), text)
    refused(driver, driver.fmu.terminate, text)


@VERSIONS
def test_step_in_initialization_mode(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.enter()
    text = "the instance is in initialization mode; valid: in step mode, after initialization"
    refused(driver, lambda: driver.step(0.0, 0.1), text)


@VERSIONS
def test_modes_out_of_order(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    text = "the instance is instantiated; valid: in initialization mode"
    refused(driver, driver.fmu.exitInitializationMode, text)
    driver.start()
    text = "the instance is in step mode; valid: once, after instantiation or reset"
    refused(driver, driver.fmu.enterInitializationMode, text)
    if version is Version.FMI2:
        refused(driver, driver.fmu.setupExperiment, "found after initialization began; valid: before it")
    driver.fmu.terminate()
    text = "the instance is terminated; valid: in step mode, after initialization"
    refused(driver, lambda: driver.step(0.0, 0.1), text)
    text = "found `m` after the end of the simulation; valid: before, or after a reset"
    refused(driver, lambda: driver.set("m", 1000.0), text)


@VERSIONS
def test_start_time_that_is_no_number(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    refused(driver, lambda: driver.enter(math.nan), "found the start time nan; valid: a finite number")


@VERSIONS
def test_read_before_initialization_mode(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    text = "found `m` before initialization mode; valid: from initialization mode on"
    refused(driver, lambda: driver.get("m"), text)


@VERSIONS
def test_unknown_value_reference(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    text = f"found the value reference {UNKNOWN}; valid: those in the modelDescription.xml"
    refused(driver, lambda: getattr(driver.fmu, f"get{float_suffix(driver)}")([UNKNOWN]), text)
    refused(driver, lambda: getattr(driver.fmu, f"set{float_suffix(driver)}")([UNKNOWN], [0.0]), text)


def test_reference_of_an_inner_element_is_unknown_to_fmi3(drive: Drive) -> None:
    driver = drive("ramp_traffic", Version.FMI3)
    driver.start()
    inner = driver.references("obstacles.x")[0][0] + 1
    text = f"found the value reference {inner}; valid: those in the modelDescription.xml"
    refused(driver, lambda: driver.fmu.getFloat64([inner]), text)


def test_time_is_unknown_to_fmi2(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI2)
    driver.start()
    text = "found the value reference 0; valid: those in the modelDescription.xml"
    refused(driver, lambda: driver.fmu.getReal([0]), text)


@VERSIONS
def test_wrong_type(drive: Drive, version: Version) -> None:
    driver = drive("ramp_traffic", version)
    driver.start()
    references, _, _ = driver.references("obstacles.id")
    text = "found `obstacles.id` of type Int32; valid: variables of the type this function is for"
    refused(driver, lambda: getattr(driver.fmu, f"get{float_suffix(driver)}")(references), text)
    text = "found `obstacles.id` of type Int32; valid: variables of the type this function is for"
    refused(driver, lambda: driver.fmu.getString(references), text)


@pytest.mark.parametrize("n", [7, 9])
def test_wrong_number_of_values(drive: Drive, n: int) -> None:
    driver = drive("ramp_traffic", Version.FMI3)
    driver.start()
    references, _, _ = driver.references("obstacles.x")
    text = f"found {n} values; valid: 8, one for each element"
    refused(driver, lambda: driver.fmu.getFloat64(references, nValues=n), text)


TUNABLE: Final = "valid: inputs and tunable parameters"
NOT_TO_BE_SET: Final = "which is not to be set; valid: parameters and inputs"
SETTINGS: Final = [
    pytest.param(name, text, version, id=f"{name}-{version}")
    for name, text, versions in (
        ("state.x", f"found `state.x`, {NOT_TO_BE_SET}", WRITTEN_VERSIONS),
        ("time", f"found `time`, {NOT_TO_BE_SET}", [Version.FMI3]),
        ("x_start", f"found fixed parameter `x_start` after initialization; {TUNABLE}", WRITTEN_VERSIONS),
    )
    for version in versions
]


@pytest.mark.parametrize(("name", "text", "version"), SETTINGS)
def test_setting_outputs_time_and_fixed_parameters(drive: Drive, name: str, text: str, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    refused(driver, lambda: driver.set(name, 1.0), text)


@VERSIONS
def test_parameters_out_of_range_are_all_named_at_the_end_of_initialization(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.enter()
    driver.set("m", 0.5)
    driver.set("mu", 3.0)
    driver.set("x_start", math.nan)
    with pytest.raises(FMICallException):
        driver.fmu.exitInitializationMode()
    assert [text.partition(": ")[2] for text in driver.messages] == [
        "parameter `m` is 0.5; valid: 1 <= finite number",
        "parameter `mu` is 3; valid: 0.01 <= finite number <= 2",
        "parameter `x_start` is nan; valid: finite number",
    ]
    driver.set("m", 1500.0)
    driver.set("mu", 1.0)
    driver.set("x_start", 0.0)
    driver.fmu.exitInitializationMode()


@VERSIONS
def test_element_of_a_parameter_out_of_range(drive: Drive, version: Version) -> None:
    driver = drive("ramp_traffic", version)
    driver.enter()
    driver.set("length", [4.0, -1.0, *[4.0] * 6])
    text = "parameter `length[2]` is -1; valid: 0 <= finite number"
    refused(driver, driver.fmu.exitInitializationMode, text)


@VERSIONS
def test_tunable_parameter_out_of_range_while_stepping_is_refused_and_keeps_its_value(
    drive: Drive, version: Version
) -> None:
    driver = drive("bicycle", version)
    driver.start()
    text = "parameter `mu` is 3; valid: 0.01 <= finite number <= 2"
    refused(driver, lambda: driver.set("mu", 3.0), text)
    assert driver.get("mu") == [0.5]
