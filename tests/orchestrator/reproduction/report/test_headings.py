"""Headings as places that links lead to; `test_rendering` shows that all links of a report do."""

from __future__ import annotations

import re

from orchestrator.reproduction.report import headings

TEXT = "# A, b\n\n## A b\n\n### A `b`!\n\n## What is left: r_dot of MP-plus\n"


def test_a_place_is_named_as_viewers_of_markdown_do():
    assert headings.anchor("C1: more stable yaw rate, less r_dot of MP-plus") == (
        "c1-more-stable-yaw-rate-less-r_dot-of-mp-plus"
    )


def test_a_title_that_stands_twice_has_two_places():
    places = re.findall(r'<h\d id="([^"]*)"', headings.converter().render(TEXT, {}))
    assert places == ["a-b", "a-b-1", "a-b-2", "what-is-left-r_dot-of-mp-plus"]


def test_the_sections_are_the_headings_of_the_second_level():
    assert headings.sections(TEXT) == [
        ("A b", "a-b-1"),
        ("What is left: r_dot of MP-plus", "what-is-left-r_dot-of-mp-plus"),
    ]
