"""Runs as they are kept: found, or refused."""

from __future__ import annotations

import pytest

from components.interfaces.problem import Problem, RequestError
from orchestrator.results import run_folder


def _problem(request):
    found = run_folder.find(request)
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


def test_a_recording_on_its_own_has_no_system(whole, tmp_path):
    path = tmp_path / "alone.rrd"
    path.write_bytes((whole / "recording.rrd").read_bytes())
    run = run_folder.find(path)
    assert run.folder is None
    with pytest.raises(RequestError, match="found a recording on its own; valid: a run folder"):
        _ = run.scenario
    assert run_folder.find(whole / "recording.rrd").folder == whole


def test_a_summary_that_was_not_written_is_empty(run):
    assert run_folder.find(run).summary == {}


@pytest.mark.parametrize(
    ("content", "damage"),
    [
        ("", ", line 1: text that is no JSON (Expecting value)"),
        ("[]", ": another JSON"),
        ('"text"', ": another JSON"),
        ('{\n"a"', ", line 2: text that is no JSON (Expecting ':' delimiter)"),
        ('{"status": "finished"}', ": scenario, title, units, versions"),
    ],
)
def test_what_is_damaged_in_a_summary_is_named(run, content, damage):
    (run / "summary.json").write_text(content)
    assert run_folder.find(run).summary["damaged"] == f"summary.json{damage}"
