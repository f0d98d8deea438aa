"""Whatever a parser or a library throws on a file of another maker becomes a refusal, which names the exception."""

from __future__ import annotations

import json
import lzma

import pytest

from components.interfaces.problem import RequestError, refuse
from fmus.toolchain.door import exception_in_words, reading


def refusal(raises) -> str:
    with pytest.raises(RequestError) as refused, reading("a.fmu, line 3", "a number", "Write one."):
        raises()
    return str(refused.value)


@pytest.mark.parametrize(
    ("raises", "found"),
    [
        (lambda: float("low"), "something that cannot be read (ValueError: could not convert string to float: 'low')"),
        (lambda: {}["x"], "something that cannot be read (KeyError: 'x')"),
        (lambda: lzma.decompress(b"x" * 40), "something that cannot be read (LZMAError: Input format not supported"),
        (lambda: json.loads("[" * 100_000), "something that is nested too deeply (RecursionError: maximum recursion"),
        (b"\xff".decode, "bytes that are no text in its encoding (UnicodeDecodeError: 'utf-8' codec can't"),
        (lambda: open("x" * 300).close(), "something that the system refuses (OSError: "),  # noqa: PTH123
        (lambda: bytearray(2**62), "something that takes more memory than there is (MemoryError"),
    ],
)
def test_an_exception_becomes_a_refusal_with_its_kind_and_its_text(raises, found):
    text = refusal(raises)
    assert text.startswith(f"a.fmu, line 3: found {found}")
    assert text.endswith("; valid: a number. Write one.")


def test_refusals_pass_as_they_are_and_so_does_what_ends_the_program():
    known = refuse("a", "b", "c")

    def refuses():
        raise known

    def interrupts():
        raise KeyboardInterrupt

    assert refusal(refuses) == "a: found b; valid: c"
    with pytest.raises(KeyboardInterrupt), reading("a", "b"):
        interrupts()


def test_the_text_of_an_exception_is_one_line_of_bounded_length():
    assert exception_in_words(ValueError("a\n  b")) == "ValueError: a b"
    assert exception_in_words(ValueError()) == "ValueError"
    assert exception_in_words(ValueError("x" * 5000)) == f"ValueError: {'x' * 200}..."
