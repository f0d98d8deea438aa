"""The step size: the order of convergence, and results that blow up."""

from __future__ import annotations

import numpy as np
import pytest

from fmus.reading.opening import open_fmu
from orchestrator.exchange.passport import dynamics
from orchestrator.exchange.passport.dynamics import blown, common, convergence, reference
from tests.orchestrator.exchange.passport.measured_fmus import EXPERIMENT, TRUCK, lag, on_the_bench, told

FINE = '<DefaultExperiment stepSize="0.001"/>'
EULER = "#define STEP i->x += h * (i->u - i->x) / i->T;"


def lines(path):
    with on_the_bench(path) as bench:
        return {line.key: line for line in dynamics.lines(bench)}


def test_an_fmu_that_is_exact_at_any_step_shows_no_difference(tmp_path):
    assert told(lines(lag(tmp_path)).values()) == {
        "dynamics.convergence": ("passes", "the step makes no difference above 1e-09"),
        "dynamics.own_step": ("passes", "with 0.1 s no output exceeds 100 times what it is with 0.025 s"),
        "dynamics.macro_step": ("passes", "with 0.1 s no output exceeds 100 times what it is with 0.025 s"),
    }


def test_explicit_euler_is_of_first_order(tmp_path):
    line = lines(lag(tmp_path, EULER))["dynamics.convergence"]
    assert line.mark == "passes"
    assert line.figures["order"].value == pytest.approx(1, abs=0.15)
    assert line.evidence.startswith("differences of 0.0")


def test_the_quarter_truck_that_explodes_at_a_tenth_of_a_second_is_flagged(tmp_path):
    found = lines(lag(tmp_path, TRUCK, experiment=FINE))
    assert found["dynamics.own_step"].mark == "passes"
    assert found["dynamics.convergence"].mark == "passes"
    macro = found["dynamics.macro_step"]
    assert macro.mark == "fails"
    assert macro.evidence.startswith("with 0.1 s `y` reaches ")
    assert macro.evidence.endswith(": it needs a step of 0.00625 s or less")
    assert macro.figures["step_that_holds"].value == 0.00625
    assert macro.figures["peak"].value > 1e20


def test_one_that_asks_for_no_step_is_flagged_at_both(tmp_path):
    found = lines(lag(tmp_path, TRUCK, experiment=""))
    assert [found[f"dynamics.{key}"].mark for key in ("own_step", "macro_step")] == ["fails", "fails"]
    assert found["dynamics.own_step"].evidence == found["dynamics.macro_step"].evidence


def test_a_model_that_truly_grows_is_not_flagged(tmp_path):
    found = lines(lag(tmp_path, "#define STEP i->x = (i->x + 1) * exp(5 * h) - 1;"))
    assert {line.mark for line in found.values()} == {"passes"}
    found = lines(lag(tmp_path, "#define STEP i->x += h * (5 * i->x + 1);"))
    assert found["dynamics.macro_step"].mark == "passes"


def test_one_that_counts_steps_does_not_converge(tmp_path):
    found = lines(lag(tmp_path, "#define SHOWN i->n"))
    assert found["dynamics.convergence"].mark == "fails"
    assert found["dynamics.macro_step"].mark == "passes"


def test_one_that_overflows_is_flagged(tmp_path):
    found = lines(lag(tmp_path, "#define STEP i->x += h * (i->u - 1e9 * i->x);"))
    assert found["dynamics.macro_step"].mark == "fails"
    assert found["dynamics.macro_step"].evidence.endswith("it does not settle either")
    assert found["dynamics.convergence"].evidence == "its outputs are not all finite"


def test_one_that_refuses_smaller_steps_has_no_order(tmp_path):
    found = lines(lag(tmp_path, "#define STEP if (h < 0.09) return fmi2Error;"))
    assert found["dynamics.convergence"].mark == "does not apply"
    assert found["dynamics.convergence"].evidence == "with 0.05 s: a step at 0 s: an error"
    assert found["dynamics.own_step"].mark == "passes"


def test_one_that_refuses_its_own_step_fails(tmp_path):
    found = lines(lag(tmp_path, "#define STEP return fmi2Discard;"))
    assert found["dynamics.own_step"].evidence == "with 0.1 s: a step at 0 s: discarded"
    assert found["dynamics.own_step"].mark == "fails"


def test_discrete_outputs_have_no_order(tmp_path):
    path = lag(tmp_path)
    text = path.with_suffix(".xml")
    del text
    with on_the_bench(path) as bench:
        for variable in bench.archive.description.modelVariables:
            if variable.name == "y":
                variable.variability = "discrete"
        found = told(dynamics.lines(bench))
    assert set(found.values()) == {("does not apply", "it has no continuous outputs")}


def test_an_internal_step_that_does_not_divide_the_macro_step_is_told(tmp_path):
    with on_the_bench(lag(tmp_path, experiment='<DefaultExperiment stepSize="0.03"/>')) as bench:
        bench.archive.description.coSimulation.fixedInternalStepSize = 0.03
        found = told(dynamics.lines(bench))
    why = "its internal step of 0.03 s does not divide 0.1 s"
    assert found["dynamics.macro_step"] == ("does not apply", why)


def test_one_that_ends_the_run_is_compared_up_to_there():
    short, long = np.ones((3, 1)), np.ones((5, 1))
    assert {f: len(t) for f, t in common({1: long, 2: short}).items()} == {1: 3, 2: 3}
    assert common({1: "refused", 2: short})[1] == "refused"


def test_the_reference_is_what_two_steps_agree_on():
    one, other = np.array([[1.0], [1.0]]), np.array([[1.0], [1.05]])
    assert reference({1: one, 2: other}) is other
    assert reference({1: one, 2: 2 * other}) is None
    assert reference({1: one, 2: "refused"}) is None
    assert reference({1: one, 2: np.array([[1.0], [np.nan]])}) is None


def test_what_is_not_finite_in_the_reference_either_is_no_blow_up():
    best = np.array([[1.0, np.inf], [1.0, np.inf]])
    assert blown(best, best).tolist() == [False, False]
    assert blown(np.array([[1.0, np.inf], [np.nan, np.inf]]), best).tolist() == [True, False]


def test_the_difference_is_relative_to_the_largest_value():
    table = np.linspace(0, 1, 11)[:, None]
    line = convergence({1: table * 1.2, 2: table * 1.1, 4: table * 1.05}, 0.1)
    assert line.figures["order"].value == pytest.approx(1)
    assert line.figures["difference_h2_h4"].value == pytest.approx(0.5 * 0.05 / 1.05)


def test_elements_of_arrays_have_names(built_fmus):
    archive = open_fmu(built_fmus / "fmi3" / "ramp_traffic.fmu")
    assert "obstacles.x[1]" in dynamics.elements(archive)
    assert EXPERIMENT
