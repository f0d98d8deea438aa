"""Arguments of another type than annotated, told in four parts."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

from components.interfaces.arguments import check_fields, checked_arguments, in_words, names_told
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


@names_told
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


def test_an_unknown_name_is_told_with_the_one_that_may_be_meant():
    with pytest.raises(RequestError, match=r"^asked: nubmer: found an unknown argument; valid: .*`number`\?$"):
        asked(1.0, nubmer=1)


def test_a_field_of_an_unknown_name_is_told_beside_one_that_is_given_by_its_place():
    with pytest.raises(RequestError, match=r"^Options\.thing: found an unknown field; valid: .*`things`\?$"):
        Options((), thing={})


def test_too_many_arguments_remain_an_error_of_python():
    with pytest.raises(TypeError):
        asked(*range(99))


def test_a_type_error_inside_of_a_dataclass_remains_one():
    @dataclass
    class Failing:
        value: int

        def __post_init__(self) -> None:
            len(self.value)

    names_told(Failing)
    with pytest.raises(TypeError, match="has no len"):
        Failing(value=1)
    with pytest.raises(RequestError, match=r"^Failing\.value: found no value; valid: a value$"):
        Failing()


def test_types_in_words():
    assert in_words(Mapping[str, Sequence[int]]) == "Mapping of str to Sequence of int"
    assert in_words(float | None) == "float or None"
    assert in_words(Any) == "anything"


def test_what_is_usual_is_checked_without_the_library_that_is_slow_to_import():
    asked = "import sys, orchestrator.command.main, orchestrator.scenario.options; print('typeguard' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
