"""Reports on long work."""

from __future__ import annotations

from components.interfaces.progress import SILENT


def test_silence_prints_nothing(capsys):
    SILENT.now("stepping")
    SILENT.done("built mpc for FMI 3.0")
    assert capsys.readouterr() == ("", "")
