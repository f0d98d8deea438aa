"""FMUs in this process: parameters, states and errors; whole runs of them stand in `tests/closed_loop`.

Libraries that cannot be loaded or instantiated are refused in `reading/test_opening.py`. With it `fmu_state.py`.
"""

from __future__ import annotations

import pytest

from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from fmus.units.make import fmu_unit
from fmus.units.unit import UnitError
from tests.fmus.foreign import description3, library, pack
from tests.left_behind import left_in

Y = ['<Float64 name="y" valueReference="101" causality="output"/>']
OUTPUT = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']


@pytest.mark.parametrize("version", [2, 3])
def test_a_parameter_that_is_refused_is_named_with_its_value(built_fmus, version):
    unit = fmu_unit("plant", open_fmu(built_fmus / f"fmi{version}" / "bicycle.fmu"))
    unit.enter_initialization({})
    unit.exit_initialization()
    with pytest.raises(UnitError) as error:
        unit._set_parameters({"v_x_start": 20.0})  # a fixed one, too late
    unit.close()
    assert error.value.unit == "plant"
    assert error.value.action == "setting the parameter v_x_start to 20.0 (status 3)"
    assert error.value.said


def test_an_fmu_that_does_not_declare_it_has_no_state(tmp_path):
    path = pack(
        tmp_path / "m.fmu",
        Version.FMI3,
        description3(Y, OUTPUT),
        library(tmp_path, Version.FMI3, '#include "echo3.c"'),
    )
    unit = fmu_unit("m", open_fmu(path))
    assert unit.state is None
    assert unit.events is None
    unit.close()


@pytest.mark.parametrize("version", [2, 3])
def test_a_state_that_cannot_be_restored_is_an_error_of_the_unit(built_fmus, version):
    unit = fmu_unit("plant", open_fmu(built_fmus / f"fmi{version}" / "bicycle.fmu"))
    unit.enter_initialization({})
    unit.exit_initialization()
    saved = unit.state.save()
    unit.state.forget(saved)
    with pytest.raises(UnitError, match="plant: its state could not be restored"):
        unit.state.restore(None)
    unit.close()


def test_what_was_unpacked_goes_when_the_unit_is_closed(built_fmus, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    unit = fmu_unit("plant", open_fmu(built_fmus / "fmi3" / "bicycle.fmu"))
    assert left_in(tmp_path)
    unit.close()
    assert left_in(tmp_path) == []
