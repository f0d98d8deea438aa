"""The product stands every fault of the short form, which `python -m tests.faults --short` scores."""

from __future__ import annotations

import pytest

from tests.faults.scoring import Fault, Outcome, known_faults, outcome, table

SHORT = [one for one in known_faults() if one.short]


@pytest.mark.slow
@pytest.mark.parametrize("one", SHORT, ids=lambda one: f"{one.group}: {one.name}")
def test_a_fault_is_stood(one):
    assert outcome(one, seed=0).reason == ""


def test_the_score_counts_by_group_and_names_what_was_not_stood():
    def fails(_folder, _random):
        raise AssertionError("it hangs")

    good, bad = Fault("disk", "full", lambda *_: None, short=True), Fault("disk", "gone", fails, short=True)
    other = Fault("signals", "SIGTERM", lambda *_: None, short=False)
    outcomes = [outcome(one, seed=1) for one in (good, bad, other)]
    assert [one.reason for one in outcomes] == ["", "AssertionError: it hangs", ""]
    assert table(outcomes).splitlines() == [
        "group    stood",
        "disk     1 of 2",
        "signals  1 of 1",
        "NOT STOOD disk: gone: AssertionError: it hangs",
    ]


def test_times_and_places_follow_from_the_seed_and_the_fault_alone():
    drawn = []
    one = Fault("g", "n", lambda _, random: drawn.append(random.random()), short=True)
    for seed in (1, 2, 1):
        assert outcome(one, seed) == Outcome(one, "", pytest.approx(0, abs=60))
    assert drawn[0] == drawn[2] != drawn[1]
