"""The types of `Modelica.Units.SI` that a model may use without the Standard Library (`flat.standard_types`)."""

from __future__ import annotations

import re

import pytest

from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT, base_unit
from fmus.modelica.block import modelica_block
from fmus.modelica.flat import standard_types

TYPES = dict(
    re.findall(r'type (\w+) = Real\(unit = "([^"]+)"', (standard_types() / "package.mo").read_text(encoding="utf-8"))
)


@pytest.mark.parametrize("name", TYPES)
def test_every_type_has_a_unit_of_measurement_that_pint_reads_the_same(name):
    unit = TYPES[name]
    assert unit in UNITS_OF_MEASUREMENT
    read = base_unit(unit.replace("Ohm", "ohm") + " ") if unit != "1" else base_unit("1")
    assert read is None or read == UNITS_OF_MEASUREMENT[unit].base


@pytest.mark.parametrize("line", ["import SI = Modelica.Units.SI;", "import Modelica.Units.SI;"])
def test_a_model_uses_the_types_by_every_kind_of_name(written, line):
    path = written(
        f"""model Car "a point mass"
  {line}
  extends MacroStep.Interfaces.Plant;
  parameter SI.Mass m = 2000 "mass";
  parameter Modelica.Units.SI.Length R_w = 0.3 "radius";
  parameter SI.TranslationalDampingConstant d = 3 "damping";
  SI.Position x(start = 0, fixed = true);
  SI.Velocity v(start = 10, fixed = true);
equation
  der(x) = v;
  der(v) = (2*actuation.T_r/R_w - d*v)/m;
  state.x = x; state.y = 0; state.psi = 0; state.v_x = v; state.v_y = 0; state.r = 0;
end Car;
"""
    )
    made = modelica_block(path).block
    units = {v.name: (v.quantity.unit, v.quantity.min) for v in made.parameters()}
    assert units == {"m": ("kg", 0.0), "R_w": ("m", None), "d": ("N.s/m", None)}
