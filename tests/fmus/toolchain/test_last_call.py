"""The function that is called is noted where that is wanted, and costs nothing elsewhere."""

from __future__ import annotations

from ctypes import CDLL
from functools import partial

import pytest

from fmus.toolchain import last_call as module
from fmus.toolchain.last_call import LONGEST_NAME, last_call, name_of, note, note_calls, noted


@pytest.fixture
def place(monkeypatch):
    monkeypatch.setattr(module, "_places", [])
    return memoryview(bytearray(LONGEST_NAME))


def test_a_call_is_noted_before_it_is_made(place):
    note_calls(place)
    seen = []
    call = noted("fmi3DoStep", lambda *arguments: seen.append((last_call(place), arguments)))
    assert last_call(place) == ""
    call(1, 2)
    assert seen == [("fmi3DoStep", (1, 2))]
    noted("n" * 1000, int)()
    assert last_call(place) == "n" * LONGEST_NAME


def test_nothing_is_noted_unless_it_is_wanted(place):
    assert noted("fmi3DoStep", int) is int


@pytest.mark.parametrize("text", [b"\x1b[2J", b"\xff\xfe", b"two words", b"a\0b"])
def test_what_is_no_name_is_none(place, text):
    place[: len(text)] = text
    assert last_call(place) == ""


def test_calls_tell_their_names(place):
    assert name_of(partial(CDLL(None).getpid, 1)) == ""
    note_calls(place)
    assert name_of(partial(noted("fmi2GetReal", int), 1)) == "fmi2GetReal"
    assert name_of(None) == name_of(3) == ""


def test_a_call_is_noted_again_where_others_have_followed_it(place):
    note("fmi2DoStep")  # nothing is noted where nobody asked for it
    note_calls(place)
    noted("fmi2GetBooleanStatus", int)()
    note("fmi2DoStep")
    assert last_call(place) == "fmi2DoStep"
