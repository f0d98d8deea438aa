"""What the sources cite is there: a clone of the repository can follow every reference."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RESOLUTIONS = ROOT / "orchestrator" / "scenarios" / "RESOLUTIONS.md"
KINDS = {".py", ".toml", ".md", ".mo", ".c", ".h", ".html"}
FOLDERS = ("components", "fmus", "orchestrator", "tests")
FILES = sorted(
    path
    for path in [*ROOT.glob("*.md"), *(p for folder in FOLDERS for p in (ROOT / folder).rglob("*"))]
    if path.suffix in KINDS and path.is_file() and "built" not in path.relative_to(ROOT).parts
)

ITEM = r"\d+(?: \([^)]*\))?"
CITATION = re.compile(rf"RESOLUTIONS ({ITEM}(?:(?:,| and|, and) {ITEM})*)")


def cited(text: str) -> list[int]:
    """The numbers in all citations of a text; each may have a word in parentheses behind it."""
    found = CITATION.findall(" ".join(text.split()))
    return [int(n) for numbers in found for n in re.findall(r"\d+", re.sub(r"\([^)]*\)", "", numbers))]


CITED = {path.relative_to(ROOT).as_posix(): numbers for path in FILES if (numbers := cited(path.read_text("utf-8")))}
ROWS = [int(n) for n in re.findall(r"^\| (\d+) \|", RESOLUTIONS.read_text("utf-8"), re.MULTILINE)]


def test_the_resolutions_are_numbered_from_one():
    assert list(range(1, len(ROWS) + 1)) == ROWS
    assert len(ROWS) >= 25


@pytest.mark.parametrize("name", CITED)
def test_every_resolution_that_is_cited_exists(name):
    assert [n for n in CITED[name] if n not in ROWS] == []


def test_citations_are_found_in_all_their_forms():
    assert cited("(RESOLUTIONS 15)") == [15]
    assert cited("RESOLUTIONS 1, 2 and 10") == [1, 2, 10]
    assert cited("RESOLUTIONS 1 (factor 2), 2 (I_z), 10 and 11.") == [1, 2, 10, 11]
    assert cited("corrections RESOLUTIONS 23,\n    24).") == [23, 24]
    assert sum(map(len, CITED.values())) >= 40


def test_no_source_cites_a_document_that_is_not_in_the_repository():
    outside = re.compile(r"`facts\b|\bfacts/|\bshared/|DESIGN section|house\.md|STYLE\.md")
    here = Path(__file__).resolve()
    assert [p.relative_to(ROOT).as_posix() for p in FILES if p != here and outside.search(p.read_text("utf-8"))] == []
