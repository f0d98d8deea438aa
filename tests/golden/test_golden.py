"""The static run against a table that a person can read; renew it with `python tests/golden/test_golden.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from orchestrator import Options, load, simulate

FOLDER = Path(__file__).parent
SIGNALS = [
    "plant.state.x",
    "plant.state.y",
    "plant.state.psi",
    "plant.state.v_x",
    "plant.state.r",
    "controller.actuation.delta_f",
    "controller.actuation.T_r",
    "controller.plan.y_lower[3]",
    "controller.plan.y_upper[3]",
    "controller.path.x[9]",
]
NAMES = ["static", "static-literal"]


def table(name):
    made = load(name, Options(mode="blocks"))
    frame = simulate(made.system, h=made.h, until=made.until)
    return frame[["time", *SIGNALS]].iloc[::4].reset_index(drop=True).round(9)


def test_runs_equal_their_golden_tables():
    for name in NAMES:
        golden, found = pd.read_csv(FOLDER / f"{name}.csv"), table(name)
        assert list(found.columns) == list(golden.columns)
        for column in golden:  # the solver stops at 1e-6 in its own scale, which is 200 N.m for torques
            scale = max(1.0, golden[column].abs().max())
            np.testing.assert_allclose(found[column], golden[column], rtol=0, atol=1e-6 * scale, err_msg=column)


if __name__ == "__main__":
    for name in NAMES:
        table(name).to_csv(FOLDER / f"{name}.csv", index=False)
