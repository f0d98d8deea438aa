"""`macrostep export` as a person types it; what the files hold is shown in `exchange/test_export.py`."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize(
    ("options", "standard"), [((), "SSP 1.0"), (("--fmi", 2), "SSP 1.0"), (("--fmi", 3), "SSP 2.0")]
)
def test_blocks_become_fmi_2_unless_another_version_is_asked_for(macrostep, built_fmus, options, standard):
    code, out, _ = macrostep("export", "static", "--ssp", "a.ssp", *options)
    assert (code, out) == (0, f"a.ssp  {standard}, 3 FMUs\n")


def test_a_fixed_system_keeps_its_version(macrostep, built_fmus):
    macrostep("export", "static", "--ssp", "a.ssp", "--fmi", 3)
    code, out, _ = macrostep("export", "a.ssp", "--ssp", "b.ssp")
    assert (code, out) == (0, "b.ssp  SSP 2.0, 3 FMUs\n")
    code, _, err = macrostep("export", "a.ssp", "--ssp", "c.ssp", "--plant", "bicycle")
    assert code == 2
    assert err.startswith("macrostep: a.ssp: found --blocks, --fmi or another unit for a fixed system; valid: --set, ")
