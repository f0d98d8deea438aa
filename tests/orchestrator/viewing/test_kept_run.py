"""Runs as they are kept: found, repaired, made anew, or refused."""

from __future__ import annotations

from shutil import copytree

import numpy as np
import pandas as pd
import pytest

from components.interfaces.problem import Problem, RequestError
from orchestrator.viewing import kept_run
from orchestrator.viewing.rerun_stream import RerunStream, read_series


@pytest.fixture(scope="module")
def whole(kept_run, tmp_path_factory):
    return kept_run(tmp_path_factory.mktemp("runs") / "static-1", until=2.0)


@pytest.fixture
def run(whole, tmp_path):
    return copytree(whole, tmp_path / "static-1")


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
    found = kept_run.find(run)
    assert kept_run.whole_recording(found, scratch, said.append) == run / "recording.rrd"
    assert said == []


@pytest.mark.parametrize("share", [0.3, 0.6, 0.97])
def test_a_recording_without_its_end_is_repaired_into_a_copy(run, scratch, share):
    _cut(run, share)
    (run / "signals.parquet").unlink()
    before = (run / "recording.rrd").read_bytes()
    said = []
    copy = kept_run.whole_recording(kept_run.find(run), scratch, said.append)
    assert copy.parent == scratch
    assert (run / "recording.rrd").read_bytes() == before
    assert said == [f"{run}: the recording was cut short or is damaged; opening a repaired copy of what can be read"]
    assert "/signals/plant/state/x" in read_series(copy)


def test_a_damaged_or_missing_recording_is_made_anew_from_the_rows(run, scratch):
    expected = read_series(run / "recording.rrd")
    _cut(run, 0.5)
    said = []
    copy = kept_run.whole_recording(kept_run.find(run), scratch, said.append)
    (run / "recording.rrd").unlink()
    kept_run.whole_recording(kept_run.find(run), scratch, said.append)
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
    kept_run.whole_recording(kept_run.find(run), scratch, said.append)
    assert said == [f"{run}: the recording was cut short or is damaged; opening a repaired copy of what can be read"]
    (run / "recording.rrd").unlink()
    with pytest.raises(RequestError) as raised:
        kept_run.whole_recording(kept_run.find(run), scratch, said.append)
    assert str(raised.value) == (
        f"{run / 'signals.parquet'}: found a file that cannot be read; valid: the signals.parquet of a run. "
        "Run it again, or open recording.rrd itself."
    )


def test_rows_are_the_same_from_parquet_and_from_the_recording(run, scratch):
    frame = pd.read_parquet(run / "signals.parquet")
    (run / "signals.parquet").unlink()
    found = kept_run.rows(kept_run.find(run), scratch, lambda _: None)
    assert set(found) == set(frame)
    for name in frame:
        np.testing.assert_array_equal(found[name], frame[name].to_numpy(dtype=float), name)


def test_a_signal_that_lacks_rows_in_the_recording_keeps_the_others(run, scratch):
    frame = pd.read_parquet(run / "signals.parquet")
    (run / "signals.parquet").unlink()
    system, scene = (found := kept_run.find(run)).scenario.system, found.scenario.scene
    stream = RerunStream(run / "recording.rrd", system, scene, name="run", h=0.1, about={})
    stream.log({name: frame[name].to_numpy() for name in ("time", "plant.state.x")}, None)
    stream.log({name: frame[name].to_numpy()[::5] for name in ("time", "plant.state.y")}, None)
    stream.close()
    rows = kept_run.rows(found, scratch, lambda _: None)
    assert rows.keys() == {"time", "plant.state.x", "plant.state.y"}
    np.testing.assert_array_equal(rows["plant.state.x"], frame["plant.state.x"])
    np.testing.assert_array_equal(rows["plant.state.y"][::5], frame["plant.state.y"][::5])
    assert np.isnan(rows["plant.state.y"]).sum() == len(frame) - len(frame[::5])


def _problem(request):
    found = kept_run.find(request)
    assert isinstance(found, Problem)
    return str(found)


def test_what_is_no_run_is_refused(tmp_path, run):
    readme = tmp_path / "README.md"
    readme.write_text("# macrostep")
    valid = "valid: a run folder, or an .rrd file. Make a run: macrostep run static"
    nowhere = tmp_path / "nowhere"
    assert _problem(nowhere) == f"{nowhere}: found no such file or folder; {valid}"
    assert _problem(readme) == f"{readme}: found a file that is no recording; {valid}"
    assert _problem(tmp_path) == f"{tmp_path}: found a folder without recording.rrd; {valid}"
    for name in ("recording.rrd", "signals.parquet"):
        (run / name).unlink()
    assert _problem(run) == (
        f"{run}: found a run without recording.rrd and signals.parquet; "
        "valid: a run folder, or an .rrd file. Run it again."
    )


@pytest.mark.parametrize("content", [b"RRF2", b"RRF2" + bytes(range(256)) * 50])
def test_a_recording_that_holds_nothing_is_refused(tmp_path, scratch, content):
    path = tmp_path / "broken.rrd"
    path.write_bytes(content)
    with pytest.raises(RequestError) as raised:
        kept_run.whole_recording(kept_run.find(path), scratch, lambda _: None)
    assert str(raised.value) == (
        f"{path}: found a recording that cannot be read; valid: a run folder, or an .rrd file. Run it again."
    )


def test_a_recording_on_its_own_has_no_system(whole, tmp_path):
    path = tmp_path / "alone.rrd"
    path.write_bytes((whole / "recording.rrd").read_bytes())
    run = kept_run.find(path)
    assert run.folder is None
    with pytest.raises(RequestError, match="found a recording on its own; valid: a run folder"):
        _ = run.scenario
    assert kept_run.find(whole / "recording.rrd").folder == whole


def test_a_summary_that_was_not_written_is_empty(run):
    assert kept_run.find(run).summary == {}
