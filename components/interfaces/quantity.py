"""Quantities: the meaning, unit of measurement, type, shape and range of a field of a record."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Any, Final, TypeAlias

import numpy as np

from components.interfaces.items import Enumeration
from components.interfaces.problem import Problem, choices, did_you_mean, refuse
from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT, BaseUnit, base_unit

Dimension: TypeAlias = int | str
"""A length, or the name of a structural constant of the block (`"N_p"`) that gives it."""


class Type(StrEnum):
    """The FMI 3.0 types that signals and parameters have."""

    FLOAT64 = "Float64"
    FLOAT32 = "Float32"
    INT8 = "Int8"
    UINT8 = "UInt8"
    INT16 = "Int16"
    UINT16 = "UInt16"
    INT32 = "Int32"
    UINT32 = "UInt32"
    INT64 = "Int64"
    UINT64 = "UInt64"
    BOOLEAN = "Boolean"
    ENUMERATION = "Enumeration"
    STRING = "String"
    BINARY = "Binary"

    @property
    def is_float(self) -> bool:
        """Whether values have a fraction, and so a unit of measurement."""
        return self in (Type.FLOAT64, Type.FLOAT32)

    @property
    def is_integer(self) -> bool:
        """Whether values are whole numbers of a fixed width."""
        return "Int" in self.value

    @property
    def is_listed(self) -> bool:
        """Whether a table can map values one by one: whole numbers, enumerations and Booleans."""
        return self.is_integer or self in (Type.ENUMERATION, Type.BOOLEAN)

    @property
    def is_number(self) -> bool:
        """Whether values take part in calculations: floats, integers, enumerations and Booleans."""
        return self not in (Type.STRING, Type.BINARY)


DTYPES: Final[dict[Type, type[np.generic]]] = {
    **{kind: getattr(np, kind.value.lower()) for kind in Type if kind.is_float or kind.is_integer},
    Type.BOOLEAN: np.bool_,
    Type.ENUMERATION: np.int64,
    Type.STRING: np.object_,
    Type.BINARY: np.object_,
}
"""The type of each value in memory; one column per type holds all signals of a system."""


TRUTHS: Final = {"true": True, "1": True, "false": False, "0": False}
"""The texts of truth values, in files and on the command line."""


def zeros(kind: Type, shape: int | tuple[int, ...]) -> np.ndarray[Any, Any]:
    """A new array for values of a type, filled with zeros, false or empty texts."""
    return np.full(shape, {Type.STRING: "", Type.BINARY: b""}.get(kind, 0), dtype=DTYPES[kind])


@dataclass(frozen=True)
class Quantity:
    """Meaning, unit of measurement, type, shape and range of one signal, state or parameter.

    Quantities of foreign files may declare no unit (the empty string), or define theirs (`base`).
    """

    unit: str
    description: str
    type: Type = Type.FLOAT64
    shape: tuple[Dimension, ...] = ()
    min: float | None = None
    max: float | None = None
    enumeration: Enumeration | None = None
    base: BaseUnit | None = None
    finite: bool = True
    """Whether values have to be finite numbers."""
    if_longer: str = field(default="", compare=False)
    """What a person can do whose array is longer: a sentence for messages."""

    @property
    def base_unit(self) -> BaseUnit | None:
        """The unit of measurement in SI base units, by the definition of its file if it has one; `None` if unknown."""
        return self.base or base_unit(self.unit)

    @property
    def range(self) -> str:
        """The valid values as text."""
        if self.enumeration is not None:
            return choices(self.enumeration.values)
        low = "" if self.min is None else f"{self.min:g} <= "
        high = "" if self.max is None else f" <= {self.max:g}"
        words = _WORDS.get(self.type, "whole number")
        return f"{low}{words if self.finite else words.removeprefix('finite ')}{high}" + (
            f" [{self.unit}]" if self.unit not in {"", "1"} else ""
        )

    def problems(self, where: str, value: object) -> list[Problem]:
        """Check a value of this quantity: its type, shape, finiteness and range.

        Args:
            where: The place of the value, for messages.
            value: A number, a text, or an array of the quantity's shape.
        """
        if not self.type.is_number:
            return self._text_problems(where, value)
        try:
            array = _whole_numbers(value) if self.type in _WHOLE else np.asarray(value)
        except ValueError:  # rows of different lengths
            return [Problem(where, f"`{value}` (not an array)", self.range)]
        if array.dtype.kind not in _KINDS.get(self.type, "iu") and not (self.type in _WHOLE and _are_whole(array)):
            return [self._of_another_kind(where, value, array)]
        if array.shape != self.shape:
            remedy = self.if_longer if array.ndim == len(self.shape) and array.shape > self.shape else ""
            return [Problem(where, f"shape {array.shape}", f"shape {self.shape}", remedy)]
        numbers = array if self.type in _WHOLE else array.astype(float)
        wrong = np.zeros(array.shape, dtype=bool) if self.type in _WHOLE else ~np.isfinite(numbers) & self.finite
        low, high = self.bounds
        if low is not None:
            wrong |= numbers < low
        if high is not None:
            wrong |= numbers > high
        if self.enumeration is not None:
            wrong |= ~np.isin(numbers, [*self.enumeration.names])
        if wrong.any():
            first = array[wrong].tolist()[0]
            return [Problem(where, f"{first if array.shape else value}", self._valid_instead_of(first))]
        return []

    def _of_another_kind(self, where: str, value: object, array: np.ndarray[Any, Any]) -> Problem:
        if self.enumeration is not None and isinstance(value, str) and value:
            return Problem(where, f"`{value}`", self.range, did_you_mean(value, self.enumeration.values))
        found = "an empty text" if isinstance(value, str) and not value else f"`{value}` ({_kind(array)})"
        return Problem(where, found, self.range)

    def _valid_instead_of(self, number: Any) -> str:
        """The valid values as text; where a whole number is within what is declared, those that its width can hold."""
        is_declared = (self.min is None or number >= self.min) and (self.max is None or number <= self.max)
        if not (self.type.is_integer and is_declared):
            return self.range
        low, high = self.bounds
        return f"{low} <= {_WORDS.get(self.type, 'whole number')} <= {high}, as {self.type} holds"

    @property
    def bounds(self) -> tuple[float | None, float | None]:
        """The least and the largest valid value: what is declared, within what the integer's width can hold."""
        if not self.type.is_integer:
            return self.min, self.max
        width = np.iinfo(DTYPES[self.type])  # type: ignore[arg-type]
        return (width.min if self.min is None else self.min), (width.max if self.max is None else self.max)

    def _text_problems(self, where: str, value: object) -> list[Problem]:
        kind = str if self.type is Type.STRING else bytes
        array = np.asarray(value, dtype=object)
        if array.shape != self.shape:
            return [Problem(where, f"shape {array.shape}", f"shape {self.shape}")]
        wrong = [item for item in array.ravel().tolist() if not isinstance(item, kind)]
        return [Problem(where, f"`{wrong[0]}`", self.range)] if wrong else []


def _whole_numbers(value: object) -> np.ndarray[Any, Any]:
    """An array of a value; whole numbers that NumPy would make floats, as some of 64 bits, are kept as objects."""
    array = np.asarray(value)
    if array.dtype.kind not in "fO":
        return array
    exact = np.asarray(value, dtype=object)
    return exact if _are_whole(exact) else array


def _are_whole(array: np.ndarray[Any, Any]) -> bool:
    return all(isinstance(n, int | np.integer) and not isinstance(n, bool) for n in array.ravel().tolist())


_WHOLE = frozenset(kind for kind in Type if kind.is_integer or kind is Type.ENUMERATION)
_KINDS = {Type.FLOAT64: "fiu", Type.FLOAT32: "fiu", Type.BOOLEAN: "b"}
_WORDS = {
    Type.FLOAT64: "finite number",
    Type.FLOAT32: "finite number",
    Type.BOOLEAN: "true or false",
    Type.STRING: "text",
    Type.BINARY: "bytes, each as two hexadecimal digits",
    Type.ENUMERATION: "whole number",
}


def _kind(value: np.ndarray[Any, Any]) -> str:
    return {"b": "true/false", "i": "whole number", "u": "whole number", "f": "number"}.get(
        value.dtype.kind, "not a number"
    )


def quantity(
    unit: str,
    description: str,
    *,
    shape: tuple[Dimension, ...] = (),
    min: float | None = None,  # noqa: A002 - the FMI attribute's name
    max: float | None = None,  # noqa: A002
) -> Any:
    """A Float64 field of a record, without a default, so that every value has to be given.

    Args:
        unit: Unit of measurement, one of `UNITS_OF_MEASUREMENT`.
        description: What the value means.
        shape: Lengths of an array, each a number or the name of a structural constant of the block.
        min: Least valid value.
        max: Largest valid value.

    Returns:
        The field, for the body of a class with the decorator `record` or `block`.

    Raises:
        RequestError: For an unknown unit of measurement, an empty description or an empty range.
    """
    return _field(Quantity(unit, description, shape=shape, min=min, max=max))


def integer(
    description: str,
    *,
    shape: tuple[Dimension, ...] = (),
    min: int | None = None,  # noqa: A002
    max: int | None = None,  # noqa: A002
) -> Any:
    """An Int32 field of a record, without a default.

    Args:
        description: What the number means.
        shape: Lengths of an array, each a number or the name of a structural constant of the block.
        min: Least valid value.
        max: Largest valid value.

    Returns:
        The field, for the body of a class with the decorator `record` or `block`.

    Raises:
        RequestError: For an empty description or an empty range.
    """
    return _field(Quantity("1", description, Type.INT32, shape, min, max))


def boolean(description: str, *, shape: tuple[Dimension, ...] = ()) -> Any:
    """A Boolean field of a record, without a default.

    Args:
        description: What it means when the value is true.
        shape: Lengths of an array, each a number or the name of a structural constant of the block.

    Returns:
        The field, for the body of a class with the decorator `record` or `block`.

    Raises:
        RequestError: For an empty description.
    """
    return _field(Quantity("1", description, Type.BOOLEAN, shape))


def enumeration(items: type[IntEnum], description: str) -> Any:
    """An Enumeration field of a record, without a default.

    Args:
        items: The items, which carry the values.
        description: What the items distinguish.

    Returns:
        The field, for the body of a class with the decorator `record` or `block`.

    Raises:
        RequestError: For an empty description.
    """
    return _field(Quantity("1", description, Type.ENUMERATION, enumeration=Enumeration.of(items)))


def _field(declared: Quantity) -> Any:
    where = f"quantity `{declared.description}`"
    if declared.unit not in UNITS_OF_MEASUREMENT:
        raise refuse(where, f"unit `{declared.unit}`", choices(UNITS_OF_MEASUREMENT))
    if not declared.description:
        raise refuse("quantity", "no description", "a phrase that says what it means")
    if declared.min is not None and declared.max is not None and declared.min > declared.max:
        raise refuse(where, f"min {declared.min} above max {declared.max}", "min <= max")
    return field(metadata={"quantity": declared})
