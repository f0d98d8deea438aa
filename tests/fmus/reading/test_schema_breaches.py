"""Breaches of a schema, few and very many."""

from __future__ import annotations

from lxml import etree

from fmus.reading.schema_breaches import schema_breaches
from fmus.toolchain.fmpy_library import description_schema
from fmus.toolchain.limits import MOST_BREACHES
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, scalar

SCHEMA = description_schema(Version.FMI2)
WRONG = "Element 'Unknown', attribute 'index': 'x' is not a valid value of the atomic type 'xs:unsignedInt'."


def found(unknowns):
    text = description2([scalar("y", 1, "output")], unknowns)
    return schema_breaches(etree.fromstring(text.encode()), SCHEMA)


def test_a_document_that_keeps_the_rules_has_none():
    assert found(['<Unknown index="1"/>']) == []
    assert found(['\n<Unknown index="1"/>'] * 20_000) == []


def test_each_has_its_line_also_in_a_long_document():
    good = '\n<Unknown index="1"/>'
    assert found([good, '\n<Unknown index="x"/>']) == [(10, WRONG)]
    assert {line for line, _ in found([good] * 12_000 + ['\n<Unknown index="x"/>'])} == {12_009}


def test_of_very_many_the_first_are_told_in_no_time():
    """Validated as a whole, this document would take hours."""
    many = found(['\n<Unknown index="1"/>'] * 20 + ['\n<Unknown index="x"/>'] * 300_000)
    assert (len(many), many[0]) == (MOST_BREACHES, (29, WRONG))
