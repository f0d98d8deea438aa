"""`macrostep list` as a person types it."""

from __future__ import annotations


def test_list_names_scenarios_and_blocks(macrostep):
    code, out, _ = macrostep("list")
    assert code == 0
    for name in ("static", "static-literal", "idle", "bicycle", "ramp_traffic", "mpc", "coast"):
        assert name in out
