"""XML that is broken, or meant to do harm, is refused before anything of it is used."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.reading import xml_documents
from fmus.reading.xml_documents import parse_xml


def xml_refusal(content):
    with pytest.raises(RequestError) as error:
        parse_xml(content, "a.xml", "XML")
    return str(error.value)


def test_xml_that_is_not_well_formed_is_refused_with_its_line():
    assert parse_xml(b"<a><b/></a>", "a.xml", "XML").tag == "a"
    assert xml_refusal(b"<a>\n<b>\n</a>") == (
        "a.xml, line 3: found XML that is not well-formed (Opening and ending tag mismatch: b line 2 and a); valid: XML"
    )
    assert xml_refusal(b"") == "a.xml, line 1: found XML that is not well-formed (Document is empty); valid: XML"


@pytest.mark.parametrize("content", [b'<a b="%s"/>' % (b"x" * 11_000_000), b"<a>%s</a>" % (b"x" * 11_000_000)])
def test_attributes_and_texts_may_be_long(content):
    assert parse_xml(content, "a.xml", "XML").tag == "a"


@pytest.mark.parametrize("depth", [257, 3000])
@pytest.mark.parametrize("text", [b"", b"x" * 11_000_000])
def test_documents_that_are_nested_too_deeply_are_refused(depth, text):
    assert xml_refusal(text.join((b"<a>" * depth, b"</a>" * depth))) == (
        "a.xml: found more than 256 elements inside each other; valid: XML"
    )


def test_documents_beyond_all_reason_are_refused(monkeypatch):
    monkeypatch.setattr(xml_documents, "LARGEST_XML", 2**20)
    assert xml_refusal(b" " * (3 * 2**20)) == "a.xml: found 3 MiB of XML; valid: at most 1 MiB of XML in one file"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_long_document_may_not_declare_entities_either(encoding):
    text = f'<!DOCTYPE a [<!ENTITY l0 "ha">{LAUGHS}]><a b="{"x" * 11_000_000}" c="&l9;"/>'
    assert xml_refusal(text.encode(encoding)) == (
        "a.xml: found a document type declaration (DTD), whose entities could expand without end; valid: XML"
    )


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(12))


@pytest.mark.parametrize(
    "content",
    [
        f'<!DOCTYPE a [<!ENTITY l0 "ha">{LAUGHS}]><a b="&l12;">&l12;</a>',
        f'<!DOCTYPE a [<!ENTITY l0 "ha">{LAUGHS}]><a>&l12;</a>',
        '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>',
        '<!DOCTYPE a SYSTEM "http://localhost:1/a.dtd"><a/>',
    ],
)
def test_document_type_declarations_are_refused(content):
    assert xml_refusal(content.encode()) == (
        "a.xml: found a document type declaration (DTD), whose entities could expand without end; valid: XML"
    )


def test_many_elements_and_attributes_are_refused_before_they_are_read():
    many = b"<a>" + b"<b/>" * 5_000_000 + b"</a>"
    assert xml_refusal(many) == (
        "a.xml: found XML whose elements would take 591 MiB of memory; valid: at most 512 MiB."
        " Export a smaller part of the model."
    )
    assert xml_refusal(many.decode().encode("utf-16")).startswith("a.xml: found XML whose elements would take 6")
    assert "would take" in xml_refusal(b"<a>" + b"<b c='' d=''/>" * 1_100_000 + b"</a>")


@pytest.mark.parametrize(
    ("content", "found"),
    [
        ('<?xml version="1.0" encoding="UTF-7"?><a/>'.encode("utf-7"), "XML in the encoding `UTF-7`"),
        (f'<?xml version="1.0" {" " * 500} encoding="cp037"?><a/>'.encode(), "XML in the encoding `cp037`"),
        (f'<?xml version="1.0" {" " * 5000} encoding="cp037"?><a/>'.encode(), "an XML declaration without an end"),
        ('<?xml version="1.0"?><a/>'.encode("cp037"), "XML in EBCDIC"),
    ],
)
def test_encodings_in_which_elements_cannot_be_counted_are_refused(content, found):
    assert xml_refusal(content) == f"a.xml, line 1: found {found}; valid: XML in UTF-8, as the standard asks"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1", "windows-1252", "gb18030"])
def test_other_encodings_are_read(encoding):
    declared = encoding.replace("-sig", "")
    content = f'<?xml version="1.0" encoding="{declared}"?><a b="x"/>'.encode(encoding)
    assert parse_xml(content, "a.xml", "XML").get("b") == "x"
