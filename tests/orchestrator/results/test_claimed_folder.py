"""Folders for results: who writes to one, and what is removed from it, as its manifest says (`manifest.py`)."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from components.interfaces.problem import RequestError
from orchestrator.pictures import figures
from orchestrator.results.claimed_folder import claim, reclaim
from orchestrator.results.manifest import Contents
from orchestrator.results.run_folder import PICTURES, RUN

VALID = "a folder that is new, empty or a former run, in a place that can be written to"
REMEDY = "Choose another folder with --out."


def former(folder: Path) -> Path:
    """The folder of a former run."""
    with claim("", folder, RUN):
        for name in ("summary.json", "system.ssp", "signals.parquet", "rows/part-000001.parquet", "figures/speed.png"):
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text("former")
    return folder


def found(folder: Path) -> str:
    with pytest.raises(RequestError) as error:
        claim("", folder, RUN)
    return str(error.value)


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


def test_of_a_former_run_only_what_it_wrote_is_removed(tmp_path):
    folder = former(tmp_path / "r")
    for name in ("notes.txt", ".git/HEAD", "figures/mine.png", "rows/mine.parquet", "model.py"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("mine")
    with claim("", folder, RUN) as claimed:
        kept = ["figures/mine.png", "model.py", "notes.txt", "rows/mine.parquet"]
        assert [n for n in names(folder) if (folder / n).is_file() and "/HEAD" not in n] == [
            ".lock",
            *kept[:1],
            "manifest.json",
            *kept[1:],
        ]
        assert (folder / ".git" / "HEAD").read_text() == "mine"
        assert claimed.remarks == [
            f"{folder}: what else was in this folder stays: .git, figures, model.py, notes.txt, rows"
        ]


def test_a_folder_without_a_manifest_is_refused_and_nothing_in_it_is_touched(tmp_path):
    (tmp_path / "system.ssp").write_text("mine")
    what = "a folder with files of which no manifest.json says that a run wrote them"
    assert found(tmp_path) == f"{tmp_path}: found {what}; valid: {VALID}. {REMEDY}"
    assert names(tmp_path) == ["system.ssp"]
    (tmp_path / "system.ssp").rename(tmp_path / "thesis.tex")
    assert found(tmp_path) == f"{tmp_path}: found a folder with other things in it; valid: {VALID}. {REMEDY}"
    assert names(tmp_path) == ["thesis.tex"]


@pytest.mark.parametrize(
    "manifest",
    [
        json.dumps({"holds": "run", "files": ["notes.txt", "../x", "/etc/passwd", "figures/*", "*", 5, None]}),
        json.dumps({"holds": "run", "files": []}),
    ],
)
def test_a_manifest_from_a_stranger_removes_nothing(tmp_path, manifest):
    folder, outside = tmp_path / "r", tmp_path / "x"
    (folder / "figures").mkdir(parents=True)
    for path in (outside, folder / "notes.txt", folder / "figures" / "speed.png"):
        path.write_text("mine")
    (folder / "manifest.json").write_text(manifest)
    valid = "nothing there but what a former run wrote"
    assert found(folder) == (
        f"{folder / 'figures' / 'speed.png'}: found a file that is not in its manifest; valid: {valid}."
        " Move it away, or choose another folder with --out."
    )
    assert [p.read_text() for p in (outside, folder / "notes.txt", folder / "figures" / "speed.png")] == ["mine"] * 3


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 5000, '{"holds": "run"}', '{"holds": "report", "files": []}'])
def test_what_is_no_manifest_is_none(tmp_path, text):
    (tmp_path / "manifest.json").write_text(text)
    assert "found a folder with other things in it" in found(tmp_path)


@pytest.mark.parametrize("name", ["recording.rrd", "figures", "rows", "signals.parquet"])
@pytest.mark.parametrize("kind", ["link", "dangling", "folder"])
def test_what_is_in_the_way_is_refused_and_links_are_not_followed(tmp_path, name, kind):
    folder, elsewhere = former(tmp_path / "r"), tmp_path / "elsewhere"
    for path in [*(folder / "figures").glob("*"), *(folder / "rows").glob("*")]:
        path.unlink()
    for path in (folder / "figures", folder / "rows"):
        path.rmdir()
    (folder / name).unlink(missing_ok=True)
    if kind == "link":
        elsewhere.mkdir()
        (elsewhere / "speed.png").write_text("mine")
        (elsewhere / "part-1.parquet").write_text("mine")
    if kind == "folder":
        if name in {"figures", "rows"}:
            pytest.skip("is a folder of the run")
        (folder / name).mkdir()
    else:
        (folder / name).symlink_to(elsewhere)
    assert f"{folder / name}: found a {kind.replace('dangling', 'link')}; valid: nothing there but" in found(folder)
    assert (folder / "summary.json").read_text() == "former", "nothing is removed where something is in the way"
    assert kind != "link" or [p.read_text() for p in elsewhere.iterdir()] == ["mine", "mine"]


def test_a_folder_is_written_by_one_process_at_a_time(tmp_path):
    script = f"""
from pathlib import Path
from orchestrator.pictures import figures
from orchestrator.results.claimed_folder import claim
from orchestrator.results.run_folder import RUN
with claim("", Path({str(tmp_path / "r")!r}), RUN):
    print("there", flush=True)
    input()
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "there\n"
    assert found(tmp_path / "r") == (
        f"{tmp_path / 'r'}: found a folder that process {process.pid} is writing to; valid: {VALID}."
        " Wait for it, or choose another folder with --out."
    )
    with pytest.raises(RequestError, match=f"process {process.pid} is writing to"):
        reclaim(tmp_path / "r", RUN)
    process.kill()
    process.communicate()
    with claim("", tmp_path / "r", RUN):  # a lock ends with its process
        assert f"found a folder that this process ({os.getpid()}) is writing to" in found(tmp_path / "r")


def test_many_threads_that_want_the_next_folder_get_one_each(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs" / "static-7").mkdir(parents=True)
    (tmp_path / "runs" / "static-²").touch()

    def one(_):
        with claim("static", None, RUN) as claimed:
            return str(claimed.named)

    with ThreadPoolExecutor(8) as pool:
        got = list(pool.map(one, range(40)))
    assert sorted(got) == sorted(f"runs/static-{i}" for i in range(8, 48))


def test_of_many_threads_that_want_one_folder_one_gets_it(tmp_path):
    def one(_):
        try:
            return claim("", tmp_path / "r", RUN)
        except RequestError:
            return None

    with ThreadPoolExecutor(8) as pool:
        (only,) = [claimed for claimed in pool.map(one, range(40)) if claimed is not None]
    only.release()


def test_a_file_and_a_place_that_cannot_be_written_to_are_refused(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    assert f"{tmp_path / 'file'}: found a file; valid: {VALID}" in found(tmp_path / "file")
    assert f"{tmp_path / 'link'}: found a link that leads nowhere; valid" in found(tmp_path / "link")
    assert "found a folder that cannot be written to (Not a directory)" in found(tmp_path / "file" / "r")


def test_a_folder_that_is_moved_is_followed_and_one_that_is_removed_is_replaced(tmp_path):
    with claim("", tmp_path / "r", RUN) as claimed:
        assert claimed.follow()
        (tmp_path / "r").rename(tmp_path / "s")
        assert claimed.follow()
        assert (claimed.path, claimed.remarks) == (
            tmp_path / "s",
            [f"{tmp_path / 'r'} was moved during the run: it is {tmp_path / 's'} now"],
        )
        for path in (tmp_path / "s").iterdir():
            path.unlink()
        (tmp_path / "s").rmdir()
        (tmp_path / "s").mkdir()  # somebody else's
        assert not claimed.follow()
        assert claimed.path == tmp_path / "s-rescued-1"
        assert claimed.remarks[1:] == [
            f"{tmp_path / 's'} was removed during the run: what could be saved of it is in {tmp_path / 's-rescued-1'}"
        ]
        assert names(tmp_path / "s") == []
        assert "is writing to" in found(tmp_path / "s-rescued-1")


def test_a_folder_that_is_not_needed_after_all_is_gone(tmp_path):
    claimed = claim("", tmp_path / "r", RUN)
    (tmp_path / "r" / "system.ssp").touch()
    claimed.abandon()
    assert names(tmp_path) == []


def test_what_a_run_writes_lies_one_folder_deep_at_most_and_has_all_figures():
    assert RUN.folders == {"rows", "figures"}
    assert Contents("x", ("a", "b/c", "b/*")).folders == {"b"}
    assert set(PICTURES) == {"trajectory", "path_error", *(name for name, *_ in figures._SERIES_FILES)}
