"""`macrostep check` as a person types it; what it finds in files is shown in `exchange/test_check.py`."""

from __future__ import annotations

import json

import pytest

from components import SOCKETS, Socket
from tests.orchestrator.exchange.passport.measured_fmus import lag


def test_the_exit_code_says_whether_the_fmu_fits_the_socket(macrostep, built_fmus):
    bicycle = built_fmus / "fmi3" / "bicycle.fmu"
    assert macrostep("check", bicycle, "--socket", "plant")[0] == 0
    assert macrostep("check", bicycle, "--socket", "controller")[0] == 1
    assert macrostep("check", bicycle, "--socket", "driver")[0] == 2


def test_any_socket_that_is_registered_can_be_asked_for(macrostep, built_fmus, monkeypatch):
    plant = SOCKETS["plant"]
    towed = Socket(name="towed", inputs=plant.inputs, outputs=plant.outputs, optional=plant.optional)
    monkeypatch.setitem(SOCKETS, "towed", towed)
    code, out, _ = macrostep("check", built_fmus / "fmi3" / "bicycle.fmu", "--socket", "towed")
    assert code == 0
    assert "socket towed: fits as it is\n" in out


def test_a_passport_is_written_to_the_working_folder(macrostep, in_tmp_path):
    lag(in_tmp_path)
    code, out, err = macrostep("check", "m.fmu", "--passport")
    assert (code, err) == (0, "")
    assert out.startswith("m.fmu: ")
    assert out.endswith(" pass, 0 fail, 4 do not apply\nwritten: m.passport.html and m.passport.json\n")
    content = json.loads((in_tmp_path / "m.passport.json").read_text())
    assert content["passes"] is True
    assert (in_tmp_path / "m.passport.html").read_text().startswith("<!doctype html>")


def test_a_passport_against_another_says_what_got_worse(macrostep, in_tmp_path):
    lag(in_tmp_path, "#define ON_RESET")
    code, out, err = macrostep("check", "m.fmu", "--passport", "--out", "old")
    assert code == 1
    assert err.startswith("fails: After a reset it gives the same bits (state.reset): `y` differs first in row 0: ")
    assert macrostep("check", "m.fmu", "--passport", "--out", "same", "--against", "old/m.passport.json")[0] == 0
    lag(in_tmp_path, "#define STATE double")
    code, out, err = macrostep("check", "m.fmu", "--passport", "--out", "new", "--against", "old/m.passport.json")
    assert code == 1
    assert "worse: Back in a saved state it gives the same bits (state.restored): passes, now fails\n" in out
    assert "better: After a reset it gives the same bits (state.reset): fails, now passes\n" in out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["gone.fmu", "--passport"], "gone.fmu: found no such file; valid: an .fmu, or the .toml that maps one"),
        (
            ["m.fmu", "--passport", "--socket", "plant"],
            "--passport: found --socket beside it; valid: --out, --against. A passport tries all sockets, and runs.",
        ),
        (
            ["m.fmu", "--against", "old.json"],
            "--against: found a passport to compare with, but none to compare; valid: --passport --against FILE.json",
        ),
        (
            ["m.fmu", "--passport", "--against", "old.json"],
            "--against old.json: found no such file; valid: the .passport.json of an FMU",
        ),
    ],
)
def test_a_wrong_request_for_a_passport_is_code_2(macrostep, in_tmp_path, arguments, text):
    lag(in_tmp_path)
    assert macrostep("check", *arguments)[::2] == (2, f"macrostep: {text}\n")
