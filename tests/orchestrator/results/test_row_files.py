"""Rows that go to disk as they come, in a folder that lasts (`live_folder.py`): whole at any time."""

from __future__ import annotations

import errno
import shutil
import time
from contextlib import contextmanager

import numpy as np
import pandas as pd
import pytest

from orchestrator.results import row_files, summary
from orchestrator.results.live_folder import LiveFolder
from orchestrator.results.row_files import RowFiles
from orchestrator.results.run_folder import new_folder
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping import rows
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.experiment import EVERYTHING


@contextmanager
def running(folder, record=EVERYTHING, **changed):
    """A simulation, its folder and what writes its rows; the thread that writes is not begun."""
    scenario = prepare("static", Options(mode="blocks", stop_time=6.0))
    simulation = Simulation(scenario.system, h=0.1, until=6.0, record=record)
    with simulation, new_folder("static", folder) as claimed:
        live = LiveFolder(claimed, scenario, summary.draft(scenario, simulation), **changed)
        yield simulation, live, RowFiles(live, scenario, simulation)


def steps(simulation, n):
    for _ in range(n):
        simulation.step()


def in_parts(folder):
    return pd.read_parquet(folder / "rows")


@pytest.mark.parametrize("record", [EVERYTHING, {"plant.*": 1, "controller.*": 4}, {"plant.*": 3, "traffic.*": 2}])
@pytest.mark.parametrize("largest", [1, 7, 1000])
def test_pandas_reads_the_rows_at_any_time_and_one_file_at_the_end(tmp_path, record, largest):
    with running(tmp_path / "r", record) as (simulation, _, files):
        files._largest = largest
        for n in (0, 3, 1, 20, 17):
            steps(simulation, n)
            files._try()
            pd.testing.assert_frame_equal(in_parts(tmp_path / "r"), simulation.frame(), check_exact=True)
        assert len(list((tmp_path / "r" / "rows").glob("part-*"))) == max(1, -(-41 // largest))
        simulation.run()
        files.finish()
        assert files.problem == ""
        whole = pd.read_parquet(tmp_path / "r" / "signals.parquet")
        pd.testing.assert_frame_equal(whole, simulation.frame(), check_exact=True)
    assert not (tmp_path / "r" / "rows").exists()


def test_the_file_is_the_same_however_its_rows_came(tmp_path):
    for name, pieces, largest in (("a", (61,), 1000), ("b", (1, 2, 30, 28), 10)):
        with running(tmp_path / name) as (simulation, _, files):
            files._largest = largest
            for n in pieces:
                steps(simulation, n)
                files._try()
            files.finish()
    first, second = ((tmp_path / name / "signals.parquet").read_bytes() for name in "ab")
    assert first == second


@pytest.mark.parametrize("record", [EVERYTHING, {"plant.*": 1, "controller.*": 4}, {"plant.*": 3, "traffic.*": 2}])
def test_rows_that_are_on_disk_leave_memory_and_are_found_again(tmp_path, record, monkeypatch):
    with running(tmp_path / "whole", record) as (simulation, *_):
        simulation.run()
        whole, batches = simulation.frame(), simulation.log.batches(0, 61, simulation.step_times)
    monkeypatch.setattr(rows, "BLOCK", 2000)
    monkeypatch.setattr(rows, "KEPT_BLOCKS", 2)
    with running(tmp_path / "r", record) as (simulation, _, files):
        files._largest = 4
        for n in (20, 20, 21):
            steps(simulation, n)
            files._try()
            simulation.log.drop(files._parts[-1].first, files._read)
        assert simulation.log.in_memory_from > 10
        for _ in range(2):  # from the parts, and from the one file
            pd.testing.assert_frame_equal(simulation.frame(), whole, check_exact=True)
            for one, other in zip(simulation.log.batches(0, 61, simulation.step_times), batches, strict=True):
                assert (one.group, one.first, one.every) == (other.group, other.first, other.every)
                for kind, values in other.blocks.items():
                    assert values.dtype == one.blocks[kind].dtype
                    np.testing.assert_array_equal(one.blocks[kind], values)
            files.finish()
        pd.testing.assert_frame_equal(pd.DataFrame(dict(files.columns())), whole, check_exact=True)
        simulation.log.drop(61, files._read)
        frame = pd.DataFrame(simulation.rows(3, 17))
        pd.testing.assert_frame_equal(frame, whole[whole["time"].between(0.25, 1.65)].reset_index(drop=True))


def full(times):
    """A disk that has no room for some writings."""
    left = [times]

    def write(self, frame, path, _real=row_files.SignalSchema.write_part):
        if left[0] and len(frame["time"]) > 4:
            left[0] -= 1
            raise OSError(errno.ENOSPC, "No space left on device")
        _real(self, frame, path)

    return write


def test_on_a_full_disk_what_fits_is_written_and_the_rest_later(tmp_path, monkeypatch):
    with running(tmp_path / "r") as (simulation, _, files):
        steps(simulation, 3)
        files._try()
        monkeypatch.setattr(row_files.SignalSchema, "write_part", full(2))
        steps(simulation, 10)
        files._try()
        assert files.problem == (
            f"rows cannot be written to {tmp_path / 'r'} (No space left on device); those up to 0.2 s are in rows/"
        )
        assert len(in_parts(tmp_path / "r")) == 3
        monkeypatch.setattr(row_files.SignalSchema, "write_part", full(10**6))
        files.finish()  # pieces of four rows have room
        assert files.problem == ""
        assert pd.read_parquet(tmp_path / "r" / "signals.parquet").equals(simulation.frame())


def test_rows_that_cannot_be_written_for_some_time_end_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(row_files, "INTERVAL", 0.01)
    monkeypatch.setattr(row_files, "_PATIENCE", 0.05)
    monkeypatch.setattr(row_files.SignalSchema, "write_part", full(10**6))
    with running(tmp_path / "r") as (simulation, _, files):
        steps(simulation, 6)
        with files:
            deadline = time.monotonic() + 60
            while not simulation.log.halted and time.monotonic() < deadline:
                time.sleep(0.01)
        with pytest.raises(SimulationError) as error:
            simulation.step()
        assert str(error.value) == (
            f"tick 6 (t = 0.6 s): rows cannot be written to {tmp_path / 'r'} (No space left on device)"
        )


def test_a_part_that_somebody_removes_is_written_again(tmp_path):
    with running(tmp_path / "r") as (simulation, _, files):
        files._largest = 10
        steps(simulation, 35)
        files._try()
        (tmp_path / "r" / "rows" / "part-000002.parquet").unlink()
        files.finish()
        assert pd.read_parquet(tmp_path / "r" / "signals.parquet").equals(simulation.frame())


def test_of_a_folder_that_is_removed_the_rows_in_memory_are_in_a_new_one(tmp_path, monkeypatch):
    told = []
    for block, first in ((rows.BLOCK, 0), (2000, 10)):
        monkeypatch.setattr(rows, "BLOCK", block)
        monkeypatch.setattr(rows, "KEPT_BLOCKS", 2)
        with running(tmp_path / "r", begun=told.append) as (simulation, live, files):
            files._largest = 4
            steps(simulation, 40)
            files._try()
            simulation.log.drop(files._parts[-1].first, files._read)
            shutil.rmtree(tmp_path / "r")
            steps(simulation, 5)
            files.finish()
            there = told[-1]
            kept = pd.read_parquet(there / "signals.parquet")
            begin = simulation.log.in_memory_from
            assert (begin > first) == bool(first)
            assert np.rint(kept["time"] * 10).tolist() == list(range(begin, 45))
            gone = f"the rows before {begin * 0.1:g} s are gone: {there} has those that came later"
            assert files.problem == (gone if first else "")
            assert [*live.remarks()] == [
                f"{tmp_path / 'r'} was removed during the run: what could be saved of it is in {there}"
            ]
            assert (there / "system.ssp").is_file()


def test_system_files_that_are_removed_or_replaced_are_told(tmp_path):
    with running(tmp_path / "r") as (_, live, _files):
        assert [*live.remarks()] == []
        (tmp_path / "r" / "system.ssp").write_text("another")
        assert [*live.remarks()] == ["system.ssp is not the one that this run has written: something has replaced it"]
        (tmp_path / "r" / "system.ssp").unlink()
        assert [*live.remarks()] == ["system.ssp was removed during the run, and has been written again"]
        assert [*live.remarks()] == []
