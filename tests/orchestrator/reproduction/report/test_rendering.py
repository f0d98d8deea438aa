"""The text of the report and its page, from content that no run has to give; `test_reproduce` shows a real one."""

from __future__ import annotations

import re

import pytest
from lxml import html as lxml_html

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
    "made": "2026-11-29T10:38:06+00:00",
    "figures": [
        {"file": "figures/alone.png", "caption": "Alone.", "claims": []},
        {"file": "figures/own.png", "caption": "Own.", "claims": ["C1", "plus"]},
    ],
    "varied": None,
    "versions": {"macrostep": "1", "python": "3"},
    "timings": {"controllers": [], "states": None, "ratio_to": None},
}
NUMBERS = (DecidingNumber("p50_us", 5.0), DecidingNumber("distance", 0.5))
CASES = (
    Case({"against": "LQR"}, holds=True, measured=NUMBERS, runs=("mp", "two")),
    Case({"against": "Stanley"}, holds=False, measured=(), runs=(), note="a note", against=("r_rms", "distance")),
    Case({"against": "PP"}, holds=None, measured=(), runs=(), note="not clear"),
)
CLAIM = Verdict("C1", "it is smooth", "being smooth", CASES, ("A note.",))
UNDECIDED = Verdict("plus", "it is better", "being better", ())


VERDICTS = {"claims": [CLAIM], "goals": [UNDECIDED]}
VARIED = {
    "count": 2,
    "seed": 7,
    "plant": "bicycle_saturated",
    "figure": "figures/varied.png",
    "ranges": {},
    "controllers": [{"cases": 0}],
    "unresolved": [],
    "cases": [],
}
ON_VARIATIONS = Verdict(
    "C1", "it is smooth", "being smooth; in most", (Case({"against": "LQR"}, holds=True, measured=(), runs=()),)
)


@pytest.fixture(scope="module")
def text():
    return markdown(CONTENT, VERDICTS)


@pytest.fixture(scope="module")
def varied_text():
    return markdown({**CONTENT, "varied": VARIED}, {**VERDICTS, "varied": [ON_VARIATIONS]})


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "figures").mkdir()
    for name in ("a", "alone", "own", "varied"):
        (tmp_path / "figures" / f"{name}.png").write_bytes(b"abc")
    return tmp_path


def test_blocks_are_one_blank_line_apart_and_the_text_ends_in_one_line_end(text, varied_text):
    for one in (text, varied_text):
        assert "\n\n\n" not in one
        assert one.endswith("|\n")


def test_the_date_the_versions_and_the_seed_stand_at_the_head(text, varied_text):
    head = varied_text[: varied_text.index("## Contents")]
    assert "| date | 2026-11-29 10:38:06 UTC |\n" in head
    assert "| made by | `macrostep reproduce --varied 2 --seed 7` |\n" in head
    assert "| versions | macrostep 1, python 3 |\n" in head
    assert "| seed | 7, from which the 2 variations are drawn |\n" in head
    assert "| made by | `macrostep reproduce` |\n" in text
    assert "| seed | none: without `--varied` nothing is drawn at random |\n" in text


def test_the_contents_have_every_section_in_its_order(varied_text):
    contents = varied_text[varied_text.index("## Contents") : varied_text.index("## Verdicts")]
    sections = re.findall(r"^## (.*)$", varied_text, flags=re.MULTILINE)
    assert re.findall(r"^\* \[(.*)\]\(#.*\)$", contents, flags=re.MULTILINE) == sections[1:]
    assert sections == [
        "Contents",
        "Verdicts",
        "C1: it is smooth",
        "plus: it is better",
        "Other figures",
        "2 variations of seed 7",
        "Metrics of the runs",
        "Gains of the two-level method",
        "How to run one again",
    ]


def test_every_link_inside_the_page_leads_to_one_place(varied_text, folder):
    page = lxml_html.fromstring(html(varied_text, folder))
    places = page.xpath("//@id")
    targets = [link[1:] for link in page.xpath("//a/@href") if link.startswith("#")]
    assert len(set(places)) == len(places)
    assert set(targets) <= set(places)
    assert {"c1-it-is-smooth", "c1-on-the-variations", "metrics-of-the-runs"} <= set(targets)


def test_a_claim_is_told_in_the_readers_order(varied_text):
    at = varied_text.index("## C1: it is smooth")
    parts = (
        "**Holds against LQR (1 of 2 cases; 1 more cannot be compared).**",
        "On the variations: holds in the one case ([numbers](#c1-on-the-variations)).",
        "| case | holds | numbers | remarks | runs |",
        "**Reason.** A case holds with: being smooth.",
        "![Own.](figures/own.png)",
        "## plus: it is better",
    )
    places = [varied_text.index(part, at) for part in parts]
    assert places == sorted(places)


def test_a_figure_stands_once_and_the_other_claims_refer_to_it(text):
    assert text.count("(figures/own.png)") == text.count("(figures/alone.png)") == 1
    goal = text[text.index("## plus: it is better") : text.index("## Other figures")]
    assert "See also, with [C1](#c1-it-is-smooth): *Own.*\n" in goal
    assert "## Other figures\n\n![Alone.](figures/alone.png)\n\n*Alone.*\n" in text
    with_known = {**CONTENT, "figures": CONTENT["figures"][1:]}
    assert "## Other figures" not in markdown(with_known, VERDICTS)
    of_unknown = {**CONTENT, "figures": [{"file": "figures/x.png", "caption": "X.", "claims": ["C9"]}]}
    assert "## Other figures\n\n![X.](figures/x.png)" in markdown(of_unknown, VERDICTS)


def test_a_verdict_stands_in_a_table_and_with_the_cases_that_decide_it(text):
    outcome = "holds against LQR (1 of 2 cases; 1 more cannot be compared)"
    assert f"| [C1](#c1-it-is-smooth) | it is smooth | {outcome} |\n" in text
    section = text[text.index("## C1: it is smooth") : text.index("![Own.]")]
    assert section == (
        "## C1: it is smooth\n\n"
        "**Holds against LQR (1 of 2 cases; 1 more cannot be compared).**\n\n"
        "| case | holds | numbers | remarks | runs |\n"
        "| --- | --- | --- | --- | --- |\n"
        "| LQR | yes | largest distance [m]: 0.5; time per sample, p50 [us]: 5 |  "
        "| [mp](runs/mp/), [two](runs/two/) |\n"
        "| Stanley | no |  | a note; against it: rms r [rad/s], largest distance [m] |  |\n"
        "| PP | cannot be compared |  | not clear |  |\n\n"
        "**Reason.** A case holds with: being smooth. Where it does not hold, this speaks against it: "
        "rms r [rad/s] (1 case), largest distance [m] (1 case).\n\n"
        "A note.\n\n"
    )


def test_a_verdict_without_cases_has_no_table(text):
    assert (
        "## plus: it is better\n\n**Not decided: no case.**\n\n**Reason.** A case holds with: being better.\n" in text
    )


def test_the_page_follows_the_light_or_dark_setting_of_the_screen(text, folder):
    style = html(text, folder).partition("</style>")[0]
    assert "color-scheme: light dark;" in style
    assert "@media screen and (prefers-color-scheme: dark)" in style


def test_two_reports_with_the_same_content_differ_in_their_date_only(text):
    later = markdown({**CONTENT, "made": "2027-01-01T00:00:00+00:00"}, VERDICTS)
    differing = [(a, b) for a, b in zip(text.splitlines(), later.splitlines(), strict=True) if a != b]
    assert differing == [("| date | 2026-11-29 10:38:06 UTC |", "| date | 2027-01-01 00:00:00 UTC |")]


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
    timed = markdown({**CONTENT, "timings": timings}, VERDICTS)
    assert "## Time per sample" not in text
    assert "on the states of `mp`; ratios to `mpc`." in timed
    assert "| `mpc` | FMU | 5.0 | 9.0 | 1 | 0.5 |\n\n## How to run one again\n" in timed


def test_a_fault_is_text_in_the_page_whatever_it_says(text, folder):
    page = html(text, folder)
    assert "LQR (ended in a fault: x < 0 & <b>y</b>)" in text
    assert "LQR (ended in a fault: x &lt; 0 &amp; &lt;b&gt;y&lt;/b&gt;)" in page


def test_figures_stand_in_the_page_and_tables_may_scroll(folder):
    page = html("![A figure.](figures/a.png)\n\n| a |\n| --- |\n| b |\n", folder)
    assert '<img src="data:image/png;base64,YWJj" alt="A figure."' in page
    assert '<div class="wide"><table>' in page
    assert "</table></div>" in page
