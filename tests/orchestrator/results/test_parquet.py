"""Rows on disk: what pandas and our own reader find in them."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays, boolean_dtypes, floating_dtypes, integer_dtypes, unsigned_integer_dtypes

from orchestrator.results import parquet
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import EVERYTHING

NUMBERS = (
    boolean_dtypes()
    | floating_dtypes(endianness="<", sizes=(32, 64))
    | integer_dtypes(endianness="<")
    | unsigned_integer_dtypes(endianness="<")
)


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


def rows(scenario, record=EVERYTHING):
    with Simulation(scenario.system, h=scenario.h, until=2.0, record=record) as simulation:
        simulation.run()
        return simulation.frame()


@given(values=arrays(NUMBERS, st.tuples(st.integers(0, 40), st.just(3))))
def test_numbers_go_to_pyarrow_as_those_of_a_data_frame_do(values):
    for column in (values[:, 1], values.ravel()):
        found = parquet._array(column, parquet._type(column.dtype, is_text=False))
        found.validate(full=True)
        assert found.equals(pa.array(column, from_pandas=True))


@given(values=st.lists(st.text(max_size=9), max_size=20) | st.lists(st.binary(max_size=9), max_size=20))
def test_texts_and_bytes_go_to_pyarrow_as_they_are(values):
    column = np.empty(len(values), dtype=object)
    column[:] = values
    text = bool(values) and isinstance(values[0], str)
    found = parquet._array(column, parquet._type(column.dtype, is_text=text))
    found.validate(full=True)
    assert found.to_pylist() == values


def test_who_is_killed_while_writing_leaves_the_rows_that_were_there(static, tmp_path, monkeypatch):
    parquet.write_signals(rows(static), static, tmp_path / "s.parquet")
    before = (tmp_path / "s.parquet").read_bytes()

    def killed(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(pq.ParquetWriter, "write_table", killed)
    with pytest.raises(KeyboardInterrupt):
        parquet.write_signals(rows(static), static, tmp_path / "s.parquet")
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("s.parquet", before)]


@pytest.mark.parametrize("record", [EVERYTHING, {"plant.*": 1, "controller.*": 4}], ids=["all", "gaps"])
def test_pandas_reads_the_rows_of_the_simulation(static, tmp_path, record):
    frame = rows(static, record)
    parquet.write_signals(frame, static, tmp_path / "s.parquet")
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "s.parquet"), frame, check_exact=True)


def test_a_data_frame_and_plain_columns_give_the_same_file(static, tmp_path):
    frame = rows(static, {"plant.*": 1, "controller.*": 4})
    parquet.write_signals(frame, static, tmp_path / "frame.parquet")
    parquet.write_signals({n: frame[n].to_numpy() for n in frame}, static, tmp_path / "columns.parquet")
    assert (tmp_path / "frame.parquet").read_bytes() == (tmp_path / "columns.parquet").read_bytes()


def test_units_meanings_and_the_items_of_enumerations_stand_in_the_metadata(static, tmp_path):
    parquet.write_signals(rows(static), static, tmp_path / "s.parquet")
    schema = pq.read_schema(tmp_path / "s.parquet")
    assert schema.field("time").metadata == {b"unit": b"s", b"description": b"simulated time"}
    assert schema.field("plant.state.v_x").metadata[b"unit"] == b"m/s"
    assert json.loads(schema.field("controller.solver.status").metadata[b"items"])["fallback"] == 3
    assert json.loads(schema.metadata[b"macrostep"])["scenario"] == "static"
    assert json.loads(schema.metadata[b"units"])["plant.state.r"] == "rad/s"


def test_our_own_reader_finds_what_pandas_finds(static, tmp_path):
    frame = rows(static)
    parquet.write_signals(frame, static, tmp_path / "s.parquet")
    columns = parquet.read_columns(tmp_path / "s.parquet")
    pd.testing.assert_frame_equal(pd.DataFrame(columns), frame, check_exact=True)
