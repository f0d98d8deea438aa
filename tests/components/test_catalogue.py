"""The catalogue: what is in it, and what is added while a program runs."""

from __future__ import annotations

from typing import final

import pytest

from components import (
    BLOCKS,
    CATALOGUE,
    EXTRAS,
    Block,
    NoState,
    RequestError,
    Socket,
    add_block,
    block,
    quantity,
    record,
    remove_block,
)


@record
class Signal:
    """One number."""

    value: float = quantity("1", "a number")


@record
class Nothing:
    """No input."""


@record
class Shown:
    """One output bus."""

    signal: Signal


@final
@block(Socket(name="source", inputs={}, outputs={"signal": Signal}))
class Constant(Block[Nothing, NoState, Shown]):
    """Shows a constant."""

    k: float = quantity("1", "constant")

    def start(self):
        return NoState()

    def output(self, x, u):
        return Shown(signal=Signal(value=self.k))

    def step(self, x, u, h):
        return x


def test_blocks_are_named_after_their_classes():
    assert set(BLOCKS) == {cls.name for cls in CATALOGUE}
    assert all(BLOCKS[cls.name] is cls for cls in CATALOGUE)
    assert set(EXTRAS) == {"commonroad_st", "commonroad_mb"}


def test_a_block_of_a_new_socket_is_added_and_removed():
    add_block(Constant)
    try:
        assert BLOCKS["constant"] is Constant
        add_block(Constant)  # once more is no contradiction
    finally:
        remove_block("constant")
    assert "constant" not in BLOCKS
    remove_block("constant")


def test_a_name_that_is_taken_is_refused(monkeypatch):
    monkeypatch.setattr(Constant, "name", "bicycle")
    bicycle = BLOCKS["bicycle"]
    with pytest.raises(RequestError) as refused:
        add_block(Constant)
    assert str(refused.value) == "block `bicycle`: found another block of that name; valid: a name that is free"
    assert BLOCKS["bicycle"] is bicycle
