from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

PLANT = """block Car
  extends MacroStep.Interfaces.Plant;
{declarations}
equation
  der(state.x) = state.v_x;
  state.y = 0;
  state.psi = 0;
  state.v_y = 0;
  state.r = 0;
{equations}
end Car;
"""


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str], Path]:
    """A Modelica file with the given text."""

    def write(text: str) -> Path:
        path = tmp_path / "Car.mo"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def car(written: Callable[[str], Path]) -> Callable[..., Path]:
    """A file with a plant that moves along x; the given equations say what `der(state.v_x)` is."""

    def write(declarations: str = "", equations: str = "  der(state.v_x) = actuation.T_r;") -> Path:
        return written(PLANT.format(declarations=declarations, equations=equations))

    return write
