"""Where a claim holds: groups of cases, and their words; `test_verdict` shows them in whole sentences."""

from __future__ import annotations

from itertools import product

from orchestrator.reproduction.paper import where

CASES = [
    {"setting": setting, "against": against, "tyre": tyre}
    for tyre, trackers in (("linear", ("LQR", "Stanley", "pure pursuit")), ("saturating", ("LQR",)))
    for setting in ("MP tuned", "MP literal")
    for against in trackers
]


def test_whatever_holds_the_groups_have_these_cases_and_no_others():
    for holding in product((True, False), repeat=len(CASES)):
        good = [case for case, holds in zip(CASES, holding, strict=True) if holds]
        bad = [case for case, holds in zip(CASES, holding, strict=True) if not holds]
        found = where.groups(good, bad)
        assert [
            any(all(case[name] in values for name, values in group.items()) for group in found) for case in CASES
        ] == list(holding)


def test_cases_that_lack_a_factor_are_told_by_the_others():
    found = where.groups([{"against": "LQR"}, {"against": "Stanley", "tyre": "linear"}], [{"against": "pure pursuit"}])
    assert where.in_words(found) == "against LQR and Stanley"


def test_groups_are_joined_and_values_listed():
    found = [{"setting": ("MP tuned",), "against": ("LQR", "Stanley", "pure pursuit")}, {"tyre": ("linear",)}]
    assert where.in_words(found) == "with MP tuned against LQR, Stanley and pure pursuit, and on linear tyres"


def test_cases_are_counted():
    assert [where.counted(n) for n in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]
