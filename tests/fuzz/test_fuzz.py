"""Damaged files of every kind are refused in words: a short, seeded form of `python -m tests.fuzz`."""

from __future__ import annotations

from random import Random

import pytest

from tests.fuzz.broken import KINDS as KINDS_OF_TEST
from tests.fuzz.campaign import Campaign
from tests.fuzz.kinds import KINDS, write
from tests.fuzz.trees import json_damaged, toml_damaged, xml_damaged
from tests.fuzz.worker import judged
from tests.fuzz.zips import packed, zip_damaged

SLOW = {"modelica": 15, "run_folder": 6, "rrd": 10, "ssd": 30, "ssv_ssm_ssb": 30, "annotation": 30}
"""How many inputs there are of the kinds that are not read at once."""
REFUSED = {("modelica", 1)}
"""What is in order for its language, and refused all the same."""


@pytest.fixture(scope="session")
def sound():
    """What is in order, of each kind; made once."""
    made = {}
    return lambda kind: made.setdefault(kind.name, kind.seeds())


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_damaged_files_are_refused_in_words(kind, tmp_path):
    tally = Campaign(kind, 1, tmp_path).run(count=SLOW.get(kind.name, 60), jobs=1)
    assert {where: (found.what, found.numbers) for where, found in tally.found.items()} == {}
    assert tally.outcomes["refused"] > 0 or kind.name == "rrd"


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_what_they_are_made_from_is_in_order(kind, sound, tmp_path):
    for number, files in enumerate(sound(kind)):
        write(files, tmp_path / str(number))
        expected = "refused" if (kind.name, number) in REFUSED else "accepted"
        assert judged(kind, tmp_path / str(number)) == {"outcome": expected}


def test_what_fails_dies_or_hangs_is_counted_and_its_smallest_input_kept(tmp_path):
    tally = Campaign(KINDS_OF_TEST["broken"], 1, tmp_path, "tests.fuzz.broken").run(count=30, jobs=2)
    counts = {name: tally.outcomes[name] for name in ("accepted", "refused", "unworded", "died", "hung")}
    expected = Campaign(KINDS_OF_TEST["broken"], 1, tmp_path, "tests.fuzz.broken")
    words = [expected.input(number)["a.txt"].decode().partition(" ")[0] for number in range(30)]
    begins = ("fine", "refused", "fails", "dies", "hangs")
    assert counts == dict(zip(counts, (words.count(word) for word in begins), strict=True))
    assert min(counts.values()) > 0
    assert [where.partition(" at ")[0] for where in sorted(tally.found)] == ["KeyError", "SIGSEGV", "a hang"]
    kept = {where.partition(" at ")[0]: (found.smallest / "a.txt").read_text() for where, found in tally.found.items()}
    assert kept == {"KeyError": "fails", "SIGSEGV": "dies", "a hang": "hangs"}
    assert all(
        words[number] == "fails" for where in tally.found if "Key" in where for number in tally.found[where].numbers
    )


@pytest.mark.parametrize("damage", [xml_damaged, json_damaged, toml_damaged])
def test_an_input_follows_from_its_number_alone(damage):
    content = {xml_damaged: b'<a b="c"><d/></a>', json_damaged: b'{"a": [1]}', toml_damaged: b"a = 1\nb = 'c'\n"}[
        damage
    ]
    made = [damage(content, Random(f"1 {number}"), [content]) for number in (1, 2, 1)]  # noqa: S311 - it shall be repeatable
    assert made[0] == made[2] != made[1]


def test_archives_are_damaged_in_their_structure():
    files = {"a.xml": b"<a/>" * 50, "b/c.txt": b"text"}
    made = {zip_damaged(files, Random(number)) for number in range(50)}  # noqa: S311 - as above
    assert len(made) > 40
    assert packed(files) == packed(files)
