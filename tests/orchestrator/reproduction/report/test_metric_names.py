"""Titles and values in the report's tables."""

from __future__ import annotations

import pytest

from orchestrator.reproduction.paper.verdict import DecidingNumber
from orchestrator.reproduction.report.metric_names import (
    METRIC_TITLES,
    labelled,
    metric_tables,
    metric_title,
    percentage,
    sentence,
    written,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.0, "3"), (0.0, "0"), (123456.0, "123456"), (1e6, "1e+06"), (0.12345, "0.123"), (-1234.5, "-1.23e+03")],
)
def test_whole_numbers_are_written_as_they_are_and_others_in_three_digits(value, text):
    assert written(value) == text


def test_a_share_is_a_percentage():
    assert percentage(0.985) == "98.5%"


def test_a_number_of_a_case_has_a_title_and_says_whose_it_is():
    assert labelled(DecidingNumber("r_peak", 0.5)) == "peak r [rad/s]: 0.5"
    assert labelled(DecidingNumber("r_peak", 0.5, of="LQR of old")) == "peak r [rad/s], LQR of old: 0.5"
    assert labelled(DecidingNumber("mine of yours", 1.0)) == "mine of yours: 1"


def test_the_tables_have_every_titled_metric_once_and_others_under_their_own_names():
    tables = metric_tables([{"metrics": dict.fromkeys([*METRIC_TITLES, "mine"], 0.0)}])
    assert sorted(name for _, names in tables for name in names) == sorted([*METRIC_TITLES, "mine"])
    assert tables[-1] == ("Others", ["mine"])
    assert metric_title("mine") == "mine"


def test_what_no_run_has_gets_no_column():
    assert metric_tables([{"metrics": {"v_x_min": 9.0}}, {"metrics": {}}]) == [("Limits and speed", ["v_x_min"])]


def test_a_verdict_becomes_a_sentence_whose_names_stay_what_they_are():
    assert sentence("holds against LQR") == "Holds against LQR."
