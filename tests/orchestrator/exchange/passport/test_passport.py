"""Whole passports: of our own FMUs, of Model Exchange, and of wrong ones; this also shows `passport_line.py`."""

from __future__ import annotations

import json

import pytest

from components.interfaces.problem import RequestError
from orchestrator.exchange.passport.passport import SCHEMA, passport
from orchestrator.exchange.passport.passport_line import GROUPS, Measured, Topic
from tests.fmus.model_exchange_models import built_models
from tests.orchestrator import foreign
from tests.orchestrator.exchange.passport.measured_fmus import RANGE, lag


class Reports:
    """Gathers what is going on."""

    def __init__(self):
        self.texts = []

    def now(self, text):
        self.texts.append(text)

    done = now


def marks(made):
    return {line.key: str(line.mark) for line in made.lines}


def not_passing(made):
    return {key: mark for key, mark in marks(made).items() if mark != "passes"}


NO_DRIVE = {"drive.finishes": "does not apply", "drive.beside": "does not apply"}
NO_STEP = dict.fromkeys(("dynamics.convergence", "dynamics.own_step", "dynamics.macro_step"), "does not apply")
NO_TESTS = {"smoke.carried": "does not apply"}
NO_SOCKET = {"fit.sockets": "does not apply"} | NO_DRIVE | NO_TESTS


def test_an_fmu_that_is_right_passes_all_that_applies(tmp_path):
    reports = Reports()
    made = passport(lag(tmp_path, u=RANGE), reports)
    assert made.good
    assert not_passing(made) == NO_SOCKET
    assert len(marks(made)) == len(made.lines) == 28
    assert [g for g in GROUPS if g in {line.group for line in made.lines}] == list(
        dict.fromkeys(ln.group for ln in made.lines)
    )
    assert reports.texts[0] == "checking the rules of FMI"
    assert len(reports.texts) > 8


def test_the_data_say_all_of_it_without_a_folder_of_this_machine(tmp_path):
    data = passport(lag(tmp_path)).data()
    text = json.dumps(data, allow_nan=False)
    assert "/" + str(tmp_path).split("/")[1] not in text.replace("1/", "")
    assert data["schema"] == SCHEMA
    assert (data["file"], data["passes"]) == ("m.fmu", True)
    assert data["counts"]["fails"] == 0
    assert set(data["lines"][0]) == {"key", "group", "title", "mark", "evidence", "figures", "details"}
    time = next(line for line in data["lines"] if line["key"] == "cost.time")
    assert set(time["figures"]) == {"median", "p99", "longest", "speed"}
    assert time["figures"]["median"]["unit"] == "us"
    assert data["provenance"]["versions"]["macrostep"]
    assert set(data["provenance"]["machine"]) == {"platform", "system", "processor", "cores"}
    assert data["provenance"]["duration"]["unit"] == "s"


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["fmi2", "fmi3"])
def test_our_own_plant_passes_and_drives(built_fmus, folder):
    made = passport(built_fmus / folder / "bicycle.fmu")
    assert not_passing(made) == NO_TESTS
    assert len(made.pictures) == 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mpc", "ramp_traffic"])
def test_our_own_controller_and_traffic_pass(built_fmus, name):
    made = passport(built_fmus / "fmi3" / f"{name}.fmu")
    expected = NO_DRIVE | NO_TESTS | (NO_STEP if name == "mpc" else {})
    assert {key: mark for key, mark in not_passing(made).items() if key != "faults.limits"} == expected


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_model_exchange_has_a_passport(version):
    made = passport(built_models()["stiff", version])
    assert made.identity["measured_as"] == "Model Exchange"
    assert not_passing(made) == NO_SOCKET | {
        "state.restored": "does not apply",
        "state.serialized": "does not apply",
        "faults.limits": "does not apply",
    }


@pytest.mark.slow
def test_model_exchange_with_events_that_never_end_is_told_where_it_stands():
    made = passport(built_models()["ball", 2])
    reasons = {line.key: line.evidence for line in made.lines if line.mark == "fails"}
    text = "more than 1000 events from 2.5 s to 2.55809 s: they may never end"
    assert reasons["determinism.processes"] == f"{text} (driving one instance)"
    assert reasons["dynamics.own_step"] == f"with 0.1 s: {text}"


def test_a_mapped_plant_is_measured_and_driven_by_its_mapping(tmp_path):
    path = foreign.right_handed_mapping(tmp_path)
    path.write_text(f'socket = "plant"\n{path.read_text()}')
    made = passport(path)
    assert made.identity["file"] == "theirs.fmu"
    found = marks(made)
    assert (found["fit.sockets"], found["drive.finishes"], found["drive.beside"]) == ("passes", "passes", "passes")


def test_an_fmu_that_does_not_start_has_a_passport_all_the_same(tmp_path):
    made = passport(lag(tmp_path, "#define STEP abort();"))
    assert not made.good
    assert [key for key, mark in marks(made).items() if mark == "fails"] == ["library.first_step"]
    why = "it does not run here: see the lines about its library"
    assert {line.evidence for line in made.lines if line.group in ("determinism", "cost", "dynamics")} == {why}
    assert marks(made)["declared.starts"] == "passes"


def test_an_fmu_that_goes_down_on_the_way_is_measured_as_far_as_it_goes(tmp_path):
    made = passport(lag(tmp_path, "#define STEP if (i->n > 60) abort();"))
    found = marks(made)
    assert found["library.first_step"] == "passes"
    assert found["determinism.processes"] == "fails"
    assert found["state.reset"] == "does not apply"
    assert found["feedthrough.declared"] == "passes"
    assert found["cost.time"] == "fails"


def test_a_file_that_is_no_fmu_fails_its_rules(tmp_path):
    (tmp_path / "bad.fmu").write_text("no archive")
    made = passport(tmp_path / "bad.fmu")
    found = marks(made)
    assert {key for key, mark in found.items() if mark == "fails"} == {
        "rules.macrostep",
        "rules.fmpy",
        "rules.fmutool",
    }
    assert made.identity["size"] == 10


def test_an_fmu_that_breaks_rules_is_measured_all_the_same(tmp_path):
    made = passport(lag(tmp_path, u='unit="knots" start="1"'))
    found = marks(made)
    assert found["rules.macrostep"] == "fails"
    assert found["determinism.processes"] == "passes"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("gone.fmu", "gone.fmu: found no such file; valid: an .fmu, or the .toml that maps one"),
        ("notes.txt", "notes.txt: found a file ending in `.txt`; valid: an .fmu, or the .toml that maps one"),
    ],
)
def test_other_files_are_refused(in_tmp_path, name, text):
    (in_tmp_path / "notes.txt").write_text("x")
    with pytest.raises(RequestError) as error:
        passport((in_tmp_path / name).relative_to(in_tmp_path))
    assert str(error.value) == text


def test_a_line_counts_what_it_does_not_name():
    topic = Topic("rules.some", "Something")
    line = topic.judged(["a", "b", "c", "d", "e"], "fine", {"n": Measured(5, "1")})
    assert (line.group, str(line.mark), line.evidence) == ("rules", "fails", "a; b; c; and 2 more")
    assert line.details == ("a", "b", "c", "d", "e")
    assert topic.judged([], "fine").evidence == "fine"
