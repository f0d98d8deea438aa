"""`macrostep list` as a person types it.

Shows `catalogue_in_words.py`.
"""

from __future__ import annotations

from components import BLOCKS
from orchestrator.scenario import scenario_file


def test_list_names_scenarios_and_blocks(macrostep):
    code, out, _ = macrostep("list")
    assert code == 0
    for name in ("static", "static-literal", "idle", "bicycle", "ramp_traffic", "mpc", "coast"):
        assert name in out


def test_a_block_is_shown_with_units_ranges_meaning_and_sources(macrostep):
    code, out, _ = macrostep("list", "mpc")
    assert code == 0
    (mass,) = (line for line in out.splitlines() if line.startswith("  m  "))
    assert mass.split(maxsplit=2)[:2] == ["m", "2000.0"]
    assert "1 <= finite number [kg]" in mass
    assert "mass of the predicted vehicle" in mass
    assert mass.endswith("paper, Table 1")
    assert "\n  ego.x " in out
    assert "\n  actuation.delta_f " in out


def test_every_block_and_scenario_can_be_shown(macrostep):
    for name in (*BLOCKS, *scenario_file.names()):
        code, out, _ = macrostep("list", name)
        assert code == 0, name
        assert out.startswith(f"{name}: "), name


def test_an_unknown_name_is_refused_with_the_nearest(macrostep):
    code, _, err = macrostep("list", "statc")
    assert code == 2
    assert err.startswith("macrostep: statc: found no block or scenario of this name; valid: bicycle, ")
    assert err.rstrip().endswith("Did you mean `static`?")
