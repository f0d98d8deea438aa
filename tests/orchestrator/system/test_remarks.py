"""Integers that drive enumerations: allowed, passed on as they are, and told."""

from __future__ import annotations

import pytest

from fmus.toolchain.version import Version
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.remarks import enumeration_remarks
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, library, pack, scalar

GEAR = (
    '<TypeDefinitions><SimpleType name="Gear"><Enumeration><Item name="neutral" value="0"/>'
    '<Item name="first" value="1"/></Enumeration></SimpleType></TypeDefinitions>'
)
ENUMERATION = {"kind": "Enumeration", "of_declaredType": "Gear"}


@pytest.fixture(scope="module")
def units(tmp_path_factory):
    """A unit with an integer and an enumeration, inputs at 1 and 2 and outputs at 101 and 102."""
    folder = tmp_path_factory.mktemp("units")
    variables = [
        scalar("n", 1, "input", "Integer", variability="discrete", of_start="1"),
        scalar("e", 2, "input", variability="discrete", of_start="1", **ENUMERATION),
        scalar("n_out", 101, "output", "Integer", variability="discrete"),
        scalar("e_out", 102, "output", variability="discrete", **ENUMERATION),
    ]
    outputs = [f'<Unknown index="{i}" dependencies=""/>' for i in (3, 4)]
    text = description2(variables, outputs, initial=outputs, before=GEAR)
    path = pack(folder / "m.fmu", Version.FMI2, text, library(folder, Version.FMI2, '#include "echo2.c"'))
    return {"a": Fmu(path), "b": Fmu(path)}


def test_integers_and_enumerations_of_fmi_2_drive_each_other(units):
    system = System(units, {"b.e": "a.n_out", "b.n": "a.e_out"}, held={"a.n": 7, "a.e": 1})
    found = simulate(system, h=0.1, until=0.5)
    assert found["b.e_out"].tolist()[-1] == 7
    assert found["b.n_out"].tolist()[-1] == 1
    assert list(enumeration_remarks(system)) == [
        "a.n_out -> b.e: an integer drives an enumeration; every value is passed on, also one that is not in"
        " 0 (neutral), 1 (first)"
    ]


def test_nothing_is_said_of_equal_types(units):
    system = System(units, {"b.e": "a.e_out", "b.n": "a.n_out"}, held={"a.n": 7, "a.e": 1})
    assert list(enumeration_remarks(system)) == []
