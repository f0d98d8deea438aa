"""Behaviour at declared limits, and with values that are no numbers."""

from __future__ import annotations

from orchestrator.exchange.passport import faults
from tests.orchestrator.exchange.passport.measured_fmus import RANGE, lag, on_the_bench, told


def found(path, patience=10.0):
    with on_the_bench(path, patience) as bench:
        return told(faults.lines(bench))


def test_an_fmu_that_is_right_goes_on_at_its_limits_and_passes_nan_on(tmp_path):
    assert found(lag(tmp_path, u=RANGE)) == {
        "faults.limits": ("passes", "3 limits, 3 steps each"),
        "faults.nan": ("passes", "passes it on (1 of 1)"),
    }


def test_a_crash_at_a_limit_is_told_and_the_other_limits_are_tried(tmp_path):
    mark, evidence = found(lag(tmp_path, "#define STEP if (i->u >= 5) abort();", u=RANGE))["faults.limits"]
    assert (mark, evidence) == ("fails", "`u` = 5 (maximum): its process died (SIGABRT)")


def test_crashes_at_several_limits_are_all_told(tmp_path):
    evidence = found(lag(tmp_path, "#define STEP if (fabs(i->u) >= 5) abort();", u=RANGE))["faults.limits"][1]
    assert evidence == ("`u` = -5 (minimum): its process died (SIGABRT); `u` = 5 (maximum): its process died (SIGABRT)")


def test_a_hang_at_a_limit_is_told(tmp_path):
    macros = "#define STEP while (i->u >= 5);"
    assert found(lag(tmp_path, macros, u=RANGE), patience=1.0)["faults.limits"] == (
        "fails",
        "`u` = 5 (maximum): it hung: no answer within 1 s",
    )


def test_outputs_that_are_not_finite_without_an_error_fail(tmp_path):
    assert found(lag(tmp_path, "#define SHOWN i->u >= 5 ? NAN : i->x", u=RANGE))["faults.limits"] == (
        "fails",
        "`u` = 5 (maximum): `y` is not finite, without an error",
    )


def test_an_error_at_a_limit_is_an_answer(tmp_path):
    assert found(lag(tmp_path, "#define STEP if (i->u >= 5) return fmi2Error;", u=RANGE))["faults.limits"] == (
        "passes",
        "3 limits, 3 steps each; 1 of them answered by an error: `u` = 5 (maximum): a step at 0 s: an error",
    )


def test_limits_of_parameters_are_tried(tmp_path):
    evidence = found(lag(tmp_path, "#define STEP if (i->T < 0.1) abort();"))["faults.limits"][1]
    assert evidence == "`T` = 0.01 (minimum): its process died (SIGABRT)"


def test_what_an_fmu_does_with_nan_is_told(tmp_path):
    def told_of(macros):
        return found(lag(tmp_path, macros), patience=1.0)["faults.nan"]

    assert told_of("#define STEP if (i->u != i->u) return fmi2Error;") == ("passes", "returns an error (1 of 1)")
    assert told_of("#define STEP if (i->u == i->u) i->x = i->u;") == (
        "passes",
        "shows finite outputs all the same (1 of 1)",
    )
    assert told_of("#define STEP if (i->u != i->u) abort();") == (
        "fails",
        "`u` = nan (no number): its process died (SIGABRT)",
    )
    assert told_of("#define STEP while (i->u != i->u);") == (
        "fails",
        "`u` = nan (no number): it hung: no answer within 1 s",
    )


def test_outputs_that_are_never_finite_are_no_fault_of_a_limit(tmp_path):
    assert found(lag(tmp_path, "#define SHOWN INFINITY", u=RANGE))["faults.limits"][0] == "passes"
