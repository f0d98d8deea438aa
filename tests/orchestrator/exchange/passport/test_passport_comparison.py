"""Two passports side by side."""

from __future__ import annotations

import copy
import json

import pytest

from components.interfaces.problem import RequestError
from orchestrator.exchange.passport.passport_comparison import Change, compared_with, read_passport

LINES = [
    ("rules.fmpy", "passes", {}),
    ("state.reset", "fails", {}),
    ("cost.time", "passes", {"median": {"value": 10.0, "unit": "us"}, "speed": {"value": 2.0, "unit": "1"}}),
    ("state.restored", "does not apply", {}),
]


@pytest.fixture
def before():
    return {
        "schema": 1,
        "file": "m.fmu",
        "identity": {"file": "m.fmu", "tool": "one", "size": 10},
        "lines": [{"key": k, "title": k, "mark": m, "evidence": f"of {k}", "figures": f} for k, m, f in LINES],
        "provenance": {"made": "today"},
    }


def changed(content, **marks):
    after = copy.deepcopy(content)
    for line in after["lines"]:
        line["mark"] = marks.get(line["key"].replace(".", "_"), line["mark"])
    return after


def test_the_same_passport_has_no_changes(before):
    found = compared_with(before, before)
    assert found.good
    assert (found.lines, found.figures, found.facts) == ((), (), ())
    assert (found.file, found.made) == ("m.fmu", "today")


def test_what_fails_now_is_worse_and_comes_first(before):
    found = compared_with(before, changed(before, rules_fmpy="fails", state_reset="passes", state_restored="fails"))
    assert not found.good
    assert [(line.key, line.change, line.before, line.after) for line in found.lines] == [
        ("rules.fmpy", Change.WORSE, "passes", "fails"),
        ("state.restored", Change.WORSE, "does not apply", "fails"),
        ("state.reset", Change.BETTER, "fails", "passes"),
    ]
    assert found.lines[0].evidence == "of rules.fmpy"


def test_what_no_longer_applies_is_neither(before):
    found = compared_with(before, changed(before, rules_fmpy="does not apply"))
    assert found.good
    assert [line.change for line in found.lines] == [Change.OTHER]


def test_lines_that_come_and_go_are_told(before):
    after = copy.deepcopy(before)
    gone = after["lines"].pop(0)
    after["lines"].append({**gone, "key": "smoke.test_new", "mark": "fails"})
    found = compared_with(before, after)
    assert [(line.key, line.before, line.after, line.change) for line in found.lines] == [
        ("smoke.test_new", "not there", "fails", Change.WORSE),
        ("rules.fmpy", "passes", "not there", Change.OTHER),
    ]


def test_figures_and_facts_that_differ_are_told_with_their_units(before):
    after = copy.deepcopy(before)
    after["lines"][2]["figures"]["median"]["value"] = 12.0
    after["lines"][2]["figures"]["speed"]["value"] = 2.1
    after["identity"] |= {"tool": "two", "size": None}
    found = compared_with(before, after)
    assert found.figures == (("cost.time", "median", "10 us", "12 us"),)
    assert found.facts == (("made with", "one", "two"), ("size", "10 bytes", "not told"))
    assert json.loads(json.dumps(found.data()))["figures"] == [
        {"line": "cost.time", "name": "median", "before": "10 us", "after": "12 us"}
    ]


DEEP = (
    "something that is nested too deeply (RecursionError: maximum recursion depth exceeded while decoding a JSON array"
    " from a unicode string)"
)
LONG = (
    "something that cannot be read (ValueError: Exceeds the limit (4300 digits) for integer string conversion: value"
    " has 5000 digits; use sys.set_int_max_str_digits() to increase the limit)"
)


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (None, "no such file"),
        ("[1]", "another JSON"),
        ('{"schema": 0, "lines": [], "identity": {}, "file": "m"}', "schema 0"),
        ("[" * 100_000, DEEP),
        (f"[{'9' * 5000}]", LONG),
    ],
)
def test_files_that_are_no_passport_are_refused(tmp_path, content, found):
    path = tmp_path / "p.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(RequestError) as error:
        read_passport(path)
    assert str(error.value).startswith(f"--against {path}: found {found}; valid: ")


def test_what_is_damaged_in_a_passport_is_told_with_its_place(tmp_path, before):
    path = tmp_path / "p.json"
    before["lines"][0]["figures"] = {"speed": {"value": "fast", "unit": "1"}}
    before["identity"]["variables"] = [3]
    del before["lines"][1]["mark"]
    path.write_text(json.dumps({**before, "schema": 1}))
    with pytest.raises(RequestError) as error:
        read_passport(path)
    assert str(error.value).splitlines() == [
        f"--against {path}: lines.0.figures.speed.value: found `fast`; valid: a valid number",
        f"--against {path}: lines.1.mark: found nothing; valid: an entry of this name",
        f"--against {path}: identity.variables: found `[3]`; valid: a valid dictionary",
    ]
    path.write_text('{"schema": 1,\n')
    with pytest.raises(RequestError, match=f"{path}, line 2: found text that is no JSON"):
        read_passport(path)
