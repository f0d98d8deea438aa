"""Functions are found whatever stands before their names; statuses that FMI does not have are failures."""

from __future__ import annotations

import ctypes

import pytest

from fmus.toolchain.fmpy_library import (
    FMICallException,
    FMU1Model,
    FMU1Slave,
    FMU2Model,
    FMU2Slave,
    FMU3Model,
    FMU3Slave,
)
from fmus.toolchain.function_library import BoundFunctions, FunctionLibrary, _types, function_prefix
from fmus.toolchain.version import Version
from tests.fmus.foreign import kept_folder, library

SOURCE = "int m_fmi2Reset(int status) { return status; } const char *fmi2GetVersion(void) { return (char *)-1; }"


@pytest.fixture(scope="module")
def functions():
    path = library(kept_folder() / "functions", Version.FMI2, SOURCE, absent=["fmi2Reset", "fmi2Terminate"])
    return FunctionLibrary(ctypes.CDLL(str(path)), "m_", FMICallException)


def called(functions, status):
    reset = functions.fmi2Reset
    reset.argtypes, reset.restype = [ctypes.c_int], ctypes.c_int
    return reset(status)


@pytest.mark.parametrize("status", [-1, -7, -(2**31)])
def test_a_negative_status_is_a_failure(functions, status):
    with pytest.raises(FMICallException) as error:
        called(functions, status)
    assert (error.value.function, error.value.status) == ("fmi2Reset", status)


def test_a_warning_is_told(functions):
    told = []
    functions.warned = told.append
    assert [called(functions, status) for status in (0, 1, 2)] == [0, 1, 2]
    assert told == ["fmi2Reset"]


def test_what_is_no_status_is_left_alone(functions):
    version = functions.fmi2GetVersion
    version.argtypes, version.restype = [], ctypes.c_ssize_t
    assert version() == -1


def test_an_absent_function_can_be_looked_up_but_not_called(functions):
    terminate = functions.fmi2Terminate
    with pytest.raises(FMICallException, match="fmi2Terminate"):
        terminate(1)
    with pytest.raises(AttributeError):
        _ = functions.__wrapped__


def test_a_prefix_is_found():
    assert function_prefix(["a_fmi2DoStep"], "m", "fmi2DoStep") == "a_"
    assert function_prefix(["fmi2DoStep"], "m", "fmi2DoStep") == ""


def test_functions_are_bound_when_they_are_first_called(functions):
    bound = BoundFunctions(functions, FMU2Slave)
    assert not bound
    reset = bound["fmi2Reset"]
    assert (reset.argtypes, reset.restype) == ([ctypes.c_void_p], ctypes.c_int)
    assert bound["fmi2Reset"] is reset
    assert list(bound) == ["fmi2Reset"]
    assert bound["fmi2GetVersion"].restype is ctypes.c_char_p


@pytest.mark.parametrize("fmu_class", [FMU1Slave, FMU1Model, FMU2Slave, FMU2Model, FMU3Slave, FMU3Model])
def test_fmpy_tells_the_types_of_all_functions(fmu_class):
    for name in (name for name in dir(fmu_class) if name.startswith("fmi")):
        arguments, result = _types(fmu_class, name)
        assert all(isinstance(kind, type) for kind in arguments), name
        assert result is None or issubclass(result, ctypes._SimpleCData), name
