"""Texts and bytes of a library: read as far as they can be, with a remark; the others end the run."""

from __future__ import annotations

import ctypes
from types import SimpleNamespace

import pytest

from fmus.toolchain.limits import LARGEST_BINARY, LARGEST_STRING
from fmus.units.given_values import GivenValues
from fmus.units.unit import UnitError


@pytest.fixture
def given():
    remarks = []
    return GivenValues(SimpleNamespace(name="m", remark=remarks.append), "fmi3Get"), remarks


def address(content):
    kept = ctypes.create_string_buffer(content)
    return ctypes.addressof(kept), kept


def test_texts_are_read_with_a_word_on_what_is_wrong(given):
    values, remarks = given
    fine, kept = address("café".encode())
    assert values.string("s", fine) == "café"
    assert remarks == []
    assert values.string("s", None) == ""
    bad, kept = address(b"caf\xe9")
    assert values.string("s", bad) == "caf\ufffd"
    assert remarks == [
        "`fmi3Get` gave no text for `s`, which is taken as an empty one",
        "`fmi3Get` gave a text for `s` that is not UTF-8; what cannot be read is replaced",
    ]
    assert kept.value == b"caf\xe9"


def test_a_text_has_a_largest_size(given):
    values, _ = given
    whole, kept = address(b"x" * LARGEST_STRING)
    assert len(values.string("s", whole)) == LARGEST_STRING
    over, kept = address(b"x" * (LARGEST_STRING + 1))
    with pytest.raises(UnitError, match="m: `fmi3Get` gave a text of more than 1048576 bytes for `s`"):
        values.string("s", over)
    assert len(kept) > LARGEST_STRING


def test_bytes_are_where_they_are_said_to_be(given):
    values, remarks = given
    where, kept = address(b"\0\xff\0")
    assert values.binary("b", where, 3) == b"\0\xff\0"
    assert values.binary("b", None, 0) == values.binary("b", where, 0) == b""
    with pytest.raises(UnitError, match="m: `fmi3Get` gave no address of the 7 bytes of `b`"):
        values.binary("b", None, 7)
    with pytest.raises(
        UnitError, match=f"m: `fmi3Get` gave 18446744073709551615 bytes for `b`, of at most {LARGEST_BINARY}"
    ):
        values.binary("b", where, 2**64 - 1)
    assert remarks == []
    assert kept
