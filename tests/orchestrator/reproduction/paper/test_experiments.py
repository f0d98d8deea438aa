"""The list of experiments: complete, and nothing on it is left out silently."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.reproduction.paper import claims, experiments
from orchestrator.reproduction.paper.experiments import FigureKind, RunRole


def listed(tmp_path, text):
    file = tmp_path / "list.toml"
    file.write_text(text)
    return experiments.load(file)


RUN = (
    '{{ name = "{name}", task = "static", scenario = "{scenario}", plant = "bicycle", controller = "{controller}", '
    'role = "mp", label = "MP" }}'
)


def test_the_list_fits_this_installation_and_has_all_that_the_claims_need():
    found = experiments.load()
    roles = {run.role for run in found.runs}
    assert roles == set(RunRole) - {RunRole.SWEEP}
    assert {run.task for run in found.runs} == {"static", "dynamic", "dynamic-slow"}
    assert {run.plant for run in found.runs} == {"bicycle", "bicycle_saturated"}
    assert {s.controller for s in found.sweeps} == {"lqr", "stanley", "pure_pursuit"}
    assert found.timing is not None


def test_the_seven_figures_of_the_paper_come_first():
    kinds = [figure.kind for figure in experiments.load().figures[:7]]
    assert kinds == [FigureKind.TRAJECTORY, FigureKind.YAW_RATE] * 3 + [FigureKind.SMOOTHNESS]


def test_a_block_that_is_not_there_is_refused_with_all_others_that_are_not(tmp_path):
    runs = [
        RUN.format(name="a", scenario="static", controller="mpc_plsu"),
        RUN.format(name="b", scenario="statik", controller="mpc"),
    ]
    with pytest.raises(RequestError) as refused:
        listed(tmp_path, f"runs = [{', '.join(runs)}]")
    said = [str(problem) for problem in refused.value.problems]
    assert said[0].startswith("list.toml: a: found the unknown block `mpc_plsu`; valid: bicycle, ")
    assert said[0].endswith("Did you mean `mpc_plus`?")
    assert said[1].startswith("list.toml: b: found the unknown scenario `statik`")


def test_what_resembles_nothing_is_not_left_out_silently(tmp_path):
    with pytest.raises(RequestError, match="Nothing is left out silently: add it, or take it off the list"):
        listed(tmp_path, f"runs = [{RUN.format(name='a', scenario='static', controller='qqqq')}]")


def test_two_runs_of_one_name_are_refused(tmp_path):
    run = RUN.format(name="a", scenario="static", controller="mpc")
    with pytest.raises(RequestError, match="list.toml: a: found two runs of this name"):
        listed(tmp_path, f"runs = [{run}, {run}]")


def test_a_figure_of_a_run_that_is_not_there_is_refused(tmp_path):
    text = f"runs = [{RUN.format(name='a', scenario='static', controller='mpc')}]\n"
    text += '[[figures]]\nname = "f"\nkind = "trajectory"\nruns = ["b"]\ncaption = ""\n'
    with pytest.raises(RequestError, match="list.toml: figure f: found the unknown run `b`"):
        listed(tmp_path, text)


def test_a_sweep_is_one_run_for_each_value():
    sweep = next(s for s in experiments.load().sweeps if s.name == "sweep-stanley")
    made = sweep.runs()
    assert [run.settings for run in made] == [(f"controller.k={value!r}",) for value in sweep.values]
    assert all(run.role is RunRole.SWEEP for run in made)


def test_every_claim_and_the_goal_have_a_figure_of_their_own():
    judged = [*claims.CLAIMS, "plus"]
    figures = experiments.load().figures
    assert {figure.claims[0] for figure in figures} == set(judged)
    assert {claim for figure in figures for claim in figure.claims} <= set(judged)
