"""Values as people write them, by the type of what they are for."""

from __future__ import annotations

import pytest

from components.interfaces.items import Enumeration, Item
from components.interfaces.quantity import Quantity, Type
from orchestrator.system.value_texts import from_text, typed

ITEMS = Enumeration("Gear", (Item("R 2", -2), Item("__NONE__", 0), Item("mro", 5), Item("D", 20), Item("5", 7)))


def of(kind, *shape):
    return Quantity("1", "d", kind, shape, enumeration=ITEMS if kind is Type.ENUMERATION else None)


def said(text, q):
    return [str(problem) for problem in q.problems("fmu.p", from_text(text, q))]


@pytest.mark.parametrize(
    "text",
    ["123", "1e5", "true", "", " two  blanks ", "[1, 2]", "a=b", "C:\\data\\x", "#1", "ä語", "two\nlines", "it's", '"'],
)
def test_a_text_stays_that_text(text):
    assert from_text(text, of(Type.STRING)) == text


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("'a b'", "a b"),
        ('"a b"', "a b"),
        ('"two\\nlines"', "two\nlines"),
        ('"C:\\data"', "C:\\data"),
        ("'\"quotes\"'", '"quotes"'),
        ("''", ""),
        ('"a" # "b"', '"a" # "b"'),
    ],
)
def test_a_text_in_quotes_is_what_toml_reads_in_them(text, meant):
    assert from_text(text, of(Type.STRING)) == meant


@pytest.mark.parametrize(
    ("text", "value"),
    [("R 2", -2), ('"R 2"', -2), ("'R 2'", -2), (" D ", 20), ("-2", -2), ("20", 20), ("mro", 5), ("__NONE__", 0)],
)
def test_an_item_goes_by_its_name_or_its_number(text, value):
    assert from_text(text, of(Type.ENUMERATION)) == value


def test_a_name_that_looks_like_a_number_is_a_name_first():
    assert from_text("5", of(Type.ENUMERATION)) == 7


def test_what_is_no_item_is_refused_with_the_items():
    valid = "valid: 5, D, R 2, __NONE__, mro"
    assert said("3", of(Type.ENUMERATION)) == [f"fmu.p: found 3; {valid}"]
    assert said("R2", of(Type.ENUMERATION)) == [f"fmu.p: found `R2`; {valid}. Did you mean `R 2`?"]
    assert said("", of(Type.ENUMERATION)) == [f"fmu.p: found an empty text; {valid}"]
    assert said("20.0", of(Type.ENUMERATION)) == [f"fmu.p: found `20.0` (number); {valid}"]


@pytest.mark.parametrize(
    ("text", "value"), [("true", True), ("True", True), ("1", True), ("false", False), ("0", False)]
)
def test_a_boolean_is_true_or_false_or_1_or_0(text, value):
    assert from_text(text, of(Type.BOOLEAN)) is value


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (Type.FLOAT64, "1e-2", 0.01),
        (Type.FLOAT64, "-.5", -0.5),
        (Type.FLOAT32, "3", 3),
        (Type.INT8, "-128", -128),
        (Type.INT64, str(-(2**63)), -(2**63)),
        (Type.UINT64, str(2**64 - 1), 2**64 - 1),
        (Type.UINT16, "0xff", 255),
        (Type.BINARY, "00ff", b"\x00\xff"),
        (Type.BINARY, "", b""),
    ],
)
def test_numbers_and_bytes_are_read_by_their_type(kind, text, value):
    assert from_text(text, of(kind)) == value
    assert said(text, of(kind)) == []


@pytest.mark.parametrize(
    ("kind", "text", "problem"),
    [
        (Type.FLOAT64, "", "found an empty text; valid: finite number"),
        (Type.FLOAT64, "1\nb=2", "found `1\nb=2` (not a number); valid: finite number"),
        (Type.FLOAT64, "true", "found `True` (true/false); valid: finite number"),
        (Type.FLOAT64, "[1, 2]", "found shape (2,); valid: shape ()"),
        (Type.FLOAT64, "[" * 5000, f"found `{'[' * 5000}` (not a number); valid: finite number"),
        (Type.INT32, "1.5", "found `1.5` (number); valid: whole number"),
        (Type.INT8, "128", "found 128; valid: -128 <= whole number <= 127, as Int8 holds"),
        (Type.INT64, str(2**63), f"found {2**63}; valid: {-(2**63)} <= whole number <= {2**63 - 1}, as Int64 holds"),
        (Type.UINT64, str(2**64), f"found {2**64}; valid: 0 <= whole number <= {2**64 - 1}, as UInt64 holds"),
        (Type.BOOLEAN, "yes", "found `yes` (not a number); valid: true or false"),
        (Type.BINARY, "0g", "found `0g`; valid: bytes, each as two hexadecimal digits"),
    ],
)
def test_what_is_no_value_of_a_type_is_told(kind, text, problem):
    assert said(text, of(kind)) == [f"fmu.p: {problem}"]


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (Type.FLOAT64, "[1, 2.5]", [1, 2.5]),
        (Type.BOOLEAN, "[1, false]", [True, False]),
        (Type.BOOLEAN, "[True, 0]", [True, False]),
        (Type.ENUMERATION, '["R 2", 20]', [-2, 20]),
        (Type.ENUMERATION, "[R 2, mro]", [-2, 5]),
        (Type.STRING, '["a, b", "c"]', ["a, b", "c"]),
        (Type.STRING, "[1e5, 2]", ["1e5", "2"]),
        (Type.BINARY, '["00ff", ""]', [b"\x00\xff", b""]),
    ],
)
def test_an_array_is_a_list_of_values_of_its_type(kind, text, value):
    assert from_text(text, of(kind, 2)) == value
    assert said(text, of(kind, 2)) == []


def test_a_file_has_types_of_its_own_and_texts_only_for_what_toml_has_no_type_for():
    assert typed(["R 2", 20], of(Type.ENUMERATION, 2)) == [-2, 20]
    assert typed("00ff", of(Type.BINARY)) == b"\x00\xff"
    assert typed(1, of(Type.BOOLEAN)) is True
    assert typed(1, of(Type.INT32)) == 1
    assert typed("'quoted'", of(Type.STRING)) == "'quoted'"
    assert typed("3", of(Type.FLOAT64)) == "3"


BACKSLASHES = "\\" * 50_000


@pytest.mark.parametrize(
    "text", [f'"{BACKSLASHES}', f"5 [m{BACKSLASHES}", f"5{' ' * 50_000}[m", "[" * 50_000, "'" * 50_001]
)
def test_a_text_of_any_length_is_read_in_time_that_grows_with_it(text):
    """Patterns that try every division of a text took minutes, or for ever."""
    for quantity in (Quantity("", "", type=Type.STRING), Quantity("m", "")):
        assert isinstance(from_text(text, quantity), str)


@pytest.mark.parametrize(
    ("text", "value"),
    [(r"'C:\folder\'", "C:\\folder\\"), (r'"a\"b"', 'a"b'), ('"a"b"', '"a"b"'), ("'a\"b'", 'a"b'), ('"', '"')],
)
def test_what_stands_in_quotes(text, value):
    assert from_text(text, Quantity("", "", type=Type.STRING)) == value
