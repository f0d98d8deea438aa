"""Values that people write, on the command line or in a file, read by the type of the variable that they are for."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from typing import Any, Final, cast

import numpy as np

from components.interfaces.conversion import unit_conversion
from components.interfaces.quantity import TRUTHS, Quantity, Type
from orchestrator.system.files import Given

_QUOTED: Final = re.compile(r"""(?P<quote>["'])(?P<inside>(?:\\(?P=quote)|(?!(?P=quote)).)*)(?P=quote)""")


def from_text(text: str, q: Quantity) -> Any:
    """The value that a text of the command line means.

    A text for a String is that text, whatever it looks like; in quotes it is what TOML reads there. Items of an
    enumeration go by their name or their number, Booleans by true, false, 1 or 0, Binary by hexadecimal digits, and
    arrays are lists in brackets. Numbers may have a unit of measurement of their own behind them: `50 [km/h]`.

    Args:
        text: The text.
        q: The quantity that the value is for.

    Returns:
        The value; what means none comes back much as it is, and `Quantity.problems` says what would.
    """
    if q.type.is_float and (parts := _with_unit(text)) is not None:
        number, unit = parts
        conversion, value = unit_conversion(Quantity(unit, ""), q), from_text(number, q)
        numbers = np.asarray(value)
        return text if conversion is None or numbers.dtype.kind not in "fiu" else conversion(numbers).tolist()
    if not q.shape:
        return _unquoted(text) if q.type is Type.STRING else _scalar(text, q)
    return _in_each(_items(text, q), lambda item: _scalar(item, q) if isinstance(item, str) else _truth(item, q))


def behind(text: str) -> tuple[str, str] | None:
    """A text and what stands behind it in brackets, such as `50 [km/h]`; None where nothing does."""
    before, _, inside = text.removesuffix("]").rpartition("[")
    first = before.rstrip()
    is_apart = first != before and "]" not in inside
    return (first, inside) if text.endswith("]") and is_apart else None


def _with_unit(text: str) -> tuple[str, str] | None:
    """The number and the unit of measurement of a text such as `50 [km/h]`; None where it is none."""
    parts = behind(text)
    if parts is None or not parts[0] or "," in parts[1]:
        return None
    return parts if any(not (c.isspace() or c.isdigit()) for c in parts[1]) else None


def plain(value: Any) -> Any:
    """A value as Python's own numbers and lists, also where it is one of NumPy."""
    return value.tolist() if hasattr(value, "tolist") else value


def typed(value: Any, q: Quantity) -> Any:
    """A value of a file, which has types of its own, in the type of the quantity that it is for.

    Args:
        value: A text, a number, a truth value, or a list of such. Only what TOML has no type for may be a text: items
            of enumerations and Binary.
        q: The quantity.

    Returns:
        The value; what does not fit stays as it is.
    """
    as_text = q.type in (Type.ENUMERATION, Type.BINARY)
    return _in_each(value, lambda item: _scalar(item, q) if isinstance(item, str) and as_text else _truth(item, q))


def in_unit_of(given: Given, q: Quantity) -> Given | None:
    """A value of a file in the unit of measurement of what it is for.

    Args:
        given: The value as a person wrote it.
        q: The quantity that it is for; one without a unit of measurement takes the numbers as they are.

    Returns:
        The value; None where it measures something else, or is no number.
    """
    if given.unit == q.unit or not (q.unit and q.type.is_float):
        return given.model_copy(update={"unit": q.unit, "value": typed(given.value, q)})
    relation = unit_conversion(Quantity(given.unit, ""), q)
    try:
        numbers = np.asarray(given.value)
    except ValueError:  # rows of different lengths
        return None
    if relation is None or numbers.dtype.kind not in "fiu":
        return None
    return given.model_copy(update={"unit": q.unit, "value": np.asarray(relation(numbers), dtype=float).tolist()})


def _in_each(value: Any, convert: Callable[[Any], Any]) -> Any:
    """The converted value, or a list of converted values, as deep as the list is."""
    if isinstance(value, list):
        return [_in_each(item, convert) for item in cast(list[Any], value)]
    return convert(value)


def _truth(value: Any, q: Quantity) -> Any:
    """A truth value for a 0 or 1 that is for a Boolean; any other value as it is."""
    return TRUTHS.get(str(value), value) if q.type is Type.BOOLEAN and type(value) is int else value


def _scalar(text: str, q: Quantity) -> Any:
    if q.enumeration is not None:
        items = q.enumeration.values
        for name in (text, text.strip(), _unquoted(text.strip())):
            if name in items:
                return items[name]
    if q.type is Type.STRING:
        return text
    try:
        return _READERS.get(q.type, int)(text.strip())
    except (ValueError, KeyError):
        return _literal(text)


def _number(text: str) -> int | float:
    """A number, which stays whole where it is written so."""
    try:
        return int(text)
    except ValueError:
        return float(text)


_READERS: Final[Mapping[Type, Callable[[str], Any]]] = {
    Type.FLOAT64: _number,
    Type.FLOAT32: _number,
    Type.BOOLEAN: lambda text: TRUTHS[text.lower()],
    Type.BINARY: bytes.fromhex,
}


def _literal(text: str) -> Any:
    """The number, the truth value or the list that TOML reads in a text; else the text as it is."""
    try:
        content = tomllib.loads(f"value = {text.strip()}")
    except (ValueError, RecursionError):
        return text
    value = content.pop("value")
    is_one = not content and isinstance(value, int | float | list)
    return value if is_one else text  # type: ignore[unknown] - the items of a list may be anything


def _items(text: str, q: Quantity) -> Any:
    """The list that TOML reads in a text, or the texts between its commas where these are no values of TOML."""
    items = _literal(text)
    inside = re.fullmatch(r"\s*\[([^\[\]]*)\]\s*", text)
    foreign = isinstance(items, str) or (
        q.type is Type.STRING and any(not isinstance(item, str | list) for item in cast(list[Any], items))
    )
    return [_unquoted(item.strip()) for item in inside[1].split(",")] if inside and foreign else items


def _unquoted(text: str) -> str:
    match = _QUOTED.fullmatch(text)
    if match is None:
        return text
    try:
        return str(tomllib.loads(f"value = {text}")["value"])
    except ValueError:  # a backslash that begins no escape of TOML
        return match["inside"]
