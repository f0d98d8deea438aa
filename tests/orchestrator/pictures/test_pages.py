"""The pages that say where runs come from."""

from __future__ import annotations

from orchestrator.pictures import pages
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare

SUMMARY = {
    "scenario": "static",
    "title": "A lane change",
    "status": "finished",
    "units": {"plant": {"kind": "bicycle", "runs_as": "FMI 3.0"}},
    "versions": {"macrostep": "0.1"},
    "verdicts": {"no_contact": True, "inside_road": False},
    "metrics": {"r_peak": 0.123456},
}


def test_runs_stand_side_by_side_with_the_parameters_that_differ():
    ours, smoother = (
        prepare("static", Options(mode="blocks", settings=settings)) for settings in ([], ["controller.b_3=2e-2"])
    )
    text = pages.comparison(["a", "b"], [SUMMARY, {}], [ours, smoother])
    assert "| status | finished | cut short: there is no summary.json |\n" in text
    assert "| no contact | yes |  |\n| inside road | no |  |\n| r_peak | 0.1235 |  |\n" in text
    differing = text.partition("## Parameters that differ")[2].strip().splitlines()
    value = ours.sources["controller.b_3"]["value"]
    assert differing == ["| | a | b |", "|---|---|---|", f"| controller.b_3 | {value} s4/rad2 | 0.02 s4/rad2 |"]
    assert "Parameters" not in pages.comparison(["a", "b"], [SUMMARY, SUMMARY], [ours, ours])


def test_texts_of_other_makers_stay_in_their_cell():
    system = prepare("idle", Options(mode="blocks")).system
    text = pages.page("a", {"title": "left | right\nand back"}, system)
    assert text.startswith("# a\n\n| | |\n|---|---|\n| title | left \\| right, and back |\n")
