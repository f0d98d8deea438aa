"""Messages arrive whole and in order, and whatever else is written to the pipe is no message."""

from __future__ import annotations

import os

import pytest

from fmus.toolchain.sealed_messages import ReadPipe, Seal, SealedMessages, SelectedPipe

SEAL = Seal(b"known to two")


@pytest.fixture(params=[SelectedPipe, ReadPipe])
def pipe(request):
    """The messages that come out of a pipe, and the function that writes to it."""
    reading, writing = os.pipe()
    with os.fdopen(writing, "wb", buffering=0) as stream:
        messages = SealedMessages(request.param(os.fdopen(reading, "rb")), SEAL)
        yield messages, stream
    messages.close()


def test_messages_arrive_in_order_however_they_are_cut(pipe):
    messages, stream = pipe
    data = SEAL.sealed(b"one") + SEAL.sealed(b"") + SEAL.sealed(b"x" * 1000)
    for at in range(0, len(data), 7):
        stream.write(data[at : at + 7])
    assert [messages.next(10.0) for _ in range(3)] == [b"one", b"", b"x" * 1000]
    assert messages.next(0.01) is None
    stream.close()
    with pytest.raises(EOFError):
        messages.next(10.0)
    with pytest.raises(EOFError):
        messages.next(10.0)


@pytest.mark.parametrize(
    "garbage",
    [
        b"abcd" * 1000,
        b"\x80\x04K\x01.",  # a pickle
        SEAL.mark[:-1],
        SEAL.mark + b"\0" * 24,
        SEAL.sealed(b"cut short")[:-3],
        Seal(b"another secret").sealed(b"forged"),
    ],
    ids=["text", "pickle", "begun", "empty", "short", "forged"],
)
def test_what_is_not_sealed_is_skipped(pipe, garbage):
    messages, stream = pipe
    stream.write(garbage)
    assert messages.next(0.01) is None
    stream.write(SEAL.sealed(b"the answer") + SEAL.sealed(b"the next"))
    found = [messages.next(10.0), messages.next(0.1)]
    assert b"the next" in found
    assert set(found) <= {b"the answer", b"the next", None}


def test_half_a_message_does_not_keep_anybody_waiting(pipe):
    messages, stream = pipe
    stream.write(SEAL.sealed(b"never finished")[:-1])
    assert messages.next(0.1) is None
