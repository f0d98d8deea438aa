"""Building: what is refused, what is built again, and what the compiler says.

Shows, of `fmus/export`, `build.py`, `compilation.py` and `fingerprint.py`; and `fmus/toolchain/compiler.py`.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any
from unittest.mock import Mock, call

import pytest

from components import BLOCKS
from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from fmus.export import compilation, fingerprint
from fmus.export.build import BuildError, build, build_all
from fmus.toolchain import compiler
from fmus.toolchain.version import WRITTEN_VERSIONS, Version

Start = Callable[[str], dict[str, Any]]
STATIONARY = BLOCKS["stationary"]


@pytest.fixture
def no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)


@pytest.fixture
def fresh_digest() -> Iterator[None]:
    """The digest of the sources is read once per process; this test needs it read anew."""
    fingerprint.package_digest.cache_clear()
    yield
    fingerprint.package_digest.cache_clear()


def stationary(start_of: Start, **changes: float) -> dict[str, Any]:
    return {**start_of("stationary"), **changes}


def test_path_names_version_and_block(start_of: Start, tmp_path: Path) -> None:
    built = build(STATIONARY, Version.FMI3, stationary(start_of), tmp_path)
    assert built.path == tmp_path / "fmi3" / "stationary.fmu"
    assert built.rebuilt


def test_not_built_again_when_nothing_changed(start_of: Start, tmp_path: Path) -> None:
    first = build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)
    written = first.path.stat().st_mtime_ns
    again = build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)
    assert not again.rebuilt
    assert again.path.stat().st_mtime_ns == written


def test_built_again_when_a_start_value_changed(start_of: Start, tmp_path: Path) -> None:
    first = build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path).path.read_bytes()
    again = build(STATIONARY, Version.FMI2, stationary(start_of, x_start=5.5), tmp_path)
    assert again.rebuilt
    assert again.path.read_bytes() != first


@pytest.mark.usefixtures("fresh_digest")
def test_built_again_when_a_source_changed(start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)
    monkeypatch.setattr(fingerprint, "tool_version", lambda: "another")
    fingerprint.package_digest.cache_clear()
    assert build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path).rebuilt


def test_built_again_when_the_file_is_damaged(start_of: Start, tmp_path: Path) -> None:
    path = build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path).path
    path.write_bytes(path.read_bytes()[:1000])
    assert build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path).rebuilt


def test_token_depends_on_start_values_only(start_of: Start, tmp_path: Path) -> None:
    def token(name: str, **changes: float) -> bytes:
        path = build(STATIONARY, Version.FMI2, stationary(start_of, **changes), tmp_path / name).path
        with zipfile.ZipFile(path) as archive:
            return archive.read("modelDescription.xml").partition(b'guid="')[2].partition(b'"')[0]

    assert token("a") == token("b")
    assert token("c", x_start=7.25) != token("a")


def test_progress_hears_of_what_is_built(start_of: Start, tmp_path: Path) -> None:
    progress = Mock()
    requests = [(STATIONARY, version, stationary(start_of)) for version in WRITTEN_VERSIONS]
    build_all(requests[:1], tmp_path, progress)
    build_all(requests, tmp_path, progress)
    assert progress.mock_calls == [call.done("built stationary for FMI 2.0"), call.done("built stationary for FMI 3.0")]


def test_nothing_but_the_fmu_is_left_behind(start_of: Start, tmp_path: Path) -> None:
    build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == ["stationary.fmu"]


def test_wrong_start_values_are_all_named(start_of: Start, tmp_path: Path) -> None:
    values = {**start_of("bicycle"), "m": 0.0, "mue": 0.5, "v_x_start": "fast"}
    del values["g"]
    with pytest.raises(RequestError) as raised:
        build(BLOCKS["bicycle"], Version.FMI2, values, tmp_path)
    names = ", ".join(sorted(v.name for v in BLOCKS["bicycle"].parameters()))
    assert str(raised.value).splitlines() == [
        "bicycle.g: found no value; valid: 0.1 <= finite number [m/s2]. "
        "Parameters have no default: give it a start value.",
        "bicycle.m: found 0.0; valid: 1 <= finite number [kg]",
        "bicycle.v_x_start: found `fast` (not a number); valid: 0 <= finite number [m/s]",
        f"bicycle.mue: found an unknown parameter; valid: {names}. Did you mean `mu`?",
    ]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("no_compiler")
def test_no_compiler_is_said_before_anything_is_generated(start_of: Start, tmp_path: Path) -> None:
    with pytest.raises(RequestError) as raised:
        build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path / "built")
    assert str(raised.value) == (
        "building FMUs: found no C compiler; valid: cc, gcc or clang on the PATH, or CC naming one. "
        "Install gcc or clang (Debian: apt-get install gcc), "
        "or run blocks in this process: macrostep run SCENARIO --blocks."
    )
    assert list(tmp_path.iterdir()) == []


def test_cc_that_cannot_be_run(start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler -m64")
    with pytest.raises(RequestError, match="found CC=no-such-compiler -m64, which cannot be run; valid: cc, gcc"):
        build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)


def test_cc_is_used(start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = compiler.required_compiler()
    script = tmp_path / "my-cc"
    script.write_text(f'#!/bin/sh\necho used >> {tmp_path}/log\nexec {found.command[0]} "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path / "built")
    assert (tmp_path / "log").exists()


def test_up_to_date_fmus_need_no_compiler(start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path / "built")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert not build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path / "built").rebuilt


def test_compile_error_shows_what_the_compiler_says(
    start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-fno-such-flag"))
    with pytest.raises(BuildError, match=r"failed \(1\) on .*-fno-such-flag.*:\n.*no-such-flag"):
        build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == []


def test_link_error_shows_what_the_linker_says(
    start_of: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def only_the_shim(_version: Version) -> tuple[str, ...]:
        return ("fmi2.c",)

    monkeypatch.setattr(compilation, "runtime_files", only_the_shim)
    with pytest.raises(BuildError, match="undefined reference to `core_"):
        build(STATIONARY, Version.FMI2, stationary(start_of), tmp_path)


@pytest.mark.skipif(os.name != "posix", reason="/dev/null is no folder")
def test_folder_that_cannot_be_written_to(start_of: Start) -> None:
    with pytest.raises(RequestError) as raised:
        build(STATIONARY, Version.FMI2, stationary(start_of), Path("/dev/null"))
    assert str(raised.value) == (
        "/dev/null/fmi2: found a folder that cannot be written to (Not a directory); valid: a writable folder. "
        "Name another one."
    )


def test_the_same_request_twice_is_one(start_of: Start, tmp_path: Path) -> None:
    request = (STATIONARY, Version.FMI2, stationary(start_of))
    progress = Mock()
    first, second = build_all([request, request], tmp_path, progress)
    assert first == second
    assert len(progress.mock_calls) == 1


def test_two_sets_of_start_values_for_one_file_are_refused(start_of: Start, tmp_path: Path) -> None:
    requests = [(STATIONARY, Version.FMI2, stationary(start_of, x_start=x)) for x in (1.0, 2.0)]
    with pytest.raises(RequestError) as raised:
        build_all(requests, tmp_path, SILENT)
    assert str(raised.value) == (
        f"{tmp_path / 'fmi2' / 'stationary.fmu'}: found two requests with different start values; "
        "valid: one set of start values for a file. Build one, and set the other's parameters when it is used."
    )


def test_a_block_that_calls_a_library_is_refused(tmp_path):
    with pytest.raises(RequestError, match="block `mpc_sqp`: found equations that call a library"):
        build(BLOCKS["mpc_sqp"], Version.FMI2, {}, tmp_path)


def test_no_source_is_written_once_a_compiler_may_read_it(tmp_path):
    """A compiler that reads a file that another version's copy is just being written to makes an empty object of it."""
    seen = []

    class Looking:
        def compile(self, source, folder):
            seen.append({path.name: path.stat().st_mtime_ns for path in folder.iterdir()})
            return source

    class AtOnce(Executor):
        def submit(self, fn, /, *arguments):
            future = Future()
            future.set_result(fn(*arguments))
            return future

    compilation.Compilation(tmp_path, Looking(), AtOnce(), WRITTEN_VERSIONS)
    assert {"fmi2.c", "fmi3.c", "core.c"} <= seen[0].keys()
    assert all(files == seen[0] for files in seen)
