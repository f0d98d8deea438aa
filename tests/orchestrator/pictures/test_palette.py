"""Colours tell runs and states apart, in both themes."""

from __future__ import annotations

import itertools

import pytest

from orchestrator.pictures import palette

GROUNDS = ((13, 14, 14), (255, 255, 255))
"""Of plots, in the dark and the light theme"""


def _luminance(colour):
    """Relative luminance of WCAG 2.1."""
    parts = [c / 255 / 12.92 if c / 255 <= 0.03928 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in colour]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def _contrast(a, b):
    high, low = sorted((_luminance(a), _luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("colour", [*palette.SERIES, *palette.RUNS, palette.LIMIT])
@pytest.mark.parametrize("ground", GROUNDS)
def test_lines_stand_out_from_either_ground(colour, ground):
    assert _contrast(colour, ground) > 2.3


@pytest.mark.parametrize("colours", [palette.SERIES, palette.RUNS])
def test_colours_of_a_group_differ(colours):
    for a, b in itertools.combinations(colours, 2):
        assert sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) > 40**2


def test_a_label_stands_out_from_its_plate():
    for colour in (palette.WAYPOINT, palette.NAME, palette.EDGE):
        assert _contrast(colour, (40, 40, 40)) > 7
        assert _contrast(colour, (150, 150, 150)) > 2.2


def test_unknown_states_and_more_runs_take_the_colours_in_turn():
    assert palette.state("fallback", 7) == palette.STATES["fallback"]
    assert palette.state("mine", 7) == palette.SERIES[1]
    assert palette.run(len(palette.RUNS)) == palette.RUNS[0]
    assert palette.paler((255, 0, 165), 1) == (165, 165, 165)
