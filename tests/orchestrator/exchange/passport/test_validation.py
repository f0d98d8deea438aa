"""The rules of FMI, by three readers."""

from __future__ import annotations

from orchestrator.exchange.check import opened
from orchestrator.exchange.passport import validation
from orchestrator.system.source import Fmu
from tests.fmus.foreign import copied, entries
from tests.orchestrator.exchange.passport.measured_fmus import lag, told


def found(path):
    return told(validation.lines(path, opened(Fmu(path))[1]))


def test_an_fmu_that_keeps_the_rules_passes(tmp_path):
    assert found(lag(tmp_path)) == {
        "rules.macrostep": ("passes", "yes"),
        "rules.fmpy": ("passes", "0 problems"),
        "rules.fmutool": ("passes", "0 remarks"),
    }


def test_what_breaks_them_is_told_by_each_reader_without_folders(tmp_path):
    path = lag(tmp_path)
    text = entries(path)["modelDescription.xml"].replace(b'causality="output"', b'causality="output" initial="exact"')
    lines = found(copied(path, tmp_path / "odd.fmu", {"modelDescription.xml": text}))
    assert {mark for mark, _ in lines.values()} == {"fails"}
    assert lines["rules.macrostep"][1].startswith("odd.fmu, modelDescription.xml, line ")
    assert not any(str(tmp_path) in evidence for _, evidence in lines.values())


def test_a_file_that_is_no_archive_is_told_by_each_reader(tmp_path):
    path = tmp_path / "bad.fmu"
    path.write_text("no archive")
    lines = told(validation.lines(path, []))
    assert lines["rules.fmpy"][0] == "fails"
    assert lines["rules.fmutool"][0] == "fails"
    assert "it gives up: " in lines["rules.fmutool"][1]
