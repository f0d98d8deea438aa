"""What all units share: errors with their facts, columns by type, and calls that stop at a failure."""

from __future__ import annotations

import pytest

from components.interfaces.quantity import Type, boolean, quantity, zeros
from components.interfaces.record import Variable
from fmus.units.unit import UnitError, by_type, carry_out, positions, views, widths

VARIABLES = (
    Variable("x", quantity("m", "a length").metadata["quantity"]),
    Variable("valid", boolean("whether it is there", shape=(2,)).metadata["quantity"]),
    Variable("path", quantity("m", "lengths", shape=(3,)).metadata["quantity"]),
)


@pytest.mark.parametrize(("said", "reason"), [((), "the step failed"), (("a: b", "c"), "the step failed: a: b; c")])
def test_the_reason_of_an_error_is_a_fact_and_its_text_names_the_unit(said, reason):
    error = UnitError("a: unit", "the step failed", said)
    assert (error.unit, error.action, error.said, error.reason) == ("a: unit", "the step failed", said, reason)
    assert str(error) == f"a: unit: {reason}"


def test_variables_lie_in_columns_by_type_in_order():
    assert {kind: [v.name for v in group] for kind, group in by_type(VARIABLES).items()} == {
        Type.FLOAT64: ["x", "path"],
        Type.BOOLEAN: ["valid"],
    }
    assert widths(VARIABLES) == {Type.FLOAT64: 4, Type.BOOLEAN: 2}
    assert positions(VARIABLES) == {
        "x": (Type.FLOAT64, 0),
        "path": (Type.FLOAT64, 1),
        "valid": (Type.BOOLEAN, 0),
    }


def test_views_write_to_the_columns():
    columns = {kind: zeros(kind, n) for kind, n in widths(VARIABLES).items()}
    slots = views(VARIABLES, columns)
    slots["path"][:] = [1.0, 2.0, 3.0]
    slots["valid"][1] = True
    assert columns[Type.FLOAT64].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert columns[Type.BOOLEAN].tolist() == [False, True]


@pytest.mark.parametrize(
    ("statuses", "worst", "called"),
    [([], 0, 0), ([None, 0, ()], 0, 3), ([0, 1, 0], 1, 3), ([0, 3, 0], 3, 2), ([2, 4], 2, 1)],
)
def test_calls_are_carried_out_up_to_the_first_that_fails(statuses, worst, called):
    calls = []

    def call(status):
        return lambda: calls.append(status) or status

    assert carry_out([call(status) for status in statuses]) == worst
    assert len(calls) == called
