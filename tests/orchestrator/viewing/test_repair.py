"""Runs that are opened whatever is missing or damaged: repaired, made anew, or refused."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from orchestrator.recording.series_reader import read_series
from orchestrator.recording.stream import RerunStream
from orchestrator.results.run_folder import find
from orchestrator.viewing import repair
from orchestrator.viewing.rerun_program import tell_of_usage_data


@pytest.fixture
def scratch(tmp_path):
    made = tmp_path / "scratch"
    made.mkdir()
    return made


def _cut(run, share):
    """Leave only the first part of the recording, as a killed run does."""
    path = run / "recording.rrd"
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])


def test_a_whole_recording_is_opened_as_it_is(run, scratch):
    said = []
    found = find(run)
    assert repair.whole_recording(found, scratch, said.append) == run / "recording.rrd"
    assert said == []


def test_a_recording_is_whole_also_where_rerun_has_never_been_used(run, scratch, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "new"))
    monkeypatch.delenv("CI", raising=False)  # where it is set, Rerun collects nothing and keeps no settings
    said, notices = [], []
    tell_of_usage_data(notices.append)
    assert repair.whole_recording(find(run), scratch, said.append) == run / "recording.rrd"
    assert said == []
    tell_of_usage_data(notices.append)  # it has been used now
    (notice,) = notices
    assert "anonymous usage data" in notice
    assert "`rerun analytics disable` opts out" in notice


def test_nothing_is_said_of_usage_data_where_rerun_collects_none(run, scratch, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "new"))
    monkeypatch.setenv("CI", "true")
    said, notices = [], []
    tell_of_usage_data(notices.append)
    assert repair.whole_recording(find(run), scratch, said.append) == run / "recording.rrd"
    assert said == notices == []
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("share", [0.45, 0.7, 0.97])
def test_a_recording_without_its_end_is_repaired_into_a_copy(run, scratch, share):
    _cut(run, share)
    (run / "signals.parquet").unlink()
    before = (run / "recording.rrd").read_bytes()
    said = []
    copy = repair.whole_recording(find(run), scratch, said.append)
    assert copy.parent == scratch
    assert (run / "recording.rrd").read_bytes() == before
    assert said == [f"{run}: the recording was cut short or is damaged; opening a repaired copy of what can be read"]
    assert "/signals/plant/state/x" in read_series(copy)


def test_a_damaged_or_missing_recording_is_made_anew_from_the_rows(run, scratch):
    expected = read_series(run / "recording.rrd")
    _cut(run, 0.5)
    said = []
    copy = repair.whole_recording(find(run), scratch, said.append)
    (run / "recording.rrd").unlink()
    repair.whole_recording(find(run), scratch, said.append)
    assert said == [
        f"{run}: a recording.rrd that is damaged; opening one made from signals.parquet",
        f"{run}: no recording.rrd; opening one made from signals.parquet",
    ]
    found = read_series(copy)
    assert expected.keys() - found.keys() == {"/performance/step_time"}
    for entity in found:
        np.testing.assert_array_equal(found[entity][1], expected[entity][1])


def test_rows_that_cannot_be_read_leave_the_recording(run, scratch):
    _cut(run, 0.6)
    (run / "signals.parquet").write_bytes(b"PAR1, cut short")
    said = []
    repair.whole_recording(find(run), scratch, said.append)
    reason = "Parquet magic bytes not found in footer. Either the file is corrupted or this is not a parquet file."
    found = f"a file that cannot be read (ArrowInvalid: {reason})"
    assert said == [
        f"{run / 'signals.parquet'}: {found}; it is not used",
        f"{run}: the recording was cut short or is damaged; opening a repaired copy of what can be read",
    ]
    (run / "recording.rrd").unlink()
    with pytest.raises(RequestError) as raised:
        repair.whole_recording(find(run), scratch, said.append)
    assert str(raised.value) == (
        f"{run / 'signals.parquet'}: found {found}; valid: the signals.parquet of a run. "
        "Run it again, or open recording.rrd itself."
    )


def test_rows_are_the_same_from_parquet_and_from_the_recording(run, scratch):
    frame = pd.read_parquet(run / "signals.parquet")
    (run / "signals.parquet").unlink()
    found = repair.rows(find(run), scratch, lambda _: None)
    assert set(found) == set(frame)
    for name in frame:
        np.testing.assert_array_equal(found[name], frame[name].to_numpy(dtype=float), name)


def test_a_signal_that_lacks_rows_in_the_recording_keeps_the_others(run, scratch):
    frame = pd.read_parquet(run / "signals.parquet")
    (run / "signals.parquet").unlink()
    system, scene = (found := find(run)).scenario.system, found.scenario.scene
    stream = RerunStream(run / "recording.rrd", system, scene, name="run", grid=found.scenario.grid, about={})
    stream.log({name: frame[name].to_numpy() for name in ("time", "plant.state.x")}, None)
    stream.log({name: frame[name].to_numpy()[::5] for name in ("time", "plant.state.y")}, None)
    stream.close()
    rows = repair.rows(found, scratch, lambda _: None)
    assert rows.keys() == {"time", "plant.state.x", "plant.state.y"}
    np.testing.assert_array_equal(rows["plant.state.x"], frame["plant.state.x"])
    np.testing.assert_array_equal(rows["plant.state.y"][::5], frame["plant.state.y"][::5])
    assert np.isnan(rows["plant.state.y"]).sum() == len(frame) - len(frame[::5])


@pytest.mark.parametrize("content", [b"RRF2", b"RRF2" + bytes(range(256)) * 50])
def test_a_recording_that_holds_nothing_is_refused(tmp_path, scratch, content):
    path = tmp_path / "broken.rrd"
    path.write_bytes(content)
    with pytest.raises(RequestError) as raised:
        repair.whole_recording(find(path), scratch, lambda _: None)
    assert str(raised.value) == (
        f"{path}: found a recording that cannot be read; valid: a run folder, or an .rrd file. Run it again."
    )
