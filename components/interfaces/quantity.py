"""Quantities: what a field of a record means, in which unit, type, shape and range."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Any, TypeAlias

import numpy as np

from components.interfaces.problem import Problem, choices, refuse
from components.interfaces.unit_strings import UNITS

Dimension: TypeAlias = int | str
"""A length, or the name of a structural constant of the block (`"N_p"`) that gives it."""


class Type(StrEnum):
    """The FMI 3.0 types that signals and parameters have."""

    FLOAT64 = "Float64"
    INT32 = "Int32"
    BOOLEAN = "Boolean"
    ENUMERATION = "Enumeration"


@dataclass(frozen=True)
class Quantity:
    """Meaning, unit, type, shape and range of one signal, state or parameter."""

    unit: str
    description: str
    type: Type = Type.FLOAT64
    shape: tuple[Dimension, ...] = ()
    min: float | None = None
    max: float | None = None
    enumeration: type[IntEnum] | None = None

    @property
    def range(self) -> str:
        """The valid values as text."""
        if self.enumeration is not None:
            return choices(item.name for item in self.enumeration)
        low = "" if self.min is None else f"{self.min:g} <= "
        high = "" if self.max is None else f" <= {self.max:g}"
        kind = {Type.INT32: "whole number", Type.BOOLEAN: "true or false"}.get(self.type, "finite number")
        return f"{low}{kind}{high}" + (f" [{self.unit}]" if self.unit != "1" else "")

    def problems(self, where: str, value: object) -> list[Problem]:
        """What is wrong with `value` as a value of this quantity (type, shape, finiteness, range)."""
        try:
            found = np.asarray(value)
        except ValueError:  # rows of different lengths
            return [Problem(where, f"`{value}` (not an array)", self.range)]
        if found.dtype.kind not in _KINDS[self.type]:
            return [Problem(where, f"`{value}` ({_kind(found)})", self.range)]
        if found.shape != self.shape:
            return [Problem(where, f"shape {found.shape}", f"shape {self.shape}")]
        numbers = found.astype(float)
        wrong = ~np.isfinite(numbers)
        if self.min is not None:
            wrong |= numbers < self.min
        if self.max is not None:
            wrong |= numbers > self.max
        if self.enumeration is not None:
            wrong |= ~np.isin(numbers, [item.value for item in self.enumeration])
        if wrong.any():
            return [Problem(where, f"{found[wrong].tolist()[0] if found.shape else value}", self.range)]
        return []


_KINDS = {Type.FLOAT64: "fiu", Type.INT32: "iu", Type.BOOLEAN: "b", Type.ENUMERATION: "iu"}


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
    """A Float64 field of a record. It has no default: whoever makes the record gives every value."""
    return _field(Quantity(unit, description, shape=shape, min=min, max=max))


def integer(
    description: str,
    *,
    shape: tuple[Dimension, ...] = (),
    min: int | None = None,  # noqa: A002
    max: int | None = None,  # noqa: A002
) -> Any:
    """An Int32 field of a record."""
    return _field(Quantity("1", description, Type.INT32, shape, min, max))


def boolean(description: str, *, shape: tuple[Dimension, ...] = ()) -> Any:
    """A Boolean field of a record."""
    return _field(Quantity("1", description, Type.BOOLEAN, shape))


def enumeration(items: type[IntEnum], description: str) -> Any:
    """An Enumeration field of a record; the items carry the values."""
    return _field(Quantity("1", description, Type.ENUMERATION, enumeration=items))


def _field(declared: Quantity) -> Any:
    where = f"quantity `{declared.description}`"
    if declared.unit not in UNITS:
        raise refuse(where, f"unit `{declared.unit}`", choices(UNITS))
    if not declared.description:
        raise refuse("quantity", "no description", "a phrase that says what it means")
    if declared.min is not None and declared.max is not None and declared.min > declared.max:
        raise refuse(where, f"min {declared.min} above max {declared.max}", "min <= max")
    return field(metadata={"quantity": declared})
