"""Texts that others wrote enter in one line, without what a terminal would obey, and to the lengths of `limits.py`."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.toolchain.foreign_text import plain, printed
from fmus.toolchain.limits import LONGEST_MESSAGE


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("too hot", "too hot"),
        (b"caf\xc3\xa9 \xff", "café \ufffd"),
        (None, ""),
        ("two\nlines\tand\r\n blanks ", "two lines and blanks"),
        ("\x1b[2J\x1b]0;title\x07", "\\x1b[2J\\x1b]0;title\\x07"),
        ("\x9b31m\u202e\ud800", "\\x9b31m\\u202e\\ud800"),
        ("[bold]not ours to escape[/bold]", "[bold]not ours to escape[/bold]"),
        ("x" * 500, "x" * 400 + " ..."),
        ("x " + " " * 10_000_000, "x ..."),
    ],
)
def test_a_text_is_a_line_of_what_is_seen(text, shown):
    assert plain(text) == shown


@given(st.one_of(st.text(), st.binary()))
def test_any_text_is_printable_and_bounded(text):
    shown = plain(text)
    assert shown.isprintable()
    assert len(shown) <= 10 * LONGEST_MESSAGE


def test_what_is_printed_keeps_its_lines():
    assert printed("a\tb\n\x1b[31mred\r\n") == "a\tb\n\\x1b[31mred\\r\n"
