"""What an FMU says that it is."""

from __future__ import annotations

import hashlib

from orchestrator.exchange.passport.identity import fact_text, facts, file_facts, shown
from orchestrator.system.source import Fmu
from tests.fmus.model_exchange_models import built_models
from tests.orchestrator.exchange.passport.measured_fmus import lag


def test_the_file_is_told_by_its_name_size_and_hash(tmp_path):
    path = lag(tmp_path)
    content = path.read_bytes()
    assert file_facts(path) == {
        "file": "m.fmu",
        "size": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
    }


def test_the_description_is_told(built_fmus):
    told = facts(Fmu(built_fmus / "fmi3" / "mpc.fmu").archive)
    assert (told["model"], told["fmi_version"], told["interface_types"]) == ("mpc", "3.0", ["Co-Simulation"])
    assert told["tool"].startswith("macrostep ")
    assert told["sources"] is True
    assert "saves its state" in told["capabilities"]
    assert told["default_experiment"]["step"] == 0.1
    assert told["variables"]["input"] == 15


def test_which_interface_is_measured_is_told():
    assert facts(Fmu(built_models()["ball", 2]).archive)["measured_as"] == "Model Exchange"


def test_a_person_reads_what_is_told_and_what_is_not(tmp_path):
    path = lag(tmp_path)
    rows = dict(shown(file_facts(path) | facts(Fmu(path).archive)))
    assert rows["model"] == "m"
    assert rows["sources inside"] == "no"
    assert rows["variables"] == "1 input, 1 output, 1 parameter"
    assert rows["default experiment"] == "start time 0 s, step 0.1 s" or rows["default experiment"] == "step 0.1 s"
    assert rows["not told"].startswith("description, maker, made with, made on, version, copyright, licence")
    assert fact_text("size", 1234567) == "1 234 567 bytes"
