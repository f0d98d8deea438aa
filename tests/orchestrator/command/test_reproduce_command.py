"""`macrostep reproduce` as a person types it."""

from __future__ import annotations

import pytest

from orchestrator.command import main
from orchestrator.reproduction import reproduce as reproduction
from orchestrator.reproduction.paper.verdict import Case, Verdict
from orchestrator.reproduction.reproduce import Reproduced


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--varied", "-3"), "--varied: found -3; valid: a whole number of cases, 1 or more"),
        (("--varied", "3", "--seed", "-1"), "--seed: found -1; valid: a whole number, 0 or more"),
    ],
)
def test_a_wrong_request_is_refused_before_anything_is_written(macrostep, in_tmp_path, arguments, message):
    code, _, err = macrostep("reproduce", *arguments)
    assert code == main.WRONG
    assert err == f"macrostep: {message}\n"
    assert list(in_tmp_path.iterdir()) == []


def test_a_folder_with_other_things_in_it_is_refused(macrostep, in_tmp_path):
    (in_tmp_path / "mine").mkdir()
    (in_tmp_path / "mine" / "letter.txt").touch()
    code, _, err = macrostep("reproduce", "--out", "mine")
    assert code == main.WRONG
    assert "mine: found a folder with other things in it" in err
    assert (in_tmp_path / "mine" / "letter.txt").is_file()


def test_the_verdicts_are_told(macrostep, monkeypatch):
    holds = {"linear": True, "saturating": False}
    cases = tuple(Case({"tyre": tyre}, said, {}, ()) for tyre, said in holds.items())
    verdicts = (Verdict("C1", "it is smooth", "metrics", cases),)
    monkeypatch.setattr(reproduction, "reproduce", lambda _, folder, *__: Reproduced(folder, verdicts))
    code, out, _ = macrostep("reproduce", "--out", "here")
    assert code == 0
    assert "C1 it is smooth: holds on linear tyres (1 of 2 cases)\n" in out
    assert "here/  report.html" in out
