"""The text of the report and its page, from content that no run has to give; `test_reproduce` shows a real one."""

from __future__ import annotations

import pytest

from orchestrator.reproduction.paper.verdict import Case, DecidingNumber, Verdict
from orchestrator.reproduction.report.rendering import html, markdown

RUN = {
    "name": "mp",
    "label": "MP tuned",
    "plant": "bicycle",
    "role": "mp",
    "command": "macrostep run static",
    "folder": "runs/mp",
    "recording": "runs/mp/recording.rrd",
    "status": "finished",
    "fault": None,
    "metrics": {"v_x_min": 9.8, "v_x_max": 10.0},
    "remarks": [],
}
FAULTY = {
    **RUN,
    "name": "two",
    "folder": "runs/two",
    "label": "LQR",
    "status": "fault",
    "fault": {"reason": "x < 0 & <b>y</b>"},
    "metrics": {"v_x_min": 3.0},
    "remarks": ["one", "two"],
}
CONTENT = {
    "runs": [RUN, FAULTY],
    "figures": [],
    "varied": None,
    "versions": {"macrostep": "1", "python": "3"},
    "timings": {"controllers": [], "states": None, "ratio_to": None},
}
NUMBERS = (DecidingNumber("p50_us", 5.0), DecidingNumber("distance", 0.5))
CASES = (
    Case({"against": "LQR"}, holds=True, measured=NUMBERS, runs=("mp", "two")),
    Case({"against": "PP"}, holds=None, measured=(), runs=(), note="not clear"),
)
CLAIM = Verdict("C1", "it is smooth", "being smooth", CASES, ("A note.",))
UNDECIDED = Verdict("plus", "it is better", "being better", ())


@pytest.fixture(scope="module")
def text():
    return markdown(CONTENT, {"claims": [CLAIM], "goals": [UNDECIDED]})


def test_blocks_are_one_blank_line_apart_and_the_text_ends_in_one_line_end(text):
    assert "\n\n\n" not in text
    assert text.endswith("Versions: macrostep 1, python 3.\n")


def test_a_verdict_stands_in_a_table_and_with_the_cases_that_decide_it(text):
    assert "| C1 | it is smooth | **holds** |  | PP |\n" in text
    details = text[text.index("### C1: it is smooth") : text.index("## Beyond the paper")]
    assert details == (
        "### C1: it is smooth\n\n"
        "**Holds**. A case holds with: being smooth.\n\n"
        "| case | holds | numbers |  | runs |\n"
        "| --- | --- | --- | --- | --- |\n"
        "| LQR | yes | largest distance [m]: 0.5; time per sample, p50 [us]: 5 |  "
        "| [mp](runs/mp/), [two](runs/two/) |\n"
        "| PP | cannot be compared |  | not clear |  |\n\n"
        "A note.\n\n"
    )


def test_a_verdict_without_cases_has_no_table(text):
    assert "**Not decided**. A case holds with: being better.\n\n## Metrics of the runs\n" in text


def test_the_metrics_that_runs_have_stand_beside_their_recordings(text):
    assert "### Limits and speed\n\n| run |  | plant | least v_x [m/s] | largest v_x [m/s] | recording |\n" in text
    assert "| [mp](runs/mp/) | MP tuned | bicycle | 9.8 | 10 | [open](runs/mp/recording.rrd) |\n" in text
    assert "| bicycle | 3 | - | [open]" in text
    assert "### Smoothness" not in text


def test_remarks_stand_beside_the_command(text):
    assert "| [two](runs/two/) | `macrostep run static` | one; two |\n" in text


def test_times_have_their_own_section_if_there_are_any(text):
    timing = {"controller": "mpc", "way": "FMU", "p50_us": 5.04, "p99_us": 9.0, "ratio_p50": 1.0, "ratio_p99": 0.5}
    timings = {"controllers": [timing], "states": "mp", "ratio_to": "mpc"}
    timed = markdown({**CONTENT, "timings": timings}, {"claims": [CLAIM], "goals": [UNDECIDED]})
    assert "## Time per sample" not in text
    assert "on the states of `mp`; ratios to `mpc`." in timed
    assert "| `mpc` | FMU | 5.0 | 9.0 | 1 | 0.5 |\n\n## How to run one again\n" in timed


def test_a_fault_is_text_in_the_page_whatever_it_says(text, tmp_path):
    page = html(text, tmp_path)
    assert "LQR (ended in a fault: x < 0 & <b>y</b>)" in text
    assert "LQR (ended in a fault: x &lt; 0 &amp; &lt;b&gt;y&lt;/b&gt;)" in page


def test_figures_stand_in_the_page_and_tables_may_scroll(tmp_path):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "a.png").write_bytes(b"abc")
    page = html("![A figure.](figures/a.png)\n\n| a |\n| --- |\n| b |\n", tmp_path)
    assert '<img src="data:image/png;base64,YWJj" alt="A figure."' in page
    assert '<div class="wide"><table>' in page
    assert "</table></div>" in page
