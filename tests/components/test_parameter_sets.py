"""Parameter sets lie beside the blocks that they belong to, and have names of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

import components
from components import BLOCKS
from tests.components.parameter_sets import SETS, block_values

FOLDERS = {"plant": "vehicle"}
"""Folders of blocks that are not called after their socket."""


def test_a_parameter_set_has_its_name_once():
    files = [path.stem for path in Path(components.__file__).parent.glob("*/parameters/*.toml")]
    assert sorted(files) == sorted(SETS)
    assert "scene" not in SETS  # the one that lies beside the scenarios


@pytest.mark.parametrize("name", BLOCKS)
def test_the_default_parameter_set_of_a_block_lies_beside_it_and_is_complete(name):
    block = BLOCKS[name]
    assert SETS[name].parent.parent.name == FOLDERS.get(block.socket.name, block.socket.name)
    assert block(**block_values(name))
