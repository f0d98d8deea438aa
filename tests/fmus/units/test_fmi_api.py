"""The descriptions of both versions name functions that FMPy has, and types as the headers of FMI have them."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.quantity import Type
from fmus.units.fmi_api import FMI2_API, FMI3_API


@pytest.mark.parametrize("api", [FMI2_API, FMI3_API], ids=["fmi2", "fmi3"])
def test_every_function_that_is_named_is_there(api):
    for kind in (api.co_simulation, api.model_exchange):
        for name in (api.get_state, api.set_state, api.free_state):
            assert callable(getattr(kind, name))
        for access in api.access.values():
            for direction in ("Get", "Set"):
                assert callable(getattr(kind, f"{api.prefix}{direction}{access.function}"))
        assert callable(getattr(kind, f"{api.prefix}FreeInstance"))


def test_fmi_2_knows_five_types_and_fmi_3_all():
    assert set(FMI2_API.access) == {Type.FLOAT64, Type.INT32, Type.BOOLEAN, Type.ENUMERATION, Type.STRING}
    assert set(FMI3_API.access) == set(Type)


def test_values_are_stored_as_in_c():
    assert FMI2_API.access[Type.BOOLEAN].dtype is np.int32
    assert FMI2_API.access[Type.ENUMERATION] == ("Integer", np.int32)
    assert FMI3_API.access[Type.ENUMERATION] == ("Int64", np.int64)
    assert np.dtype(FMI3_API.access[Type.BOOLEAN].dtype).itemsize == 1
    assert (FMI2_API.counts_values, FMI3_API.counts_values) == (False, True)
