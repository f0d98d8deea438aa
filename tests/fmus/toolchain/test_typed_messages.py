"""Values pass from one process to another; anything else is refused, and nothing is made but what is expected."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from fmus.toolchain.typed_messages import UnreadableMessageError, read, written


@dataclass(frozen=True)
class Reply:
    value: int | None
    texts: tuple[str, ...] = ()


def test_values_pass():
    assert read(written(Reply(3, ("a",))), Reply) == Reply(3, ("a",))
    assert read(written({1, 2}), set[int]) == {1, 2}
    assert read(written([np.float64(0.1), np.int32(7), np.bool_(True)]), list[Any]) == [0.1, 7, True]  # noqa: FBT003


def test_arrays_pass_of_numbers_and_of_texts():
    sent = {
        Type.FLOAT64: np.array([[1.0, np.nan], [np.inf, -0.0]]),
        Type.BOOLEAN: np.array([True, False]),
        Type.STRING: np.array([["a"], ["b"]], object),
        Type.BINARY: np.array([b"\x00"], object),
    }
    got = read(written(sent), Mapping[Type, NDArray[Any]])
    assert list(got) == list(sent)
    for kind, array in sent.items():
        assert got[kind].dtype == array.dtype
        assert got[kind].shape == array.shape
        assert got[kind].tobytes() == array.tobytes() or got[kind].tolist() == array.tolist()


BAD = {
    "nothing": b"",
    "no message": b"\xc1",
    "a pickle": pickle.dumps(Path("x")),
    "another type": written({"value": "text"}),
    "no list of texts": written({"value": 1, "texts": [b"\xff"]}),
    "deep": b"\x91" * 100_000 + b"\x90",
    "an announced length": b"\xdd\xff\xff\xff\xff",
}


@pytest.mark.parametrize("content", BAD.values(), ids=BAD)
def test_what_is_not_expected_is_refused(content):
    with pytest.raises(UnreadableMessageError):
        read(content, Reply)


def packed(*array):
    return msgspec.msgpack.encode(msgspec.msgpack.Ext(1, msgspec.msgpack.encode(array)))


ARRAYS = {
    "another extension": msgspec.msgpack.encode(msgspec.msgpack.Ext(2, b"")),
    "objects from bytes": packed("O", [1], b"12345678"),
    "a type of other sizes": packed("V", [1], b"12345678"),
    "a shape of something else": packed("d", [1 << 50], b"12345678"),
    "half a number": packed("d", [1], b"1234567"),
    "a list": written([1.0]),
}


@pytest.mark.parametrize("content", ARRAYS.values(), ids=ARRAYS)
def test_an_array_is_what_it_says(content):
    with pytest.raises(UnreadableMessageError):
        read(content, NDArray[Any])


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_refused(content):
    for kind in (Reply, Any, NDArray[Any]):
        with suppress(UnreadableMessageError):
            read(content, kind)


def test_what_is_no_value_is_not_sent():
    with pytest.raises(TypeError, match="object is no value"):
        written(object())
