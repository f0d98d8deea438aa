"""Signals that grow without bound are told after a run."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.results.growth import growth_remarks
from tests.orchestrator.exchange.passport.measured_fmus import TRUCK, lag

T = np.arange(100) * 0.1


@pytest.mark.parametrize("shape", [np.exp(T * 5), (-1.5) ** np.arange(100), np.append(np.exp(T * 5), [np.nan])])
def test_a_signal_that_grows_is_told_with_its_size(shape):
    (text,) = growth_remarks({"time": T, "plant.y": shape, "plant.z": np.exp(T * 4)}, ["plant"])
    assert text.startswith(f"`plant.y` grows without bound, up to {np.abs(shape[:100]).max():.3g}: ")
    assert text.endswith("; try a shorter --step")


@pytest.mark.parametrize(
    "shape",
    [1e9 + np.sin(T), 1e9 * np.sin(T), np.exp(T), np.arange(100), np.full(100, np.nan), T[:5], 1e9 * np.exp(-T)],
)
def test_a_signal_that_does_not_is_not_told(shape):
    assert growth_remarks({"plant.y": shape}, ["plant"]) == []


def test_a_run_with_a_step_that_is_too_long_says_so(tmp_path, macrostep):
    lag(tmp_path, TRUCK, experiment='<DefaultExperiment stopTime="10" stepSize="0.001"/>')
    code, _, err = macrostep("run", "m.fmu", "--step", "0.1", "--stop-time", "3", "--out", "long")
    assert code == 0
    assert "note: `fmu` prefers steps of 0.001 s, and gets 0.1 s: its results may be coarse, or grow" in err
    assert "note: `fmu.y` grows without bound, up to " in err
    code, _, err = macrostep("run", "m.fmu", "--stop-time", "3", "--out", "short")
    assert code == 0
    assert "grow" not in err
