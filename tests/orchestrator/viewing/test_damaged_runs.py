"""Runs whose files are damaged: what is damaged is named, and the rest is shown.

Shows `sound_rows.py`, `kept_summary.py`, `kept_series.py` and `series_process.py`.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from components.interfaces.problem import RequestError
from orchestrator.recording.kept_series import kept_series
from orchestrator.recording.series_reader import read_series
from orchestrator.results.run_folder import find
from orchestrator.viewing import repair, viewer


def test_series_are_the_same_from_the_other_process(run):
    found, expected = kept_series(run / "recording.rrd", "r", "r"), read_series(run / "recording.rrd")
    assert found.keys() == expected.keys()
    for entity, (ticks, values) in expected.items():
        assert found[entity][0].tolist() == ticks.tolist()
        np.testing.assert_array_equal(found[entity][1], values)


def test_a_recording_whose_end_is_damaged(run, tmp_path):
    content = bytearray((run / "recording.rrd").read_bytes())
    content[-20] ^= 1
    (tmp_path / "a.rrd").write_bytes(content)
    with pytest.raises(RequestError, match=r"^a.rrd: found a file that cannot be read \("):
        kept_series(tmp_path / "a.rrd", "a.rrd", "a recording")


def test_rows_of_which_some_are_none(run, tmp_path):
    table = pq.read_table(run / "signals.parquet")
    names = table.column_names
    texts = pa.array(["x"] * len(table))
    pq.write_table(table.set_column(names.index("plant.state.x"), "plant.state.x", texts), run / "signals.parquet")
    said = []
    rows = repair.rows(find(run), tmp_path, said.append)
    assert "plant.state.x" not in rows
    assert "plant.state.y" in rows
    assert said == [f"{run / 'signals.parquet'}: plant.state.x: values of another type; left out"]


@pytest.mark.parametrize(
    ("times", "told"),
    [
        (lambda times: [*times[:-1], None], "times that do not increase"),
        (lambda times: times[::-1], "times that do not increase"),
        (lambda times: [*times[:-1], float("inf")], "times that do not increase"),
        (lambda times: [str(t) for t in times], "no column `time` with numbers"),
        (lambda times: [t + 1000 for t in times], "times from 1000 s to 1002 s"),
    ],
)
def test_times_of_rows_that_are_none(run, tmp_path, times, told):
    table = pq.read_table(run / "signals.parquet")
    column = pa.array(times(table.column("time").to_pylist()))
    pq.write_table(table.set_column(0, "time", column), run / "signals.parquet")
    said = []
    assert "plant.state.x" in repair.rows(find(run), tmp_path, said.append)
    assert said == [f"{run / 'signals.parquet'}: {told}; it is not used"]


def test_a_summary_of_wrong_types_beside_sound_rows(run, whole, tmp_path):
    text = (
        '{"scenario": 1, "title": "t", "status": "s", "units": {"plant": 3}, "versions": {}, "metrics": {"a": "inf"}}'
    )
    (run / "summary.json").write_text(text)
    (tmp_path / "scratch").mkdir()
    said = []
    assert viewer.recording([find(whole), find(run)], [], tmp_path / "scratch", said.append).is_file()
    assert said == [f"{run}: damaged and left out: summary.json: scenario, units"]


def test_parts_of_rows_of_which_one_is_damaged(run, tmp_path):
    table = pq.read_table(run / "signals.parquet")
    (run / "rows").mkdir()
    for i, begin in enumerate((0, 8, 16)):
        pq.write_table(table.slice(begin, 8), run / "rows" / f"part-{i:06}.parquet")
    (run / "signals.parquet").unlink()
    damaged = run / "rows" / "part-000001.parquet"
    damaged.write_bytes(damaged.read_bytes()[:-9])
    said = []
    rows = repair.rows(find(run), tmp_path, said.append)
    assert len(rows["time"]) == len(table) - 8
    assert [line.partition(": a file")[0] for line in said] == [str(damaged)]
    assert said[0].endswith("; it is not used")


@pytest.mark.parametrize("noted", [b"", b"[1]", b'{"index_columns": 7}'])
def test_rows_whose_notes_of_pandas_are_damaged(run, tmp_path, noted):
    table = pq.read_table(run / "signals.parquet")
    meta = {**(table.schema.metadata or {}), b"pandas": noted}
    pq.write_table(table.replace_schema_metadata(meta), run / "signals.parquet")
    said = []
    rows = repair.rows(find(run), tmp_path, said.append)
    assert rows["plant.state.x"].tolist() == table.column("plant.state.x").to_pylist()
    assert said == []
