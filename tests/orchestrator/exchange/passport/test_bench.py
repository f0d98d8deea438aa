"""Measurements in processes of their own: what an FMU does to its process does no harm to the others.

This also shows `workplace.py` and `measuring_process.py`.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from orchestrator.exchange.passport.bench import MeasurementError
from orchestrator.exchange.passport.loading_here import first_step, instantiate
from tests.orchestrator.exchange.passport.measured_fmus import lag, on_the_bench
from tests.waiting import wait_until


def number_of_this_process(place):
    return os.getpid()


def write_a_file(place):
    Path("litter.txt").write_text("x")
    return str(Path.cwd())


def say_and_end(place, code):
    place.tell("going down")
    os._exit(code)


def test_each_measurement_has_a_process_of_its_own(tmp_path):
    with on_the_bench(lag(tmp_path)) as bench:
        numbers = {os.getpid(), *(bench.measure(number_of_this_process) for _ in range(3))}
    assert len(numbers) == 4


def test_what_is_written_to_the_working_folder_goes_with_the_bench(in_tmp_path):
    with on_the_bench(lag(in_tmp_path)) as bench:
        folder = Path(bench.measure(write_a_file))
        assert (folder / "litter.txt").is_file()
    assert not folder.exists()
    assert [p.name for p in in_tmp_path.iterdir()] == ["m.fmu"]


@pytest.mark.parametrize(
    ("macros", "reason"),
    [
        ("#define STEP *(volatile int *)8 = 1;", "its process died (SIGSEGV) (its first step)"),
        ("#define STEP abort();", "its process died (SIGABRT) (its first step)"),
        ("#define STEP exit(3);", "its process died (exit code 3) (its first step)"),
        ("#define STEP for (;;);", "it hung: no answer within 1 s (its first step)"),
        ("#define ON_SET for (;;);", "it hung: no answer within 1 s (initialising)"),
        ("#define STEP return fmi2Fatal;", "a step at 0 s: a fatal error (its first step)"),
    ],
)
def test_an_fmu_that_fails_is_told_with_its_stage_and_the_next_measurement_goes_on(tmp_path, macros, reason):
    with on_the_bench(lag(tmp_path, macros), patience=1.0) as bench:
        with pytest.raises(MeasurementError) as error:
            bench.measure(first_step, 0.1)
        assert str(error.value) == reason
        assert bench.measure(instantiate) > 0


def test_an_fmu_that_hangs_leaves_no_process_behind(tmp_path):
    with on_the_bench(lag(tmp_path, "#define STEP for (;;);"), patience=5.0) as bench:
        number = bench.measure(number_of_this_process)
        with pytest.raises(MeasurementError):
            bench.measure(first_step, 0.1)
        group = os.getpgid(0)
    assert group
    assert number
    wait_until(lambda: not [p for p in measuring() if _environment(p, str(bench._folder))])


def measuring():
    return [p for p in Path("/proc").glob("[0-9]*/cmdline") if b"measuring_process" in _content(p)]


def _content(path):
    try:
        return path.read_bytes()
    except OSError:
        return b""


def _environment(path, folder):
    return folder.encode() in _content(path.with_name("environ"))


def test_the_stage_is_told_with_a_death(tmp_path):
    with on_the_bench(lag(tmp_path)) as bench, pytest.raises(MeasurementError) as error:
        bench.measure(say_and_end, 5)
    assert (error.value.reason, error.value.stage) == ("its process died (exit code 5)", "going down")


def test_a_reason_names_no_folder_of_this_machine_and_is_bounded(tmp_path):
    text = f"{tmp_path}{os.sep}m.fmu and macrostep_x1y2{os.sep}binaries, " + "word " * 200
    with on_the_bench(lag(tmp_path)) as bench:
        plain = bench._plain(text)
    assert plain.startswith("m.fmu and binaries, word word")
    assert len(plain) < 420
