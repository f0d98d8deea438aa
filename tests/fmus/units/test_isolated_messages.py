"""Columns that two processes share, and the values that cannot be shared."""

from __future__ import annotations

import numpy as np

from components.interfaces.quantity import Type
from fmus.reading.opening import open_fmu
from fmus.units.isolated_messages import map_columns, put_texts, texts
from tests.fmus.reading.test_declared_variables import echo3


def test_numbers_lie_in_one_file_whoever_maps_it_first(tmp_path, tmp_path_factory):
    interface = open_fmu(echo3(tmp_path_factory)).interface
    (first_in, first_out), (second_in, second_out) = (map_columns(interface, tmp_path / "columns") for _ in range(2))
    for number, columns in enumerate([first_in, second_out], 1):
        for kind, column in columns.items():
            if kind.is_number:
                column[:] = number
    for number, columns in enumerate([second_in, first_out], 1):
        for kind, column in columns.items():
            assert not kind.is_number or (column == column.dtype.type(number)).all(), kind
    assert first_in[Type.STRING] is not second_in[Type.STRING]


def test_texts_and_bytes_are_lists_and_what_was_not_asked_for_changes_nothing():
    columns = {
        Type.FLOAT64: np.array([1.0]),
        Type.STRING: np.array(["a", "b"], dtype=object),
        Type.BINARY: np.array([b"\x00"], dtype=object),
    }
    assert texts(columns) == [["a", "b"], [b"\x00"]]
    put_texts(columns, [])
    assert texts(columns) == [["a", "b"], [b"\x00"]]
    put_texts(columns, [["c", "d"], [b""]])
    assert texts(columns) == [["c", "d"], [b""]]
    assert columns[Type.FLOAT64] == 1.0
