"""What a summary tells of where a run comes from, and how it ended."""

from __future__ import annotations

from importlib import metadata

from orchestrator.results import provenance
from orchestrator.stepping.master import SimulationError

SUMMARY = {
    "scenario": "static",
    "title": "A lane change",
    "status": "finished",
    "units": {"plant": {"kind": "bicycle", "runs_as": "FMI 3.0"}},
    "versions": {"macrostep": "0.1"},
    "verdicts": {"no_contact": True, "inside_road": False},
    "metrics": {"r_peak": 0.123456},
}


def test_a_summary_in_a_few_words():
    assert provenance.facts(SUMMARY) == {
        "scenario": "static: A lane change",
        "status": "finished",
        "unit plant": "bicycle, FMI 3.0",
        "macrostep": "0.1",
    }
    assert provenance.facts({}) == {"status": "cut short: there is no summary.json"}


def test_a_fault_is_told_as_the_command_tells_it():
    fault = {"tick": 40, "time": 4.0, "unit": "plant", "reason": "the signal `plant.state.x` is nan"}
    told = provenance.facts({**SUMMARY, "status": "fault", "fault": fault})
    assert told["fault"] == "unit `plant`: the signal `plant.state.x` is nan"
    assert told["fault at"] == "tick 40 (t = 4 s)"
    error = SimulationError(fault["tick"], fault["time"], fault["unit"], fault["reason"])
    assert f"{told['fault at']}, {told['fault']}" == str(error)


def test_the_versions_are_those_of_the_libraries_that_a_result_depends_on(monkeypatch):
    found = provenance.versions()
    assert list(found) == ["macrostep", "python", "casadi", "fmpy", "numpy", "pandas", "rerun-sdk"]
    assert found["numpy"] == metadata.version("numpy")

    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", missing)
    assert provenance.own_version() == "0 (not installed)"


def test_what_came_of_a_run_is_a_line_each():
    outside = {"plant.x": {"time": 1.0, "value": 7.0, "declared": "finite number <= 5"}}
    metrics = {"gap_edge": 0.175, "mu_f_max": 0.611}
    assert provenance.measured_facts({**SUMMARY, "metrics": metrics, "out_of_range": outside}) == {
        "verdicts": "no contact: yes\ninside road: no",
        "metrics": "gap_edge 0.175 m\nmu_f_max 0.611",
        "out of range": "`plant.x` is 7 at t = 1 s, outside of what its unit declares (finite number <= 5)",
    }
    assert provenance.measured_facts({}) == {}
