"""Prepared calls of the functions that set and get the values of an FMU: one per direction and type.

The functions are called with integer addresses that are prepared once, on memory shared with the signal table, which is
several times faster than to convert arguments on each call.
"""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.units.fmi_api import FmiApi
from fmus.units.given_values import GivenValues
from fmus.units.prepared_calls import AccessCall, CallSeries, Copy
from fmus.units.unit import Column, Operation, TypedColumns, Unit, by_type, is_failure, views

AccessVerb: TypeAlias = Literal["Set", "Get"]
ADDRESS: Final = ctypes.c_size_t
"""The type of a pointer, given as an integer address."""


def library_function(fmu: Any, api: FmiApi, name: str, arguments: Sequence[Any]) -> Any:
    """A function of the library, by its name without the prefix, with argument types of its own."""
    return fmu.dll.prepared(f"{api.prefix}{name}", tuple(arguments))


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

    def each(self, direction: AccessVerb, variables: Sequence[Variable], columns: TypedColumns) -> dict[str, Operation]:
        """One call for each of the variables, by name."""
        slots, moves = views(variables, columns), dict[str, Operation]()
        for kind, group in by_type(variables).items():
            native, column = self._api.access[kind].dtype, columns[kind]
            if kind.is_number and self._is_shared(group, column, native):
                moves |= self._parts(direction, kind, group, column)
            else:
                moves |= {v.name: self.mover(direction, [v], slots[v.name]) for v in group}
        return moves

    def _parts(
        self, direction: AccessVerb, kind: Type, group: Sequence[Variable], column: Column
    ) -> Iterator[tuple[str, Operation]]:
        """One call for each variable of a group, on its part of a column that the library may use itself."""
        counted = self._api.counts_values
        name = f"{direction}{self._api.access[kind].function}"
        function = library_function(self._fmu, self._api, name, [ADDRESS] * (4 + counted))
        references = np.array([ref for v in group for ref in self._references[v.name]], dtype=np.uint32)
        self._alive += [references, column]
        at, there = references.ctypes.data, column.ctypes.data
        for v in group:
            n = len(self._references[v.name])
            yield v.name, AccessCall(function, self._component, at, n, there, *[v.size] * counted)
            at, there = at + n * references.itemsize, there + v.size * column.itemsize

    def _is_shared(self, variables: Sequence[Variable], column: Column, native: type[np.generic]) -> bool:
        """Whether the library can use a column as it is."""
        plain = column.dtype == native and bool(column.flags.c_contiguous)
        return plain and self._signs(variables, native) is None

    def mover(self, direction: AccessVerb, variables: Sequence[Variable], column: Column) -> Operation:
        """One call that moves the values of all `variables`, which are of one type, to or from `column`."""
        kind = variables[0].quantity.type
        access, native = self._api.access[kind]
        references = np.array([ref for v in variables for ref in self._references[v.name]], dtype=np.uint32)
        if not kind.is_number:
            names = [v.name for v in variables for _ in range(v.size)]
            return self._text_mover(direction, kind, references, column, names)
        signs = self._signs(variables, native)
        shared = self._is_shared(variables, column, native)
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
