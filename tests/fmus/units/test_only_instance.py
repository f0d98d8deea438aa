"""A process holds one instance of an FMU that says so, however many simulations there are."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from fmus.units.make import fmu_unit
from tests.fmus.foreign import description2, library, pack, scalar


def test_the_second_instance_is_refused_until_the_first_is_gone(tmp_path):
    once = '<CoSimulation modelIdentifier="m" canBeInstantiatedOnlyOncePerProcess="true"/>'
    text = description2([scalar("y", 1, "output")], ['<Unknown index="1" dependencies=""/>'], interface=once)
    path = pack(tmp_path / "m.fmu", Version.FMI2, text, library(tmp_path, Version.FMI2, '#include "lag2.c"'))
    archive = open_fmu(path)
    first = fmu_unit("a", archive)
    with pytest.raises(RequestError) as error:
        fmu_unit("b", archive)
    assert str(error.value.problems[0]) == (
        f"{path}: found an FMU of which this process has an instance already, and which says that it can hold only one;"
        " valid: one instance at a time. Close the other one first, or run one of them in a process of its own."
    )
    first.close()
    fmu_unit("b", archive).close()
