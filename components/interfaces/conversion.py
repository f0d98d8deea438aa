"""Conversions: how a value of one quantity becomes a value of another, and when it does not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import DTYPES, Quantity, Type


@dataclass(frozen=True)
class Linear:
    """``y = factor * x + offset``: a change of the unit of measurement, or SSP's linear transformation."""

    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, x: Any) -> Any:
        """The converted numbers."""
        return self.factor * x + self.offset

    def after(self, first: Linear) -> Linear:
        """The conversion that applies `first` and then this one."""
        return Linear(self.factor * first.factor, self.factor * first.offset + self.offset)

    @property
    def inverse(self) -> Linear:
        """The conversion back. Raises `ZeroDivisionError` for the factor 0."""
        return Linear(1.0 / self.factor, -self.offset / self.factor)


@dataclass(frozen=True)
class Lookup:
    """SSP's mappings of Booleans, integers and enumerations: value by value; others stay as they are."""

    table: Mapping[Any, Any]

    def __call__(self, x: NDArray[Any]) -> NDArray[Any]:
        """The values that those in `x` are mapped to."""
        return np.array([self.table.get(item, item) for item in x.tolist()], dtype=x.dtype)


Transformation: TypeAlias = Linear | Lookup

IDENTITY = Linear()
_INT32_END = 2**31


def unit_conversion(found: Quantity, wanted: Quantity) -> Linear | None:
    """The conversion from the unit of measurement of `found` to that of `wanted`.

    A unit that is not declared fits any other, and numbers pass unchanged. Two unknown units fit when they are spelled
    alike.

    Args:
        found: The quantity of the values, such as that of an output.
        wanted: The quantity that they are converted to, such as that of an input.

    Returns:
        The conversion; `None` where the two units measure different quantities.
    """
    if found.unit == wanted.unit and (found.base or wanted.base) is None:
        return IDENTITY
    if not (found.unit and wanted.unit):
        return IDENTITY
    a, b = found.base_unit, wanted.base_unit
    if a is None or b is None:
        return IDENTITY if found.unit == wanted.unit else None
    if not a.same_dimension(b) or not (a.factor and b.factor):  # a file may declare a factor of 0
        return None
    return Linear(a.factor / b.factor, (a.offset - b.offset) / b.factor)


def type_fits(found: Quantity, wanted: Quantity) -> bool:
    """Whether values of `found` can be given to `wanted` as they are.

    Equal types, integers in wider ones, numbers in floats that can hold them (a Float64 in a Float32 is rounded), and
    enumerations in integers that can hold their items; two enumerations must have the same items. An Int32 fits an
    enumeration: in FMI 2.0 both are passed as one type, and many models connect them; whether the numbers are items is
    known only when they come.

    Args:
        found: The quantity of the values, such as that of an output.
        wanted: The quantity that receives them, such as that of an input.
    """
    if found.type == wanted.type:
        return not (found.enumeration and wanted.enumeration) or _items(found) == _items(wanted)
    if found.type.is_float and wanted.type.is_float:
        return True
    if Type.ENUMERATION in (found.type, wanted.type):
        return _enumeration_fits(found, wanted)
    if not (found.type.is_integer and (wanted.type.is_integer or wanted.type.is_float)):
        return False
    if wanted.type.is_integer:
        return np.can_cast(DTYPES[found.type], DTYPES[wanted.type], "safe")
    return bool(np.iinfo(DTYPES[found.type]).bits <= np.finfo(DTYPES[wanted.type]).nmant)  # type: ignore[arg-type]


def _enumeration_fits(found: Quantity, wanted: Quantity) -> bool:
    """Whether an enumeration goes into an integer, or the other way round."""
    if wanted.type is Type.ENUMERATION:
        return found.type is Type.INT32
    small = found.enumeration is not None and all(abs(item.value) < _INT32_END for item in found.enumeration)
    return wanted.type is Type.INT64 or (wanted.type is Type.INT32 and small)


def _items(q: Quantity) -> dict[str, int]:
    return {} if q.enumeration is None else q.enumeration.values
