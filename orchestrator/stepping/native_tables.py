"""The tables of the native stepper in memory, with the layout that `fmus/runtime/stepper.c` has for them."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from typing import Any, Final

import numpy as np

from components.interfaces.conversion import IDENTITY, Linear
from fmus.units.unit import Column

_CASTABLE: Final = "?bBhHiIl"
"""The types of whole numbers that C converts, as NumPy's letters."""
KINDS: Final = {
    name: number
    for number, name in enumerate(
        (
            *("access_fmi2", "access_fmi3", "step_fmi2", "step_fmi3"),
            *("copy", "gather", "table", "row", "linear", "cast", "python"),
        )
    )
}
"""The numbers of the kinds of operations."""
FAIL: Final = 0
GO_ON: Final = 1
ENDED: Final = 2
"""What Python answers to C: something has failed; the unit may go on; it has come to its end, others go on."""
FAILED: Final = 1
NOT_FINITE: Final = 2
"""What a call of the stepper returns, as far as anything follows from it."""


class NativeOperation(ctypes.Structure):
    """One operation: what C does, and on which memory."""

    _fields_ = [
        *((name, ctypes.c_int32) for name in ["kind", "call", "width", "from_", "to", "earlier", "multiple", "parts"]),
        *((name, ctypes.c_size_t) for name in ["function", "component", "source", "target", "places"]),
        *((name, ctypes.c_int64) for name in ["count", "first"]),
        *((name, ctypes.c_double) for name in ["factor", "offset"]),
        ("results", ctypes.c_size_t * 4),
    ]


class NativeWatch(ctypes.Structure):
    """Floating-point numbers of one type, and which of them are expected to be finite."""

    _fields_ = [
        ("values", ctypes.c_size_t),
        ("expected", ctypes.c_size_t),
        ("count", ctypes.c_int64),
        ("width", ctypes.c_int32),
    ]


PythonCall: Final = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_int32, ctypes.c_int32)
"""What C asks Python for: the number of a call, and the status of one that C has made."""


class NativeProgram(ctypes.Structure):
    """All operations of a run, and how far it has come."""

    _fields_ = [
        *((name, ctypes.c_size_t) for name in ["operations", "bounds", "rows", "watched"]),
        *((name, ctypes.c_int64) for name in ["n_rows", "n_watched", "period", "tick"]),
        ("kept", ctypes.c_size_t),
        *((name, ctypes.c_double) for name in ["start", "h", "t", "length"]),
        ("step_times", ctypes.c_size_t),
        ("python", PythonCall),
        ("stop", ctypes.c_int32),
    ]


def layouts(library: ctypes.CDLL) -> tuple[int, int]:
    """The sizes of the structures, in the library and in this file."""
    library.stepper_layout.restype = ctypes.c_int64
    sizes = [ctypes.sizeof(kind) for kind in (NativeOperation, NativeWatch, NativeProgram)]
    return library.stepper_layout(), sum(size * unit for size, unit in zip(sizes, (10**6, 10**3, 1), strict=True))


def moved(kind: str, source: Column, target: Column, *, places: Column | None = None) -> NativeOperation:
    """An operation that moves values.

    Args:
        kind: The name of its kind.
        source: The values.
        target: Where they go.
        places: The elements of the one or the other, as the kind says.
    """
    return NativeOperation(
        kind=KINDS[kind],
        width=source.itemsize,
        source=address(source),
        target=address(target),
        places=0 if places is None else address(places),
        count=target.shape[-1] if places is None else places.size,
    )


def copied(source: Column, target: Column, conversion: Any) -> NativeOperation | None:
    """A copy with a conversion, as far as C knows it."""
    if not (source.flags.c_contiguous and target.flags.c_contiguous):
        return None
    if conversion == IDENTITY:
        if source.dtype == target.dtype:
            return moved("copy", source, target) if source.dtype.kind != "O" else None
        if source.dtype.char in _CASTABLE and target.dtype.char in f"{_CASTABLE}d":
            operation = moved("cast", source, target)
            operation.from_, operation.to = ord(source.dtype.char), ord(target.dtype.char)
            return operation
    elif isinstance(conversion, Linear) and source.dtype == target.dtype == np.float64:
        operation = moved("linear", source, target)
        operation.factor, operation.offset = conversion.factor, conversion.offset
        return operation
    return None


def address(array: Column) -> int:
    """The address of the first element."""
    return array.ctypes.data
