"""Mapping templates, line by line; how `macrostep check` writes them is shown in `exchange/test_check.py`."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.sockets import PLANT, TRAFFIC
from fmus.unit_interface import Interface
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.template import candidates, relative, template

INPUTS = {"wheel": "deg", "brake": "N", "state.x": "m"}
OUTPUTS = {"speed": "km/h", "East": "mm"}


@pytest.fixture
def theirs():
    ins, outs = (
        tuple(Variable(n, Quantity(u, n, Type.FLOAT64)) for n, u in found.items()) for found in (INPUTS, OUTPUTS)
    )
    return Interface("theirs", ins, outs, (), np.zeros((2, 3), dtype=bool), False, {"wheel": 0.5})  # noqa: FBT003


@pytest.fixture
def lines(theirs):
    return template(fit("plant", PLANT, theirs, "theirs.fmu"), PLANT, theirs, 'the"irs.fmu', "m.toml").splitlines()


def test_what_is_needed_is_to_be_filled_in_with_candidates_and_the_roles_that_it_may_have(lines):
    assert (
        'delta_f = "?"  # [rad] front road-wheel angle, to the left; candidates: wheel [deg]; '
        'or { variable = "...", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }, '
        'as = "steering_rate"'
    ) in lines
    assert (
        'T_r = "?"  # [N.m] torque on one rear wheel, driving positive; candidates: brake [N] as "wheel_force" or '
        '"force"; or as = "axle_torque", "wheel_force", "force", "acceleration"; several: [{ ... }, { ... }]; '
        "not read: { unused = true }"
    ) in lines


def test_what_is_optional_and_inputs_that_nothing_drives_are_commented_out(lines):
    assert "# [motion]  # what it shows, optional" in lines
    assert '# a_x = "?"  # [m/s2] longitudinal acceleration' in "\n".join(lines)
    assert '# "wheel" = { value = 0.5, unit = "deg" }' in lines


def test_a_template_is_toml(lines):
    content = tomllib.loads("\n".join(lines))
    assert (content["fmu"], content["socket"], content["state"]["v_x"]) == ('the"irs.fmu', "plant", "?")


def test_candidates_measure_the_same_and_the_likeliest_is_first(theirs):
    signal = next(v for v in PLANT.signals() if v.name == "state.v_x")
    assert candidates(signal, theirs.outputs, fit("plant", PLANT, theirs, "theirs.fmu")) == ["speed [km/h]"]


@pytest.mark.parametrize(
    ("signal", "offered"),
    [("x", ["float [m]", "int"]), ("valid", ["flag", "int"]), ("id", ["int", "float"])],
)
def test_candidates_are_of_a_fitting_type(signal, offered):
    kinds = {"float": Type.FLOAT64, "int": Type.INT32, "flag": Type.BOOLEAN, "text": Type.STRING}
    outs = tuple(Variable(name, Quantity("m", name, kind)) for name, kind in kinds.items())
    theirs = Interface("theirs", (), outs, (), np.zeros((4, 0), dtype=bool), False, {})  # noqa: FBT003
    ours = next(v for v in TRAFFIC.signals() if v.name == f"obstacles.{signal}")
    assert sorted(candidates(ours, outs, fit("traffic", TRAFFIC, theirs, "theirs.fmu"))) == sorted(offered)


def test_a_template_names_its_fmu_relative_to_itself(tmp_path):
    assert relative(tmp_path / "fmus" / "a.fmu", tmp_path / "maps") == "../fmus/a.fmu"
