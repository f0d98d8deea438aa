"""Texts that others wrote, such as the messages of an FMU: in one line, without control characters, and bounded.

This is where such texts enter. What a terminal takes for markup is not changed here: whoever writes to one escapes it.
"""

from __future__ import annotations

from typing import Final

from fmus.toolchain.limits import LONGEST_MESSAGE

_READ_PER_SHOWN: Final = 4
"""The characters that are looked at for each that is kept; the others may be blanks."""


def plain(text: str | bytes | None, longest: int = LONGEST_MESSAGE) -> str:
    """A foreign text for a person: one line, in which other characters than those that are seen stand as escapes.

    Args:
        text: The text, or its bytes, which need not be UTF-8; None is no text.
        longest: What is kept of it [characters].
    """
    if text is None:
        return ""
    begin = text[: _READ_PER_SHOWN * longest]
    if isinstance(begin, bytes):
        begin = begin.decode("utf-8", "replace")
    line = " ".join(begin.split())
    line = escaped(line)
    return line if len(line) <= longest and len(text) <= _READ_PER_SHOWN * longest else f"{line[:longest]} ..."


def printed(text: str) -> str:
    """What a foreign process prints, for a terminal: its lines, in which control characters stand as escapes."""
    return escaped(text, kept="\n\t")


def escaped(text: str, kept: str = "") -> str:
    """A text in which no character can command a terminal, or change the direction of others: these stand as escapes.

    Args:
        text: The text.
        kept: Characters that stay as they are, though nobody sees them.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in kept else c.encode("unicode_escape").decode() for c in text)
