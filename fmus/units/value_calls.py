"""Prepared calls of the functions that set and get the values of an FMU: one per direction and type.

The functions are called with integer addresses that are prepared once, on memory shared with the signal table, which is
several times faster than to convert arguments on each call.
"""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.toolchain.last_call import noted
from fmus.units.fmi_api import FmiApi
from fmus.units.given_values import GivenValues
from fmus.units.prepared_calls import AccessCall, CallSeries, Copy
from fmus.units.unit import Column, Operation, TypedColumns, Unit, by_type, is_failure

AccessVerb: TypeAlias = Literal["Set", "Get"]
ADDRESS: Final = ctypes.c_size_t
"""The type of a pointer, given as an integer address."""


def library_function(fmu: Any, api: FmiApi, name: str, arguments: Sequence[Any]) -> Any:
    """A function of the library, by its name without the prefix, with argument types of its own."""
    whole = f"{api.prefix}{name}"
    function = fmu.dll[whole]  # indexing gives a new object each time, which FMPy does not know
    function.argtypes, function.restype = list(arguments), ctypes.c_int
    return noted(whole, function)


class ValueCalls:
    """The calls that move values between an instance and columns; they keep the arrays alive that they pass.

    Args:
        fmu: FMPy's object, whose library is loaded.
        api: The version of FMI.
        component: Address of the instance.
        references: Value references of each variable, one per element or one in all.
        negated: Variables whose values are the negative ones of those of the library.
        unit: The unit, for its remarks on texts and bytes that the library gives.
    """

    def __init__(  # noqa: PLR0913 - what a call is made of
        self,
        fmu: Any,
        api: FmiApi,
        component: int,
        references: Mapping[str, list[int]],
        negated: Collection[str] = (),
        *,
        unit: Unit | None = None,
    ) -> None:
        self._unit = unit
        self._fmu, self._api, self._component = fmu, api, component
        self._references, self._negated = references, negated
        self._alive: list[Any] = []
        """Arrays whose addresses the prepared calls contain."""

    def movers(self, direction: AccessVerb, variables: Sequence[Variable], columns: TypedColumns) -> list[Operation]:
        """One call for each type that occurs among the variables."""
        return [self.mover(direction, group, columns[kind]) for kind, group in by_type(variables).items()]

    def mover(self, direction: AccessVerb, variables: Sequence[Variable], column: Column) -> Operation:
        """One call that moves the values of all `variables`, which are of one type, to or from `column`."""
        kind = variables[0].quantity.type
        access, native = self._api.access[kind]
        references = np.array([ref for v in variables for ref in self._references[v.name]], dtype=np.uint32)
        if not kind.is_number:
            names = [v.name for v in variables for _ in range(v.size)]
            return self._text_mover(direction, kind, references, column, names)
        signs = self._signs(variables, native)
        shared = column.dtype == native and column.flags.c_contiguous and signs is None
        values = column if shared else np.zeros(column.size, dtype=native)
        self._alive += [references, values]
        counts = [values.size] if self._api.counts_values else []
        function = library_function(self._fmu, self._api, f"{direction}{access}", [ADDRESS] * (4 + len(counts)))
        arguments = self._component, references.ctypes.data, references.size, values.ctypes.data, *counts
        call = AccessCall(function, *arguments)
        if shared:
            return call
        source, target = (column, values) if direction == "Set" else (values, column)
        copy = Copy(source, target) if signs is None else _negated(source, target, signs)
        return CallSeries((copy, call) if direction == "Set" else (call, copy), function.__name__)

    def _signs(self, variables: Sequence[Variable], native: type[np.generic]) -> Column | None:
        """What the values of each element are multiplied by; None where it is 1."""
        if not self._negated or not any(v.name in self._negated for v in variables):
            return None
        return np.array([-1 if v.name in self._negated else 1 for v in variables for _ in range(v.size)], dtype=native)

    def _text_mover(
        self, direction: AccessVerb, kind: Type, references: Column, column: Column, names: Sequence[str]
    ) -> Operation:
        """The same for String and Binary, whose values are copied one by one."""
        self._alive.append(references)
        n, binary = column.size, kind is Type.BINARY
        pointers = (ctypes.c_char_p * n)() if direction == "Set" else (ctypes.c_void_p * n)()
        sizes = (ctypes.c_size_t * n)()
        arguments = [self._component, references.ctypes.data, references.size]
        arguments += [ctypes.addressof(sizes)] * binary + [ctypes.addressof(pointers)]
        arguments += [n] * self._api.counts_values
        name = f"{direction}{self._api.access[kind].function}"
        taken = GivenValues(self._unit, f"{self._api.prefix}{name}")
        function = library_function(self._fmu, self._api, name, [ADDRESS] * len(arguments))

        def set_values() -> object:
            data = column.tolist() if binary else [text.encode() for text in column.tolist()]
            pointers[:], sizes[:] = data, [len(item) for item in data]
            return function(*arguments)

        nothing = [None] * n

        def get_values() -> object:
            pointers[:] = nothing  # what the library does not fill in is no address
            status = function(*arguments)
            if not is_failure(status):
                given = zip(names, pointers, sizes, strict=True)
                column[:] = [taken.binary(*each) if binary else taken.string(*each[:2]) for each in given]
            return status

        moved = set_values if direction == "Set" else get_values
        moved.__name__ = function.__name__
        return moved


def _negated(source: Column, target: Column, signs: Column) -> Operation:
    """A copy of values, each with its sign."""

    def copy() -> None:
        target[:] = source * signs

    return copy
