"""`macrostep check` as a person types it; what it finds in files is shown in `exchange/test_check.py`."""

from __future__ import annotations

from components import SOCKETS, Socket


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
