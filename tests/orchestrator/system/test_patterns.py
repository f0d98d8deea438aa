"""Patterns of signals, and the brackets of arrays in them."""

from __future__ import annotations

import pytest

from orchestrator.system.patterns import fits


@pytest.mark.parametrize(
    ("path", "pattern", "expected"),
    [("a.x[1].y", "a.x[1].*", True), ("a.x1.y", "a.x[1].*", True), ("a.x[2].y", "a.x[1].*", False), ("a", "b*", False)],
)
def test_brackets_are_those_of_arrays_and_of_patterns(path, pattern, expected):
    assert fits(path, pattern) is expected
