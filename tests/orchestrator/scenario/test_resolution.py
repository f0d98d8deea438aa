"""Which value each declared parameter gets, where it is from, and all that is wrong, at once."""

from __future__ import annotations

from components.interfaces.record import variables
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.resolution import resolve
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene


def test_a_unit_that_differs_is_told():
    given = {"ego_length": Given(value=460.0, unit="cm", source="test")}
    problems = resolve("scene", variables(Scene), parameter_set("scene"), given).problems
    assert [str(p) for p in problems] == ["scene.ego_length: found unit `cm`; valid: unit `m`"]
