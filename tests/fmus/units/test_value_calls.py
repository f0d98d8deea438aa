"""Prepared calls (`prepared_calls.py`) on functions in Python; `reading/test_declared_variables.py` has every type."""

from __future__ import annotations

import ctypes
from types import SimpleNamespace

import numpy as np
import pytest

from components.interfaces.quantity import Type, boolean, quantity, zeros
from components.interfaces.record import Variable
from fmus.units.fmi_api import FMI2_API, FMI3_API
from fmus.units.value_calls import ValueCalls

X = Variable("x", quantity("m", "a length", shape=(2,)).metadata["quantity"])
VALID = Variable("valid", boolean("whether it is there").metadata["quantity"])
INSTANCE = 4711


class Library:
    """Its functions note what they are called with."""

    def __init__(self):
        self.calls = []

    def prepared(self, name, _arguments):
        def function(*arguments):
            self.calls.append((name, arguments))
            return 0

        return function


@pytest.fixture
def library():
    return Library()


def calls(library, api):
    references = {"x": [5, 6] if api is FMI2_API else [5], "valid": [7]}
    return ValueCalls(SimpleNamespace(dll=library), api, INSTANCE, references)


def at(address, kind, n):
    return list((kind * n).from_address(address))


@pytest.mark.parametrize(
    ("api", "name", "references"), [(FMI2_API, "fmi2SetReal", [5, 6]), (FMI3_API, "fmi3SetFloat64", [5])]
)
def test_numbers_that_the_library_stores_alike_are_not_copied(library, api, name, references):
    column = np.array([1.5, 2.5])
    prepared = calls(library, api)
    set_values = prepared.mover("Set", [X], column)
    assert set_values() == 0
    ((called, (instance, first, n, values, *counts)),) = library.calls
    assert (called, instance, n, values) == (name, INSTANCE, len(references), column.ctypes.data)
    assert at(first, ctypes.c_uint32, n) == references
    assert counts == ([] if api is FMI2_API else [2])


def test_numbers_that_the_library_stores_otherwise_are_converted_on_their_way(library):
    column = zeros(Type.BOOLEAN, 1)
    prepared = calls(library, FMI2_API)
    column[0] = True
    prepared.mover("Set", [VALID], column)()
    name, (_, _, _, values) = library.calls[-1]
    assert name == "fmi2SetBoolean"
    assert at(values, ctypes.c_int32, 1) == [1]
    fetch = prepared.mover("Get", [VALID], column)
    fetch()
    assert column.tolist() == [False], "what the library wrote, which is nothing"


def test_there_is_one_call_for_each_type(library):
    columns = {Type.FLOAT64: np.zeros(2), Type.BOOLEAN: zeros(Type.BOOLEAN, 1)}
    prepared = calls(library, FMI3_API)
    movers = prepared.movers("Get", [X, VALID], columns)
    assert [move() for move in movers] == [0, 0]
    assert [name for name, _ in library.calls] == ["fmi3GetFloat64", "fmi3GetBoolean"]


def test_there_is_one_call_for_each_variable_on_its_part_of_a_column(library):
    y = Variable("y", quantity("m", "another one").metadata["quantity"])
    columns = {Type.FLOAT64: np.array([1.5, 2.5, 3.5]), Type.BOOLEAN: zeros(Type.BOOLEAN, 1)}
    prepared = ValueCalls(SimpleNamespace(dll=library), FMI2_API, INSTANCE, {"x": [5, 6], "y": [8], "valid": [7]})
    moves = prepared.each("Set", [X, VALID, y], columns)
    assert list(moves) == ["x", "y", "valid"]
    for move in moves.values():
        assert move() == 0
    (x, of_x), (y, of_y), (valid, _) = library.calls
    assert (x, y, valid) == ("fmi2SetReal", "fmi2SetReal", "fmi2SetBoolean")
    assert [at(a[1], ctypes.c_uint32, a[2]) for a in (of_x, of_y)] == [[5, 6], [8]]
    assert [at(a[3], ctypes.c_double, a[2]) for a in (of_x, of_y)] == [[1.5, 2.5], [3.5]]
