"""Every value of a parameter file has a unit and a source; the files hold the numbers of the paper."""

from __future__ import annotations

import pytest

from components import BLOCKS
from orchestrator.scenario.catalogue import default_values
from orchestrator.scenario.parameters import PARAMETERS, parameter_set


@pytest.mark.parametrize("path", sorted(PARAMETERS.values()), ids=lambda p: p.stem)
def test_every_value_has_a_unit_and_a_source(path):
    for name, given in parameter_set(path.stem).items():
        assert given.source, name
        assert given.unit, name


def test_the_paper_s_table_1():
    values = default_values(BLOCKS["bicycle"])
    table = {"l_f": 1.2, "l_r": 1.05, "m": 2000, "I_z": 1300, "mu": 0.5, "C_alpha_f": 12000, "C_alpha_r": 12000}
    assert {name: values[name] for name in table} == table


def test_plant_and_controller_share_the_numbers_of_the_vehicle():
    plant, controller = default_values(BLOCKS["bicycle"]), default_values(BLOCKS["mpc"])
    for name in parameter_set("vehicle"):
        assert plant[name] == controller[name]
