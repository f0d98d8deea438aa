"""What a sweep shows: shares, the worst, causes, Sobol indices; and its report and figures.

Shows `findings.py`, `ranking.py`, `sweep_report.py` and `sweep_figures.py`.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity
from fmus.toolchain.version import Version
from orchestrator.scenario.options import Options
from orchestrator.sweeping import findings
from orchestrator.sweeping.bands import band_table
from orchestrator.sweeping.journal import VariantResult
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.ranking import badness, in_words, kept
from orchestrator.sweeping.results_table import results_table
from orchestrator.sweeping.sampling import Sampling, read_sampling, sampled
from orchestrator.sweeping.sweep_report import write_report
from orchestrator.sweeping.sweep_request import SweepRequest
from orchestrator.sweeping.variation import variation
from orchestrator.sweeping.watched_signals import WatchedSignals

GOOD = VariantResult(
    0, 0.01, {"gap_obstacle": 1.0, "gap_edge": 0.5, "r_peak": 0.4}, {"no_contact": True, "inside_road": True}
)
OUTSIDE = VariantResult(
    1, 0.01, {"gap_obstacle": 1.0, "gap_edge": -0.5, "r_peak": 0.6}, {"no_contact": True, "inside_road": False}
)
BROKEN = VariantResult(2, 0.01, {"gap_edge": 0.3}, {}, "t = 1.2 s: unit `plant`: it died", "plant: it died")


def planned(count, texts=None, samples=None):
    """A plan of `count` variants in which nothing was simulated."""
    texts = texts or {"plant.m": "0:1"}
    variations = tuple(
        variation(path, text, None if path == "plant" else Quantity("kg", "")) for path, text in texts.items()
    )
    sampling = Sampling("lhs", count) if samples is None else read_sampling(samples, None, variations)
    columns = sampled(sampling, variations, 1)
    quantities = {path: None if path == "plant" else Quantity("kg", "") for path in texts}
    scenario = SimpleNamespace(name="s", title="Something <b>bold</b>", start=0.0, h=0.1)
    return PlannedSweep(SweepRequest("s", samples=samples), sampling, variations, columns, quantities, {"": scenario})


def table_of(*results):
    plan = planned(len(results))
    return plan, results_table(plan, {r.variant: r for r in results})


def test_shares_have_wilsons_interval():
    _, table = table_of(GOOD, OUTSIDE, BROKEN)
    shares = {share.name: share for share in findings.shares(table)}
    assert (shares["finished"].holds, shares["finished"].known) == (2, 3)
    assert (shares["inside road"].holds, shares["inside road"].known) == (1, 2), "of a broken one nothing is known"
    interval = stats.binomtest(2, 3).proportion_ci(0.95, "wilson")
    assert (shares["finished"].low, shares["finished"].high) == (interval.low, interval.high)


def test_a_fault_is_worse_than_a_verdict_and_that_than_a_gap():
    near = replace_metrics(GOOD, 3, gap_edge=0.01)
    assert [r.variant for r in sorted((GOOD, near, OUTSIDE, BROKEN), key=badness)] == [2, 1, 3, 0]
    plan, table = table_of(GOOD, OUTSIDE, BROKEN, near)
    assert list(findings.ranked(plan.columns, table)["variant"]) == [2, 1, 3, 0]
    assert in_words(BROKEN) == "t = 1.2 s: unit `plant`: it died; gap_edge 0.3 m"
    assert in_words(OUTSIDE) == "inside road: no; gap_obstacle 1 m, gap_edge -0.5 m"


def replace_metrics(result, number, **metrics):
    return VariantResult(number, result.seconds, {**result.metrics, **metrics}, result.verdicts)


def test_failures_are_grouped_by_cause():
    other = VariantResult(3, 0.01, {}, {}, "t = 7.7 s: unit `plant`: it died", "plant: it died")
    _, table = table_of(GOOD, OUTSIDE, BROKEN, other)
    assert [(g.cause, g.variants) for g in findings.groups(table)] == [
        ("plant: it died", (2, 3)),
        ("not: inside road", (1,)),
    ]


def test_what_is_kept_is_asked_for_by_rank_or_by_number():
    results = {r.variant: r for r in (GOOD, OUTSIDE, BROKEN)}
    assert kept(["worst:2"], results, 3) == [2, 1]
    assert kept(["0", "worst:1"], results, 3) == [0, 2]
    assert kept(["0,1"], results, 3) == [0, 1]
    assert kept([], results, 3) == []
    for text in ("best:1", "3", "-1", "worst:", "worst"):
        with pytest.raises(RequestError, match="valid: worst:N, or numbers of variants from 0 to 2"):
            kept([text], results, 3)


def test_sobol_indices_are_those_of_a_function_whose_indices_are_known():
    # Ishigami's function: first 0.314, 0.442, 0; total 0.558, 0.442, 0.244
    paths = {f"p.x{i}": f"{-np.pi}:{np.pi}" for i in range(3)}
    plan = planned(0, paths, "saltelli:4096")
    x = np.array([[float(v) for v in values] for values in plan.columns.values()])
    y = np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])
    results = {i: VariantResult(i, 0.0, {"r_peak": float(y[i]), "same": 1.0}, {}) for i in range(len(plan))}
    found = findings.sobol_table(plan, results_table(plan, results))
    assert list(found) == ["r_peak"], "what does not vary has none"
    first, total = np.array(list(found["r_peak"].values())).T
    np.testing.assert_allclose(first, [0.3139, 0.4424, 0.0], atol=0.02)
    np.testing.assert_allclose(total, [0.5576, 0.4424, 0.2437], atol=0.02)
    assert findings.sobol_table(*table_of(GOOD)) == {}


def test_the_command_of_a_variant_says_all_that_was_asked():
    options = Options(
        mode=Version.FMI2, replacements={"plant": "a b.fmu"}, settings=["plant.m=1"], step=0.05, lenient=True,
        isolate=["plant:5"], in_process=True,
    )  # fmt: skip
    assert shlex.split(findings.command_of("static", options)) == [
        *(
            "macrostep",
            "run",
            "static",
            "--fmi",
            "2",
            "--plant",
            "a b.fmu",
            "--step",
            "0.05",
            "--lenient",
            "--in-process",
        ),
        *("--isolate", "plant:5", "--set", "plant.m=1"),
    ]
    assert findings.command_of("static", replace(options, mode="blocks")).startswith("macrostep run static --blocks ")


class Page(HTMLParser):
    """The text of a page, and how many pictures it has."""

    def __init__(self, path):
        super().__init__()
        self.text, self.pictures, self.open = "", [], []
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.pictures.append(dict(attrs)["src"])

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("broken", [0, 3, 8], ids=["none fails", "some fail", "all fail"])
@pytest.mark.parametrize("paths", [1, 2, 5])
def test_the_report_needs_no_other_file(tmp_path, broken, paths):
    texts = dict(
        [*{f"p.x{i}": "log:1:9" if i else "0:9" for i in range(paths)}.items()][: paths - 1], plant="a.fmu,b.fmu"
    )
    plan = planned(8, texts, "lhs:8")
    rows = [BROKEN if i < broken else GOOD for i in range(8)]
    results = {
        i: VariantResult(i, 0.01, {**r.metrics, "gap_edge": 0.1 * i}, r.verdicts, r.fault, r.cause)
        for i, r in enumerate(rows)
    }
    plan = replace(plan, watched=WatchedSignals({"plant.state.y": "m"}))
    course = plan.watched.taken(0, {"plant.state.y": np.arange(9.0)})
    bands = band_table(plan, {0: course})
    write_report(plan, results_table(plan, results), bands, {1: "variant-1"}, tmp_path, 2.5)
    page = Page(tmp_path / "report.html")
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    assert len(page.pictures) == 3
    assert all(source.startswith("data:image/png;base64,") for source in page.pictures)
    assert "Something <b>bold</b>: 8 variants" in page.text
    assert (f"{broken} of 8 fail" if broken else "None fails") in page.text
    assert ("Why they fail" in page.text) == (broken > 0)
    assert "macrostep run s --plant " in page.text
    assert "runs/variant-1/" in (tmp_path / "report.html").read_text()
    assert not re.findall(r"""(?:src|href)=["'](?!data:|runs/)""", (tmp_path / "report.html").read_text())


def test_a_system_without_a_road_has_a_report_as_well(tmp_path):
    plan = planned(2)
    results = {i: VariantResult(i, 0.01, {}, {}) for i in range(2)}
    write_report(plan, results_table(plan, results), band_table(plan, {}), {}, tmp_path, 1.0)
    page = Page(tmp_path / "report.html")
    assert page.pictures == []
    assert "2 of 2" in page.text
