"""Each kind of FMU becomes its kind of unit; Model Exchange in `test_model_exchange`, with Event Mode below."""

from __future__ import annotations

import pytest

from fmus.reading.opening import open_fmu
from fmus.units.clocked_unit import ClockedUnit
from fmus.units.co_simulation import Fmu2Unit, Fmu3Unit
from fmus.units.make import fmu_unit


@pytest.mark.parametrize(
    ("file", "kind"),
    [("fmi2/bicycle.fmu", Fmu2Unit), ("fmi3/bicycle.fmu", Fmu3Unit), ("fmi3/stanley.fmu", ClockedUnit)],
)
def test_the_file_decides(built_fmus, file, kind):
    unit = fmu_unit("m", open_fmu(built_fmus / file))
    assert type(unit) is kind
    unit.close()
