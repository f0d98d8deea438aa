"""The schemas of SSP 1.0 are there, and judge."""

from __future__ import annotations

import pytest
from lxml import etree

from fmus.toolchain.ssp_schemas import schema, schema_folder


@pytest.mark.parametrize("kind", ["Description", "ParameterValues", "ParameterMapping", "SignalDictionary"])
def test_every_kind_of_document_has_a_schema_that_judges(kind):
    name = f"SystemStructure{kind}.xsd"
    assert (schema_folder() / name).is_file()
    assert not schema(name).validate(etree.fromstring("<a/>"))
    assert schema(name) is schema(name)
