"""What is odd in a description."""

from __future__ import annotations

import pytest

from orchestrator.exchange.passport import declarations
from orchestrator.system.source import Fmu
from tests.orchestrator.exchange.passport.measured_fmus import lag, told

FINE = {
    "declared.starts": ("passes", "all of 3 variables"),
    "declared.limits": ("passes", "all of 3 variables"),
    "declared.units": ("passes", "all of 3 variables"),
}


def found(folder, **description):
    return told(declarations.lines(Fmu(lag(folder, **description), lenient=True).archive))


def test_a_description_in_order_passes(tmp_path):
    assert found(tmp_path) == FINE


@pytest.mark.parametrize(
    ("u", "key", "evidence"),
    [
        ('unit="V" start="-2" min="-1"', "starts", "`u` starts with -2, below its minimum -1"),
        ('unit="V" start="2" max="1"', "starts", "`u` starts with 2, above its maximum 1"),
        ('unit="V" start="INF"', "starts", "`u` starts with inf"),
        ('unit="V" start="NaN"', "starts", "`u` starts with nan"),
        ('unit="V" start="1" min="2" max="0"', "limits", "`u` has the minimum 2 above its maximum 0"),
        ('unit="V" start="1" nominal="0"', "limits", "`u` has the nominal value 0"),
        (
            'unit="knots" start="1"',
            "units",
            "`u` has the unit `knots`, which is neither known nor defined in SI units",
        ),
    ],
)
def test_what_is_odd_fails_with_its_place(tmp_path, u, key, evidence):
    mark, text = found(tmp_path, u=u)[f"declared.{key}"]
    assert mark == "fails"
    assert text.startswith(evidence)


def test_units_that_are_known_need_no_definition(tmp_path):
    assert found(tmp_path, u='unit="km/h" start="1"', y='unit="rpm"')["declared.units"][0] == "passes"


def test_variables_without_a_unit_are_counted_and_allowed(tmp_path):
    more = [f'<ScalarVariable name="p{i}" valueReference="{9 + i}" causality="parameter" variability="fixed">'
            '<Real start="1"/></ScalarVariable>' for i in range(5)]  # fmt: skip
    line = declarations.lines(Fmu(lag(tmp_path, more=more)).archive)[2]
    assert line.evidence.endswith("; without a unit, which FMI allows: `p0`, `p1`, `p2` and 2 more")
