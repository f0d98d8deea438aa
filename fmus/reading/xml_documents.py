"""XML documents of other makers, parsed; what is broken or could do harm is refused with a message."""

from __future__ import annotations

import re
from typing import Any, Final

from lxml import etree

from components.interfaces.problem import RequestError, refuse
from fmus.toolchain.door import reading
from fmus.toolchain.limits import DEEPEST_XML, LARGEST_TREE, LARGEST_XML

_CHUNK: Final = 2**16
_DOCUMENT_TYPE: Final = "a document type declaration (DTD), whose entities could expand without end"
_TOO_DEEP: Final = f"more than {DEEPEST_XML} elements inside each other"
_ELEMENT: Final = 120
"""[byte] About what libxml2 needs for an element, a text or a comment."""
_ATTRIBUTE: Final = 220
"""[byte] About what it needs for an attribute with its value."""
_ENCODINGS: Final = re.compile(
    r"utf[-_]?8|utf[-_]?16([-_]?[lb]e)?|us-ascii|ascii|iso[-_]?8859[-_]?\d+|latin[-_]?1|windows-125\d|cp125\d"
    r"|koi8-[ru]|gb2312|gbk|gb18030|big5|shift_jis|euc-(jp|kr|cn|tw)",
    re.IGNORECASE,
)
"""Encodings in which `<` and `=` are what they are in ASCII, so that they can be counted."""
_DECLARED: Final = re.compile(rb"\sencoding\s*=\s*[\"']([^\"'>]*)")
_LONGEST_DECLARATION: Final = 1000
"""[byte]"""
_EBCDIC: Final = b"Lo\xa7\x94"
"""`<?xm` in that encoding."""
_UTF8: Final = "XML in UTF-8, as the standard asks"


def parse_xml(content: bytes, where: str, valid: str) -> Any:
    """The root element of an XML document.

    Documents with a document type declaration are refused: neither FMI nor SSP has one, and its entities may expand
    without end or refer to other files. Texts and attributes may be as long as the document: the start value of an
    array is one attribute.

    Args:
        content: The document.
        where: The document, as messages name it.
        valid: What it should be, as messages say it.

    Raises:
        RequestError: The document is not well-formed, in which case the message has the line, has a document type
            declaration, or is too large or nested too deeply.
    """
    _refuse_what_takes_much(content, where)
    parser = _parser(huge_tree=False)
    with reading(where, valid):
        try:
            root = etree.fromstring(content, parser)
        except (etree.XMLSyntaxError, ValueError) as error:
            errors = parser.error_log.filter_from_errors()
            if _has_document_type(content):
                raise refuse(where, _DOCUMENT_TYPE, valid) from error
            if not errors or errors[0].type_name != "ERR_RESOURCE_LIMIT":
                raise _not_well_formed(error, errors, where, valid) from error
            root = _large(content, where, valid)
        if root.getroottree().docinfo.internalDTD is not None:
            raise refuse(where, _DOCUMENT_TYPE, valid)
        return root


def tree_size(content: bytes) -> int:
    """[byte] What the elements, texts and attributes of a document will take in memory, at most."""
    return len(content) + _ELEMENT * content.count(b"<") + _ATTRIBUTE * content.count(b"=")


def _refuse_what_takes_much(content: bytes, where: str) -> None:
    """Refuse a document that is too large, also in the memory that it would take, before it is parsed."""
    if len(content) > LARGEST_XML:
        found = f"{len(content) / 2**20:.0f} MiB of XML"
        raise refuse(where, found, f"at most {LARGEST_XML / 2**20:.0f} MiB of XML in one file")
    if content.startswith(_EBCDIC):
        raise refuse(f"{where}, line 1", "XML in EBCDIC", _UTF8)
    declaration = content[: max(0, content.find(b"?>", 0, _LONGEST_DECLARATION))]
    if content.startswith(b"<?xml") and not declaration:
        raise refuse(f"{where}, line 1", "an XML declaration without an end", _UTF8)
    declared = _DECLARED.search(declaration)
    if declared is not None and not _ENCODINGS.fullmatch(named := declared[1].decode("latin-1")):
        raise refuse(f"{where}, line 1", f"XML in the encoding `{named}`", _UTF8)
    if (size := tree_size(content)) > LARGEST_TREE:
        found = f"XML whose elements would take {size / 2**20:.0f} MiB of memory"
        raise refuse(where, found, f"at most {LARGEST_TREE / 2**20:.0f} MiB", "Export a smaller part of the model.")


def _parser(*, huge_tree: bool) -> Any:
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=huge_tree)


def _large(content: bytes, where: str, valid: str) -> Any:
    """The root element of a document, without entities, that is beyond the usual limits of the parser."""
    parser = _parser(huge_tree=True)
    try:
        root = etree.fromstring(content, parser)
    except etree.XMLSyntaxError as error:
        errors = parser.error_log.filter_from_errors()
        if errors and errors[0].type_name == "ERR_RESOURCE_LIMIT":
            raise refuse(where, _TOO_DEEP, valid) from error
        raise _not_well_formed(error, errors, where, valid) from error
    if root.xpath(f"boolean(/*{'/*' * DEEPEST_XML})"):
        raise refuse(where, _TOO_DEEP, valid)
    return root


def _has_document_type(content: bytes) -> bool:
    """Whether there is a document type declaration, which can only stand before the root element."""
    parser = etree.XMLPullParser(("start",), resolve_entities=False, no_network=True, load_dtd=False)
    try:
        for at in range(0, len(content), _CHUNK):
            parser.feed(content[at : at + _CHUNK])
            for _, root in parser.read_events():
                return root.getroottree().docinfo.internalDTD is not None
    except etree.XMLSyntaxError:
        pass
    return any("<!DOCTYPE".encode(encoding) in content for encoding in ("utf-8", "utf-16-le", "utf-16-be"))


def _not_well_formed(error: Exception, errors: Any, where: str, valid: str) -> RequestError:
    line = getattr(error, "lineno", None)
    reason = errors[0].message if errors else str(error)  # the exception has the line in its message too
    return refuse(f"{where}, line {line}" if line else where, f"XML that is not well-formed ({reason.strip()})", valid)
