"""What damaged files have shown, as small as it could be made: each was a traceback, a crash or a hang once.

Shows `door.py`, `asked_library.py`, `contents.py`, `parquet_tables.py` and `parquet_process.py`. What damaged run
folders have shown stands in `test_damaged_runs.py`.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.asked_library import readers_kept
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.system.contents import read_bytes
from orchestrator.system.files import read_toml
from orchestrator.system.parquet_tables import read_parquet
from tests.orchestrator.ssps import echo

DIGITS = "9" * 5000


@pytest.fixture
def fmu(tmp_path):
    return echo(tmp_path / "a.fmu", ["u"], ["k"])


def refused(action, *arguments, **options):
    with pytest.raises(RequestError) as error:
        action(*arguments, **options)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (f"a = 1\nb = {DIGITS}\n", ", line 2: found a value that cannot be read (ValueError: Exceeds the limit (4300"),
        (f"a = 0x{'f' * 5000}\n", ": a: found a number of 6021 digits; valid: whole numbers of up to 64 bits"),
        (f"[[t]]\nb = [1, {2**64}]\n", ": t.0.b.1: found a number of 20 digits; valid: whole numbers of up to 64 bits"),
        (f"a = 1\n{'b.' * 100_000}c = 1\n", ", line 2: found a key of more than 200 parts; valid: a TOML file"),
        (f"a = {'[' * 100_000}", ": found something that is nested too deeply (RecursionError: "),
    ],
)
def test_toml_that_is_too_long_or_too_deep(tmp_path, text, told):
    path = tmp_path / "a.toml"
    path.write_text(text)
    assert refused(read_toml, path).startswith(f"{path}{told}")


def test_devices_and_pipes_that_another_file_may_name(tmp_path):
    assert refused(read_toml, Path("/dev/zero")) == "/dev/zero: found a device; valid: a TOML file"
    os.mkfifo(tmp_path / "pipe")
    assert refused(read_toml, tmp_path / "pipe").endswith("pipe: found a pipe; valid: a TOML file")


def test_a_file_is_read_up_to_its_limit_and_no_further(tmp_path):
    (tmp_path / "a").write_bytes(b"x" * 2**20)
    assert len(read_bytes(tmp_path / "a", "a", "a file", 2**20)) == 2**20
    assert (
        refused(read_bytes, tmp_path / "a", "a", "a file", 2**19)
        == "a: found a file of more than 0.5 MiB; valid: a file"
    )
    assert refused(read_bytes, tmp_path / "a\0b", "a", "a file", 1).startswith("a: found a file that cannot be read (")


def test_a_value_with_very_many_signs(fmu):
    assert "found an unknown" in refused(load, str(fmu), Options(settings=[f"fmu.x={'=' * 300_000}"], stop_time=1.0))


def test_a_value_of_rows_of_different_lengths(fmu):
    told = refused(load, str(fmu), Options(settings=["fmu.k=[[1], [2, 3]]"], stop_time=1.0))
    assert told.startswith("fmu.k: found ")


def test_a_count_of_ticks_that_is_none():
    for count in (DIGITS, "\u0663", "-1"):
        assert "found text of another form" in refused(load, "idle", Options(mode="blocks", record=[f"*:{count}"]))


@pytest.mark.parametrize(("step", "stop"), [(5e-324, 1.0), (1e-300, 1e300), (0.1, 1e200)])
def test_times_that_no_counter_reaches(fmu, step, stop):
    told = refused(lambda: load(str(fmu), Options(step=step, stop_time=stop)).grid)
    assert re.fullmatch(
        r"stop time: found .* steps of .* s away; valid: at most 1e\+15 steps. Choose a longer step.", told
    )


def test_a_field_of_a_table_that_is_too_long(fmu, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(f"time,u\n0,1\n1,{'1' * 200_000}\n")
    assert refused(load, str(fmu), Options(stop_time=1.0, input=str(path))).startswith(
        f"{path}, line 3: found what is no CSV (field larger than field limit (131072)); valid: a table"
    )


def test_two_columns_of_one_name(tmp_path):
    pq.write_table(pa.Table.from_arrays([pa.array([1]), pa.array([2])], ["a", "a"]), tmp_path / "t.parquet")
    told = refused(read_parquet, tmp_path / "t.parquet", "t", "a table")
    assert told == "t: found two columns `a`; valid: a name of its own for each column"


def test_a_process_that_has_read_a_damaged_file_reads_the_next(tmp_path):
    pq.write_table(pa.table({"time": [0.0]}), tmp_path / "good.parquet")
    (tmp_path / "bad.parquet").write_bytes(b"PAR1")
    with readers_kept():
        for _ in range(2):
            assert refused(read_parquet, tmp_path / "bad.parquet", "t", "a table").startswith(
                "t: found a file that cannot"
            )
            assert read_parquet(tmp_path / "good.parquet", "t", "a table").num_rows == 1
