"""Blocks by name, the numbers they start from, and the FMUs that are built of them."""

from __future__ import annotations

import pytest

from components import BLOCKS
from orchestrator.scenario.catalogue import default_values


@pytest.mark.parametrize("name", sorted(BLOCKS))
def test_every_block_has_a_complete_parameter_set(name):
    assert set(default_values(BLOCKS[name])) == {v.name for v in BLOCKS[name].parameters()}
