"""What becomes of a claim, in words and as data."""

from __future__ import annotations

from orchestrator.reproduction.paper.verdict import Case, DecidingNumber, Verdict, condition, time_data, verdict_data


def test_a_condition_is_told_in_as_few_factors_as_explain_it():
    def case(setting, against, tyre, holds):
        return Case({"setting": setting, "against": against, "tyre": tyre}, holds, {}, ())

    by_two = [case(s, a, "linear", s == "A" or a == "X") for s in "AB" for a in "XY"]
    assert condition(by_two) == "except for setting B / against Y"
    one = [case(s, a, t, t == "linear") for s in "AB" for a in "XY" for t in ("linear", "saturating")]
    assert condition(one) == "only for tyre linear"


def test_wall_times_stand_apart_from_what_every_reproduction_gives():
    numbers = (DecidingNumber("p50_us", 5.0), DecidingNumber("p50_us", 6.0, of="LQR"), DecidingNumber("distance", 0.1))
    verdict = Verdict("C", "", "", (Case({"against": "LQR"}, holds=True, measured=numbers, runs=("mp",)),))
    assert verdict_data(verdict)["cases"][0]["numbers"] == {"distance": 0.1}
    assert time_data(verdict) == [{"p50_us": 5.0, "p50_us of LQR": 6.0}]


def test_a_verdict_without_wall_times_gives_none():
    verdict = Verdict("C", "", "", (Case({}, holds=True, measured=(DecidingNumber("distance", 0.1),), runs=()),))
    assert time_data(verdict) == []
