"""Records: declaration, names of elements, and the way to a flat column and back."""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from components.interfaces.buses import ObstacleList, Plan, Solver, VehicleState, Waypoints
from components.interfaces.maths import Array
from components.interfaces.problem import RequestError
from components.interfaces.quantity import quantity
from components.interfaces.record import (
    combine,
    groups,
    leaves,
    pack,
    pack_all,
    record,
    size,
    unpack,
    unpack_all,
    value_problems,
    variables,
)
from components.interfaces.sockets import ControllerInputs


@record
class Inner:
    a: float = quantity("m", "first")
    b: Array = quantity("m/s", "second", shape=(2,))


@record
class Outer:
    before: float = quantity("1", "before", min=0)
    inner: Inner
    wide: Array = quantity("s", "as long as the block says", shape=("N_p",))


N_P = {"N_p": 3}
numbers = st.floats(allow_nan=False, allow_infinity=False)


def test_a_field_without_a_quantity_is_refused():
    with pytest.raises(RequestError) as caught:

        @record
        class Loose:
            gap: float = 1.0

    assert str(caught.value) == (
        "Loose.gap: found a field without a quantity; valid: a field made by quantity(...) or a record"
    )


def test_a_field_has_no_default_and_must_be_given_by_name():
    with pytest.raises(RequestError, match=r"^Inner\.b: found no value; valid: finite number"):
        Inner(a=1.0)
    with pytest.raises(RequestError, match=r"^Inner\.c: found an unknown field; valid: a, b$"):
        Inner(a=1.0, b=np.zeros(2), c=0.0)
    with pytest.raises(TypeError, match="positional"):
        Inner(1.0, np.zeros(2))


def test_a_record_cannot_be_changed():
    inner = Inner(a=1.0, b=np.zeros(2))
    with pytest.raises(dataclasses.FrozenInstanceError):
        inner.a = 2.0


def test_variables_have_dotted_names_in_the_order_of_declaration():
    found = variables(Outer, N_P, prefix="unit.")
    assert [v.name for v in found] == ["unit.before", "unit.inner.a", "unit.inner.b", "unit.wide"]
    assert [v.shape for v in found] == [(), (), (2,), (3,)]
    assert [v.size for v in found] == [1, 1, 2, 3]
    assert size(Outer, N_P) == 7


def test_elements_of_an_array_are_counted_from_one():
    by_name = {v.name: v for v in variables(Outer, N_P)}
    assert by_name["before"].elements == ["before"]
    assert by_name["inner.b"].elements == ["inner.b[1]", "inner.b[2]"]
    matrix = dataclasses.replace(by_name["before"].quantity, shape=(2, 2))
    assert dataclasses.replace(by_name["before"], quantity=matrix).elements == [
        "before[1,1]",
        "before[1,2]",
        "before[2,1]",
        "before[2,2]",
    ]


def test_a_named_dimension_takes_its_length_from_the_block():
    assert [v.size for v in variables(Plan, {"N_p": 5})] == [5] * 6
    with pytest.raises(KeyError, match="N_p"):
        variables(Plan)


def test_groups_are_the_buses_nested_in_a_record():
    assert groups(ControllerInputs) == {"ego": VehicleState, "obstacles": ObstacleList}
    assert groups(VehicleState) == {}


@given(arrays(float, 7, elements=numbers))
def test_unpack_and_pack_are_inverse(column):
    outer = unpack(Outer, column, N_P)
    assert pack(outer).tobytes() == column.tobytes()
    assert (outer.before, outer.inner.a) == (column[0], column[1])
    assert outer.inner.b.tolist() == column[2:4].tolist()
    assert outer.wide.tolist() == column[4:].tolist()


@pytest.mark.parametrize("kind", [VehicleState, ObstacleList, Waypoints, Plan, Solver, ControllerInputs])
@given(data=st.data())
def test_every_bus_survives_the_way_to_a_column_and_back(kind, data):
    column = data.draw(arrays(float, size(kind, N_P), elements=numbers))
    assert pack(unpack(kind, column, N_P)).tobytes() == column.tobytes()


def test_symbols_pack_like_numbers():
    column = ca.SX.sym("c", 7)
    there_and_back = ca.Function("f", [column], [pack(unpack(Outer, column, N_P))])
    given = np.arange(7.0)
    assert np.array_equal(np.asarray(there_and_back(given)).ravel(), given)


@given(arrays(float, 7, elements=st.floats(-1e6, 1e6)), arrays(float, 7, elements=st.floats(-1e6, 1e6)))
def test_combine_works_on_every_value(first, second):
    sums = combine(lambda a, b: a + 2 * b, unpack(Outer, first, N_P), unpack(Outer, second, N_P))
    assert np.array_equal(pack(sums), first + 2 * second)


def test_leaves_are_the_values_in_order():
    outer = unpack(Outer, np.arange(7.0), N_P)
    assert [np.asarray(leaf).tolist() for leaf in leaves(outer)] == [0.0, 1.0, [2.0, 3.0], [4.0, 5.0, 6.0]]


def test_every_wrong_value_of_a_record_is_reported_with_its_path():
    wrong = Outer(before=-1.0, inner=Inner(a=float("nan"), b=np.zeros(3)), wide=np.zeros(3))
    assert list(map(str, value_problems(wrong, "unit", variables(type(wrong), N_P)))) == [
        "unit.before: found -1.0; valid: 0 <= finite number",
        "unit.inner.a: found nan; valid: finite number [m]",
        "unit.inner.b: found shape (3,); valid: shape (2,)",
    ]


def test_symbols_are_not_judged():
    inner = Inner(a=ca.SX.sym("a"), b=ca.SX.sym("b", 5))
    assert value_problems(inner, "unit", variables(type(inner))) == []


def test_several_records_stand_one_below_the_other():
    column = np.arange(6.0)
    first, second = unpack_all(Inner, column)
    assert (first.a, first.b.tolist(), second.a, second.b.tolist()) == (0.0, [1.0, 2.0], 3.0, [4.0, 5.0])
    assert pack_all([first, second]).tolist() == column.tolist()
    symbol = ca.SX.sym("c", 6)
    assert ca.is_equal(ca.simplify(pack_all(unpack_all(Inner, symbol))), symbol, 1)
