"""The breaches of an XML schema in a document, of which a hostile one may have any number.

lxml notes at each breach the place of its element among its siblings, which takes time in proportion to their number:
100 000 breaches in one list would take hours. A long document is therefore counted through by a parser first, and
where it has too many breaches, only the part up to these is validated.
"""
# pyright: basic
# lxml carries few types for schemas and logs; everything that leaves this file is annotated.

from __future__ import annotations

from threading import Thread
from typing import Any, Final

from lxml import etree

from fmus.toolchain.limits import MOST_BREACHES

_LONG: Final = 10_000
"""The number of elements from which on a document is counted through first."""
_CHUNK: Final = 2**14


def schema_breaches(root: Any, schema: etree.XMLSchema) -> list[tuple[int, str]]:
    """The breaches of a schema, each as its line and what lxml says of it; of very many the first `MOST_BREACHES`.

    Args:
        root: The root element of the document, or of one that stands inside another.
        schema: The schema.
    """
    first = root.sourceline or 1
    if root.xpath("count(//*) > $long", long=_LONG):
        content = etree.tostring(root, with_tail=False)
        if (end := _end_of_most(content, schema)) is not None:
            parser = etree.XMLParser(recover=True, huge_tree=True, resolve_entities=False, no_network=True)
            cut = etree.fromstring(content[:end], parser)
            return [(line + first - 1, text) for line, text in _validated(cut, schema)[:MOST_BREACHES]]
    return _validated(root, schema)


def _validated(root: Any, schema: etree.XMLSchema) -> list[tuple[int, str]]:
    return [] if schema.validate(root) else [(e.line, e.message) for e in schema.error_log]


class _Count(etree.PyErrorLog):
    """The number of errors that a parser finds, which lxml hands over one by one to nobody else."""

    def __init__(self) -> None:
        super().__init__()
        self.number = 0

    def log(self, *_: Any) -> None:
        """Count one."""
        self.number += 1


class _Nothing:
    """The target of a parser that keeps nothing of what it reads."""

    def close(self) -> None:
        """The end of the document."""


def _end_of_most(content: bytes, schema: etree.XMLSchema) -> int | None:
    """Where a document has more than `MOST_BREACHES`, as a position in it; None where it has fewer in all."""
    ends: list[int] = []

    def count() -> None:
        counted = _Count()
        etree.use_global_python_log(counted)  # of this thread alone
        parser = etree.XMLParser(target=_Nothing(), schema=schema, huge_tree=True)  # pyright: ignore[reportArgumentType]
        for at in range(0, len(content), _CHUNK):
            parser.feed(content[at : at + _CHUNK])
            if counted.number > MOST_BREACHES:
                ends.append(at + _CHUNK)
                return

    thread = Thread(target=count)
    thread.start()
    thread.join()
    return ends[0] if ends else None
