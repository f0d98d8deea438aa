"""The page and the JSON of a passport; the page is also looked at, in a browser."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from lxml import etree

from orchestrator.exchange.passport.passport import Passport
from orchestrator.exchange.passport.passport_comparison import compared_with
from orchestrator.exchange.passport.passport_line import Measured, Topic
from orchestrator.exchange.passport.passport_page import page, write_passport
from tests.orchestrator.chromium import PROGRAM, Chromium

LINES = (
    Topic("rules.fmpy", "FMPy's validator finds no problem").passes("0 problems"),
    Topic("cost.time", "A step takes less time than it simulates").passes("1 us", {"median": Measured(1.0, "us")}),
    Topic("cost.memory", "Memory does not grow").judged([f"`v{i}` <leaks>" for i in range(5)], ""),
    Topic("smoke.carried", "The smoke tests").does_not_apply("it carries none"),
)
PROVENANCE = {
    "versions": {"macrostep": "1"},
    "machine": {"platform": "x", "system": "L", "processor": "p", "cores": 2},
    "made": "now",
    "duration": {"value": 1.0, "unit": "s"},
}
MADE = Passport({"file": "m<1>.fmu", "size": 3, "maker": None, "sha256": "00"}, LINES, PROVENANCE)


def texts(html):
    root = etree.fromstring(html, etree.HTMLParser())
    return " ".join(" ".join(root.xpath("//body//text()")).split()), root


def test_the_page_says_what_the_passport_says():
    text, root = texts(page(MADE))
    assert text.startswith("m<1>.fmu 1 of 4 lines fails , 2 pass, 1 does not apply.")
    assert "v0 <leaks>; v1 <leaks>; v2 <leaks>; and 2 more" in text
    assert [e.text for e in root.xpath("//h2")] == ["What it is", "Rules of FMI", "Cost", "Tests that it carries"]
    assert root.xpath("//code/text()")[0] == "v0"
    assert len(root.xpath("//details/ul/li")) == 5
    assert root.xpath("//a/@href") == ["#cost.memory"]
    assert root.xpath("//tr[@id='cost.memory']")
    assert "not told maker" in text


def test_a_page_without_failing_lines_says_so():
    text, _ = texts(page(replace(MADE, lines=LINES[:2])))
    assert text.startswith("m<1>.fmu No line fails : 2 pass, 0 do not apply.")


def test_the_page_needs_no_other_file():
    html = page(replace(MADE, pictures=(b"PNG",), lines=(*LINES, Topic("drive.finishes", "It drives").passes("yes"))))
    _, root = texts(html)
    sources = root.xpath("//img/@src | //link/@href | //script/@src")
    assert sources == ["data:image/png;base64,UE5H"]


def test_both_files_are_written_and_hold_the_comparison(tmp_path):
    better = replace(MADE, lines=(LINES[0], LINES[1], replace(LINES[2], mark=LINES[0].mark), LINES[3]))
    comparison = compared_with(MADE.data(), better.data())
    files = write_passport(better, tmp_path / "new", "m", comparison)
    assert [file.name for file in files] == ["m.passport.html", "m.passport.json"]
    data = json.loads(files[1].read_text())
    assert data["against"]["lines"] == [
        {"key": "cost.memory", "before": "fails", "after": "passes", "change": "better"}
    ]
    assert (
        "Against m<1>.fmu, measured now line before now better Memory does not grow fails passes"
        in texts(files[0].read_text())[0]
    )
    write_passport(MADE, tmp_path / "new", "m")
    assert "against" not in json.loads(files[1].read_text())


@pytest.mark.skipif(PROGRAM is None, reason="no Chromium")
def test_the_page_is_seen_in_a_browser(tmp_path):
    html, _ = write_passport(MADE, tmp_path, "m")
    with Chromium(tmp_path / "profile") as browser:
        browser.open(html.as_uri())
        seen = browser.picture(until=lambda p: p.std() > 10)
    red, green = (
        (np.abs(seen - np.array(colour)).max(axis=2) < 6).sum() for colour in ((249, 218, 218), (223, 241, 228))
    )
    assert red > 200
    assert green > 400
