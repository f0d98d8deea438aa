"""Arguments of another type than annotated, told in four parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

from components.interfaces.arguments import check_fields, checked_arguments, in_words
from components.interfaces.problem import RequestError


class Colour(Enum):
    RED = 1
    BLUE = 2


class Thing:
    MADE_BY = "Make one with Thing()."


@checked_arguments
def asked(
    number: float = 0.0,
    text: str | Path | None = None,
    texts: Sequence[str] = (),
    table: Mapping[str, int] | None = None,
    things: Mapping[str, Thing] | None = None,
    colour: Colour | Literal["none"] = "none",
    anything: Any = None,
) -> Unknown:  # noqa: F821 - the result may be of a type that is not imported
    """Any function."""
    return number, text, texts, table, things, colour, anything


@dataclass(frozen=True)
class Options:
    texts: Sequence[str] = ()
    things: Mapping[str, Thing] = field(default_factory=dict[str, Thing])

    def __post_init__(self) -> None:
        check_fields(self)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"number": "0.1"}, "asked: number: found `'0.1'` (str); valid: float"),
        ({"number": None}, "asked: number: found `None` (NoneType); valid: float"),
        ({"text": 3}, "asked: text: found `3` (int); valid: str or Path or None"),
        ({"texts": "plant.m=3"}, "asked: texts: found `'plant.m=3'` (str); valid: Sequence of str"),
        ({"texts": {"a": 1}}, "asked: texts: found `{'a': 1}` (dict); valid: Sequence of str"),
        ({"texts": [3]}, "asked: texts: found `[3]` (list); valid: Sequence of str"),
        ({"table": ["a"]}, "asked: table: found `['a']` (list); valid: Mapping of str to int or None"),
        ({"colour": "red"}, "asked: colour: found `'red'` (str); valid: Colour.RED or Colour.BLUE or `none`"),
        ({"number": "x" * 100}, f"asked: number: found `'{'x' * 59} ...` (str); valid: float"),
    ],
)
def test_an_argument_of_another_type_is_told(given, message):
    with pytest.raises(RequestError) as error:
        asked(**given)
    assert str(error.value) == message


def test_all_wrong_arguments_are_told_at_once_and_each_item_that_is_wrong():
    with pytest.raises(RequestError) as error:
        asked("x", texts="y")
    assert [problem.where for problem in error.value.problems] == ["asked: number", "asked: texts"]
    with pytest.raises(RequestError) as error:
        Options(things={"a": Thing(), "b": "x.fmu"})
    expected = "Options: things['b']: found `'x.fmu'` (str); valid: Thing. Make one with Thing()."
    assert str(error.value) == expected


@pytest.mark.parametrize("number", [1, 2.5, np.float32(1), np.int64(3), np.float64(2)])
def test_every_number_is_one(number):
    assert asked(number)[0] is number


def test_what_fits_is_handed_on_as_it_is():
    table, anything = {"a": 1}, object()
    found = asked(1.0, Path("x"), ("a", "b"), table, {"t": Thing()}, Colour.RED, anything)
    assert found[3] is table
    assert found[6] is anything
    assert Options(["a"]).texts == ["a"]


def test_too_many_arguments_remain_an_error_of_python():
    with pytest.raises(TypeError):
        asked(nonsense=1)


def test_types_in_words():
    assert in_words(Mapping[str, Sequence[int]]) == "Mapping of str to Sequence of int"
    assert in_words(float | None) == "float or None"
    assert in_words(Any) == "anything"
