"""What an FMU says about steps, states and functions that it cannot do, and about numbers that are none."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from ctypes import byref, c_char, c_char_p, c_size_t, c_void_p
from pathlib import Path
from typing import Any, final

import numpy as np
import pytest
from fmpy import fmi2, fmi3

from components.interfaces.block import Block, block
from components.interfaces.buses import VehicleState
from components.interfaces.maths import sqrt
from components.interfaces.progress import SILENT
from components.interfaces.quantity import quantity
from components.interfaces.sockets import PLANT, PlantInputs, PlantOutputs
from fmus.export.build import build_all
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from tests.fmus.fmu_driver import FmuDriver, refused

Built = Mapping[tuple[str, Version], Path]
Drive = Callable[..., FmuDriver]
VERSIONS = pytest.mark.parametrize("version", WRITTEN_VERSIONS)


@final
@block(PLANT)
class Awkward(Block[PlantInputs, VehicleState, PlantOutputs]):
    """Plant that starts at the root of its parameter, and takes steps of a nanosecond."""

    max_step = 1e-9

    a: float = quantity("m2", "number whose root is taken")

    def start(self) -> VehicleState:
        return VehicleState(x=sqrt(self.a), y=0.0, psi=0.0, v_x=0.0, v_y=0.0, r=0.0)

    def output(self, x: VehicleState, u: PlantInputs) -> PlantOutputs:
        return PlantOutputs(state=x)

    def step(self, x: VehicleState, u: PlantInputs, h: float) -> VehicleState:
        return x


@pytest.fixture(scope="session")
def awkward(tmp_path_factory: pytest.TempPathFactory) -> Built:
    requests = [(Awkward, version, {"a": 4.0}) for version in WRITTEN_VERSIONS]
    made = build_all(requests, tmp_path_factory.mktemp("awkward"), SILENT)
    return {("awkward", version): b.path for version, b in zip(WRITTEN_VERSIONS, made, strict=True)}


@VERSIONS
@pytest.mark.parametrize(("h", "shown"), [(0.0, "0"), (-0.1, "-0.1"), (math.nan, "nan"), (math.inf, "inf")])
def test_step_size_that_is_none(drive: Drive, version: Version, h: float, shown: str) -> None:
    driver = drive("bicycle", version)
    driver.start()
    text = f"found the communication step size {shown}; valid: a finite number above 0"
    refused(driver, lambda: driver.step(0.0, h), text)


@VERSIONS
def test_step_size_too_long_for_the_model(awkward: Built, version: Version) -> None:
    driver = FmuDriver(awkward["awkward", version])
    driver.start()
    text = "found the communication step size 2; valid: at most 1"
    refused(driver, lambda: driver.step(0.0, 2.0), text)
    driver.close()


@VERSIONS
def test_communication_point_elsewhere(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    driver.step(0.0, 0.1)
    text = "found the communication point 0.2; valid: 0.1, where the last step ended"
    refused(driver, lambda: driver.step(0.2, 0.1), text)


@VERSIONS
def test_start_state_that_is_no_number(awkward: Built, version: Version) -> None:
    driver = FmuDriver(awkward["awkward", version])
    driver.enter()
    driver.set("a", -1.0)
    refused(driver, driver.fmu.exitInitializationMode, "start state `x` is nan, not a finite number")
    driver.close()


BEYOND = {"v_y_start": 1e308, "r_start": 1e308}
"""A start whose slip is beyond all numbers."""


@VERSIONS
def test_step_that_ends_in_no_number(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start(BEYOND)
    refused(driver, lambda: driver.step(0.0, 0.1), "at time 0.1 `state.x` is nan, not a finite number")
    refused(
        driver,
        lambda: driver.step(0.1, 0.1),
        "the instance is in error (reset it, or restore an earlier state); valid: in step mode, after initialization",
    )


@VERSIONS
def test_step_that_ends_in_no_number_because_of_an_input(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start()
    driver.set("actuation.T_r", math.nan)
    text = "at time 0.1 `state.x` is nan, not a finite number; so is input `actuation.T_r`: nan"
    refused(driver, lambda: driver.step(0.0, 0.1), text)


@VERSIONS
def test_an_input_nobody_reads_may_be_no_number(drive: Drive, version: Version) -> None:
    driver = drive("ramp_traffic", version)
    driver.start()
    driver.set("ego.x", math.nan)
    driver.step(0.0, 0.1)
    assert driver.messages == []


@VERSIONS
def test_outputs_that_are_no_number_are_shown_with_a_warning(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    driver.start(BEYOND)
    assert np.isinf(driver.get("tyre.alpha_f")).all()
    texts = [text.partition(": ")[2] for text in driver.messages]
    assert texts == ["at time 0 `tyre.alpha_f` is inf, not a finite number"]


@VERSIONS
def test_state_of_another_model(drive: Drive, version: Version) -> None:
    driver, other = drive("bicycle", version), drive("stationary", version)
    state = other.take()
    data = other.serialize(state)
    other.release(state)
    text = (
        f"found a state of another model ({other.description.guid}, {len(data)} bytes); "
        f"valid: {driver.description.guid}, {len(own_state(driver))} bytes"
    )
    refused(driver, lambda: driver.deserialize(data), text)


@VERSIONS
def test_state_that_is_cut_off(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    data = own_state(driver)
    text = (
        f"found a state of another model ({driver.description.guid}, {len(data) - 1} bytes); "
        f"valid: {driver.description.guid}, {len(data)} bytes"
    )
    refused(driver, lambda: driver.deserialize(data[:-1]), text)
    text = f"found a state of another model (, 3 bytes); valid: {driver.description.guid}, {len(data)} bytes"
    refused(driver, lambda: driver.deserialize(data[:3]), text)


def own_state(driver: FmuDriver) -> bytes:
    state = driver.take()
    data = driver.serialize(state)
    driver.release(state)
    return data


@VERSIONS
def test_no_state_and_no_room(drive: Drive, version: Version) -> None:
    driver = drive("bicycle", version)
    text = "found no state of this model; valid: a state taken from this FMU"
    refused(driver, lambda: driver.restore(c_void_p()), text)
    n = len(own_state(driver))
    state = driver.take()
    room = (c_char * 8)()
    serialize: Any = driver.fmu.fmi2SerializeFMUstate if version is Version.FMI2 else driver.fmu.fmi3SerializeFMUState
    place = room if version is Version.FMI2 else (fmi3.fmi3Byte * 8)()
    text = f"found room for 8 bytes; valid: a state and {n} bytes"
    refused(driver, lambda: serialize(driver.fmu.component, state, place, 8), text)
    driver.release(state)


def test_functions_that_are_not_supported(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI2)
    text = "not supported by this FMU"
    refused(driver, driver.fmu.cancelStep, text)
    refused(driver, lambda: driver.fmu.getDirectionalDerivative([1], [2], [1.0]), text)
    driver = drive("bicycle", Version.FMI3)
    refused(driver, driver.fmu.enterEventMode, text)
    refused(driver, driver.fmu.enterConfigurationMode, text)


def test_last_successful_time_of_fmi2(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI2)
    driver.start()
    driver.step(0.0, 0.1)
    time = fmi2.fmi2Real()
    driver.fmu.fmi2GetRealStatus(driver.fmu.component, fmi2.fmi2LastSuccessfulTime, byref(time))
    assert time.value == 0.1


def test_other_kinds_of_simulation_and_event_mode_are_refused(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI3)
    token = str(driver.description.guid).encode()
    log = driver.fmu.logMessage
    none = (b"name", token, b"", False, False)
    with_events, without = (True, False), (False, False)
    assert not driver.fmu.fmi3InstantiateModelExchange(*none, None, log)
    assert driver.messages.pop().endswith(": found Model Exchange; valid: Co-Simulation")
    callbacks = [kind() for kind in (fmi3.fmi3ClockUpdateCallback, fmi3.fmi3LockPreemptionCallback)]
    unlock = fmi3.fmi3UnlockPreemptionCallback()
    assert not driver.fmu.fmi3InstantiateScheduledExecution(*none, None, log, *callbacks, unlock)
    assert driver.messages.pop().endswith(": found Scheduled Execution; valid: Co-Simulation")
    update = fmi3.fmi3IntermediateUpdateCallback()
    assert not driver.fmu.fmi3InstantiateCoSimulation(*none, *with_events, None, 0, None, log, update)
    text = ": found event mode in use; valid: without, as the modelDescription.xml says"
    assert driver.messages.pop().endswith(text)
    wanted = (fmi3.fmi3ValueReference * 1)(1)
    assert not driver.fmu.fmi3InstantiateCoSimulation(*none, *without, wanted, 1, None, log, update)
    text = ": found required intermediate variables; valid: none, there is no intermediate update"
    assert driver.messages.pop().endswith(text)


def test_model_exchange_of_fmi2_is_refused(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI2)
    instantiate = driver.fmu.dll.fmi2Instantiate
    instantiate.restype = c_void_p
    callbacks = driver.fmu.callbacks
    assert not instantiate(
        c_char_p(b"name"), 0, c_char_p(str(driver.description.guid).encode()), c_char_p(b""), byref(callbacks), 0, 0
    )
    assert driver.messages[-1].endswith(": found the type Model Exchange; valid: Co-Simulation")


def test_size_of_a_serialized_state_is_told(drive: Drive) -> None:
    driver = drive("bicycle", Version.FMI2)
    size = c_size_t()
    driver.fmu.fmi2SerializedFMUstateSize(driver.fmu.component, None, byref(size))
    assert size.value == len(own_state(driver))
