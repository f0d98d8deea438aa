"""What becomes of a claim, in words and as data."""

from __future__ import annotations

import dataclasses

import pytest

from orchestrator.reproduction.paper.verdict import Case, DecidingNumber, Verdict, time_data, verdict_data


def case(holds, **factors):
    return Case(factors, holds, (), ())


def outcome(*cases):
    return Verdict("C", "", "", cases).outcome


def compared(holding, *, undecided=()):
    """The comparisons of the static task; two of the trackers are compared on linear tyres only."""
    on = {"linear": ("LQR", "Stanley", "pure pursuit"), "saturating": ("LQR",)}
    return [
        case(None if (s, a, t) in undecided else (s, a, t) in holding, setting=f"MP {s}", against=a, tyre=t)
        for t, trackers in on.items()
        for s in ("tuned", "literal")
        for a in trackers
    ]


@pytest.mark.parametrize(
    ("holding", "words"),
    [
        ([("tuned", "LQR", "linear")], "with MP tuned against LQR on linear tyres (1 of 8 cases)"),
        (
            [("tuned", "LQR", "linear"), ("tuned", "Stanley", "linear")],
            "with MP tuned against LQR and Stanley on linear tyres (2 of 8 cases)",
        ),
        (
            [(s, a, "linear") for s in ("tuned", "literal") for a in ("LQR", "Stanley")],
            "against LQR and Stanley on linear tyres (4 of 8 cases)",
        ),
        ([(s, a, "linear") for s in ("tuned", "literal") for a in ("LQR", "Stanley", "pure pursuit")],
            "on linear tyres (6 of 8 cases)"),
        ([(s, "LQR", t) for s in ("tuned", "literal") for t in ("linear", "saturating")],
            "against LQR (4 of 8 cases)"),
        ([("tuned", a, "linear") for a in ("LQR", "Stanley", "pure pursuit")] + [("tuned", "LQR", "saturating")],
            "with MP tuned (4 of 8 cases)"),
        ([("tuned", "LQR", "linear"), ("tuned", "Stanley", "linear"), ("literal", "LQR", "linear")],
            "with MP tuned against LQR and Stanley on linear tyres, and against LQR on linear tyres "
            "(3 of 8 cases)"),
    ],
)  # fmt: skip
def test_where_a_claim_holds_in_some_cases_is_told_in_whole_words(holding, words):
    assert outcome(*compared(holding)) == f"holds {words}"


def test_an_exception_is_told_where_that_is_shorter():
    everywhere = [(s, a, t) for s in ("tuned", "literal") for a in ("LQR", "Stanley", "pure pursuit")
        for t in ("linear", "saturating")]  # fmt: skip
    holding = [one for one in everywhere if one != ("literal", "LQR", "saturating")]
    assert outcome(*compared(holding)) == "holds except with MP literal on saturating tyres (7 of 8 cases)"
    two = [("literal", "Stanley", "linear"), ("literal", "pure pursuit", "linear")]
    told = outcome(*compared([one for one in holding if one not in two], undecided=two))
    assert told == "holds except with MP literal on saturating tyres (5 of 6 cases; 2 more cannot be compared)"


@pytest.mark.parametrize(
    ("holds", "words"),
    [
        ([True], "holds in the one case"),
        ([True] * 2, "holds in both cases"),
        ([True] * 3, "holds in all 3 cases"),
        ([True, True, True, None], "holds in all 3 cases; 1 more cannot be compared"),
        ([False], "does not hold in the one case"),
        ([False] * 2, "does not hold in either case"),
        ([False] * 3, "does not hold in any of the 3 cases"),
        ([False, None, None], "does not hold in the one case; 2 more cannot be compared"),
        ([None], "not decided: 1 case that cannot be compared"),
        ([None, None], "not decided: 2 cases that cannot be compared"),
        ([], "not decided: no case"),
        ([True, False, None], "holds against A (1 of 2 cases; 1 more cannot be compared)"),
    ],
)
def test_every_outcome_has_words(holds, words):
    assert outcome(*(case(one, against=name) for one, name in zip(holds, "ABCD", strict=False))) == words


def test_every_factor_of_the_claims_has_words():
    yes = {"setting": "S", "method": "M", "against": "A", "task": "dynamic", "tyre": "linear", "else": "E"}
    told = [outcome(case(holds=True, **{n: v}), case(holds=False, **{n: "other"})) for n, v in yes.items()]
    expected = ("with S", "for M", "against A", "in the task dynamic", "on linear tyres", "for else E")
    assert told == [f"holds {words} (1 of 2 cases)" for words in expected]
    tasks = [case(task != "c", task=task, x=x) for task, x in ("a1", "b2", "c3", "c1", "c2")]
    assert outcome(*tasks) == "holds in the tasks a and b (2 of 5 cases)"


def test_what_speaks_against_a_claim_is_counted():
    cases = [dataclasses.replace(case(holds=False, against=a), against=metrics)
        for a, metrics in (("A", ("r_rms", "r_peak")), ("B", ("r_rms",)))]  # fmt: skip
    verdict = Verdict("C", "", "", tuple(cases))
    assert verdict.speaking_against == {"r_rms": 2, "r_peak": 1}
    assert verdict_data(verdict)["cases"][0]["speaks_against"] == ["r_rms", "r_peak"]


def test_wall_times_stand_apart_from_what_every_reproduction_gives():
    numbers = (DecidingNumber("p50_us", 5.0), DecidingNumber("p50_us", 6.0, of="LQR"), DecidingNumber("distance", 0.1))
    verdict = Verdict("C", "", "", (Case({"against": "LQR"}, holds=True, measured=numbers, runs=("mp",)),))
    assert verdict_data(verdict)["cases"][0]["numbers"] == {"distance": 0.1}
    assert time_data(verdict) == [{"p50_us": 5.0, "p50_us of LQR": 6.0}]


def test_a_verdict_without_wall_times_gives_none():
    verdict = Verdict("C", "", "", (Case({}, holds=True, measured=(DecidingNumber("distance", 0.1),), runs=()),))
    assert time_data(verdict) == []
