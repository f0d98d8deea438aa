"""A system with other values of parameters, of which only the new ones are looked at."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from orchestrator import Fmu, Options, System, load
from orchestrator.system.other_values import with_values
from tests.fmus.foreign import description3, kept_folder, library, pack


@pytest.fixture(scope="module")
def system():
    return load("static", Options(mode="blocks")).system


def refusals(system, values):
    with pytest.raises(RequestError) as error:
        with_values(system, values)
    return [str(problem) for problem in error.value.problems]


def test_the_others_keep_their_values_and_the_system_is_not_changed(system):
    before = {name: dict(source.parameters) for name, source in system.units.items()}
    changed = with_values(system, {"plant.m": 1500.0, "controller.mu": 0.4})
    assert changed.units["plant"].parameters == {**before["plant"], "m": 1500.0}
    assert changed.units["controller"].parameters == {**before["controller"], "mu": 0.4}
    assert changed.units["traffic"] is system.units["traffic"]
    assert {name: dict(source.parameters) for name, source in system.units.items()} == before
    assert changed.connections == system.connections
    assert with_values(system, {}) is system


def test_what_no_parameter_can_be_is_told_all_at_once(system):
    found = refusals(system, {"plant.m": -1.0, "plant.mm": 1.0, "palnt.m": 1.0, "m": 2.0})
    assert found[0].startswith("plant.m: found -1")
    assert found[1].startswith("plant.mm: found an unknown parameter; valid: a parameter of `bicycle`: ")
    assert found[2:] == [
        "palnt.m: found a parameter of no unit; valid: the path of a parameter, with its unit. Did you mean `plant.m`?",
        "m: found a parameter of no unit; valid: the path of a parameter, with its unit",
    ]
    assert refusals(system, {"plant": 3.0})[0].startswith("plant: found a parameter of no unit")


def test_lengths_of_arrays_stay(tmp_path):
    variables = [
        '<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="2"/>',
        '<Float64 name="y" valueReference="2" causality="output"><Dimension valueReference="1"/></Float64>',
    ]
    text = description3(variables, ['<Output valueReference="2"/>'])
    binary = library(kept_folder() / "other_values", Version.FMI3, '#include "echo3.c"')
    system = System({"m": Fmu(pack(tmp_path / "m.fmu", Version.FMI3, text, binary))}, {})
    assert with_values(system, {"m.n": 2}).units["m"].interface.outputs[0].shape == (2,)
    assert refusals(system, {"m.n": 3}) == [
        "m.n: found another value of a parameter that the lengths of arrays depend on; valid: 2."
        " Make another System with it."
    ]
