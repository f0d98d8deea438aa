"""A small reproduction from end to end, and the report's numbers against those in the run folders.

This also shows `report/report.py`, `report/result_figures.py` and `report/varied_figure.py`.
"""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.reproduction.paper import experiments
from orchestrator.reproduction.reproduce import new_folder, reproduce
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied import varied_set as driving

LIST = """
[[runs]]
name = "mp"
task = "static"
scenario = "static"
plant = "bicycle"
controller = "mpc"
role = "mp"
label = "MP tuned"

[[runs]]
name = "two"
task = "static"
scenario = "static"
plant = "bicycle"
controller = "lqr"
role = "two_level"
label = "LQR"

[[sweeps]]
name = "sweep"
task = "static"
scenario = "static"
plant = "bicycle"
controller = "lqr"
parameter = "controller.q_delta"
values = [10.0, 300.0]
unit = "1/rad2"
label = "LQR"

[timing]
states = "mp"
controllers = ["mpc", "lqr"]
ratio_to = "mpc"

[[figures]]
name = "trajectory"
kind = "trajectory"
runs = ["mp", "two"]
claims = ["C2"]
caption = "Trajectories."

[[figures]]
name = "curve"
kind = "smoothness"
runs = ["mp"]
caption = "Smoothness."

[[figures]]
name = "times"
kind = "time"
claims = ["C8"]
caption = "Times."
"""


@pytest.fixture(scope="module")
def made(built_fmus, tmp_path_factory):
    root = tmp_path_factory.mktemp("reproduction")
    (root / "list.toml").write_text(LIST)
    request = variations.request(3, seed=5)
    driven = driving.run(request, lambda: None)
    listed = experiments.load(root / "list.toml")
    with new_folder(root / "report", listed) as claimed:
        return reproduce(listed, claimed.path, SILENT, driven)


@pytest.fixture(scope="module")
def told(made):
    return json.loads((made.folder / "report.json").read_text())


pytestmark = pytest.mark.slow


def test_the_reports_numbers_are_those_of_the_run_folders(made, told):
    assert [run["name"] for run in told["runs"]] == ["mp", "two", "sweep-10", "sweep-300"]
    for run in told["runs"]:
        summary = json.loads((made.folder / run["folder"] / "summary.json").read_text())
        assert summary["metrics"].items() <= run["metrics"].items()
        assert run["metrics"].keys() - summary["metrics"].keys() == {"r_sign_changes"}
        assert run["verdicts"] == summary["verdicts"]
        assert (made.folder / run["recording"]).is_file()
        assert (made.folder / run["folder"] / "signals.parquet").is_file()


def test_the_numbers_that_decide_are_metrics_of_the_runs_named_beside_them(told):
    metrics = {run["name"]: run["metrics"] for run in told["runs"]}
    c4 = next(v for v in told["claims"] if v["claim"] == "C4")
    for case in c4["cases"]:
        own, other = (metrics[name] for name in case["runs"])
        assert case["numbers"]["r_peak"] == own["r_peak"]
        assert case["numbers"]["r_peak of LQR"] == other["r_peak"]


def test_a_gain_at_its_own_value_is_the_run_itself(told):
    metrics = {run["name"]: run["metrics"] for run in told["runs"]}
    assert metrics["sweep-10"] == metrics["two"]


def test_times_stand_in_their_own_section_only(told):
    assert {t["controller"] for t in told["timings"]["controllers"]} == {"mpc", "lqr"}
    rest = json.dumps({name: part for name, part in told.items() if name != "timings"})
    assert not re.search(r'"p50_us[^"]*":', rest)  # it may be told that they decide, as the verdict itself is
    assert told["timings"]["claims"]["C8"][0].keys() == {"p50_us", "p50_us of LQR"}


def test_it_tells_when_by_what_and_from_which_seed_it_was_made(made, told):
    text = (made.folder / "report.md").read_text()
    assert datetime.fromisoformat(told["made"]) <= datetime.now(UTC)
    assert f"| date | {told['made'][:10]} " in text
    assert f"| versions | macrostep {told['versions']['macrostep']}, python {told['versions']['python']}, " in text
    assert "| seed | 5, from which the 3 variations are drawn |" in text


def test_each_claim_is_told_with_its_verdict_numbers_reason_and_figure(made, told):
    text = (made.folder / "report.md").read_text()
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    for verdict in told["claims"]:
        (section,) = (s for s in sections if s.startswith(f"{verdict['claim']}: "))
        outcome = verdict["outcome"]
        assert f"**{outcome[0].upper()}{outcome[1:]}.**" in section
        assert section.count("| yes |") + section.count("| no |") + section.count("| cannot be compared |") == len(
            verdict["cases"]
        )
        assert "**Reason.** A case holds with: " in section
    assert [re.findall(r"!\[.*\]\(figures/(.*)\)", s) for s in sections if s.startswith(("C2: ", "C8: "))] == [
        ["trajectory.png"],
        ["times.png"],
    ]


def test_the_page_needs_nothing_else_and_says_the_same_as_the_text(made):
    page, text = ((made.folder / f"report.{kind}").read_text() for kind in ("html", "md"))
    sources = re.findall(r'src="([^"]{0,30})', page)
    assert len(sources) == 4  # three figures of the list, one of the varied set
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "http" not in page.replace("https://www.w3.org", "")
    for heading in re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE):
        assert f">{heading}</h" in page
    assert all(f'id="{target}"' in page for target in re.findall(r'href="#([^"]*)"', page))
    assert "runs/mp/recording.rrd" in page


def test_every_verdict_is_told_even_where_nothing_decides(told):
    assert [v["claim"] for v in told["claims"]] == [f"C{i}" for i in range(1, 9)]
    assert next(v for v in told["claims"] if v["claim"] == "C6")["verdict"] == "not decided"


def test_the_varied_set_is_told_with_every_case(told):
    varied = told["varied"]
    assert (varied["count"], varied["seed"]) == (3, 5)
    assert [case["number"] for case in varied["cases"]] == [0, 1, 2]
    assert [v["claim"] for v in varied["claims"]] == [f"C{i}" for i in range(1, 7)]
    assert all("metrics" in run for case in varied["cases"] for run in case["runs"].values())


def test_a_reproduction_is_replaced_but_nothing_else_is(made, tmp_path):
    listed = experiments.load(made.folder.parent / "list.toml")
    with new_folder(made.folder, listed) as claimed:
        assert claimed.path == made.folder
        assert {path.name for path in made.folder.iterdir()} >= {"runs"}
        assert not (made.folder / "report.json").exists()
    (tmp_path / "report.json").write_text("mine")
    with pytest.raises(RequestError):
        new_folder(tmp_path, listed)
    assert (tmp_path / "report.json").read_text() == "mine"
    (tmp_path / "file").touch()
    with pytest.raises(RequestError, match="a file"):
        new_folder(tmp_path / "file", listed)


def test_without_a_name_the_next_number_is_taken(in_tmp_path):
    listed = experiments.load()
    with new_folder(None, listed) as first, new_folder(None, listed) as second:
        assert (str(first.named), str(second.named)) == ("runs/reproduce-1", "runs/reproduce-2")
