"""Records: closed groups of quantities (a bus, a state, all inputs of a block) that carry numbers or symbols."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import prod
from typing import Any, TypeVar, dataclass_transform, get_type_hints

import numpy as np

from components.interfaces.arguments import names_told
from components.interfaces.maths import Array, is_symbolic, joined
from components.interfaces.problem import Problem, refuse
from components.interfaces.quantity import Quantity, boolean, enumeration, integer, quantity

R = TypeVar("R")


@dataclass(frozen=True)
class Variable:
    """One signal, state or parameter by its dotted name, with all array lengths known."""

    name: str
    quantity: Quantity

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the array; empty for a scalar."""
        return tuple(int(n) for n in self.quantity.shape)

    @cached_property
    def size(self) -> int:
        """Number of elements; 1 for a scalar."""
        return prod(self.shape)

    @property
    def elements(self) -> list[str]:
        """FMI 2.0 names of the elements: `name`, or `name[1]`, `name[2]`, ..."""
        if not self.quantity.shape:
            return [self.name]
        return [self.element([i + 1 for i in index]) for index in np.ndindex(*self.shape)]

    def element(self, index: Iterable[int]) -> str:
        """FMI 2.0 name of one element, by its index from 1 in each dimension."""
        return f"{self.name}[{','.join(map(str, index))}]"


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(quantity, integer, boolean, enumeration)
)
def record(cls: type[R]) -> type[R]:
    """Make `cls` a closed, immutable record: every field is a quantity or another record.

    Raises:
        RequestError: A field is neither.
    """
    decorated = names_told(dataclass(frozen=True, kw_only=True, eq=False)(cls))
    for name, kind in _fields(decorated):
        if kind is None:
            raise refuse(
                f"{cls.__name__}.{name}", "a field without a quantity", "a field made by quantity(...) or a record"
            )
    return decorated


@cache
def _fields(cls: type) -> tuple[tuple[str, Quantity | type | None], ...]:
    hints = get_type_hints(cls)
    fields: list[tuple[str, Any]] = []
    for item in dataclasses.fields(cls):
        nested: Any = hints[item.name]
        declared: Quantity | None = item.metadata.get("quantity")
        fields.append((item.name, declared or (nested if dataclasses.is_dataclass(nested) else None)))
    return tuple(fields)


def groups(cls: type) -> dict[str, type]:
    """The records nested directly in `cls`: the buses of a block's inputs or outputs."""
    return {name: kind for name, kind in _fields(cls) if isinstance(kind, type)}


def variables(cls: type, dimensions: Mapping[str, int] | None = None, prefix: str = "") -> tuple[Variable, ...]:
    """All variables of a record, in the order of declaration.

    Args:
        cls: The type of the record.
        dimensions: The structural constants that give named array lengths.
        prefix: The beginning of each dotted name.
    """
    return tuple(_variables(cls, {} if dimensions is None else dimensions, prefix))


def _variables(cls: type, dimensions: Mapping[str, int], prefix: str) -> Iterator[Variable]:
    for name, kind in _fields(cls):
        if isinstance(kind, Quantity):
            shape = tuple(dimensions[n] if isinstance(n, str) else n for n in kind.shape)
            yield Variable(prefix + name, dataclasses.replace(kind, shape=shape))
        elif kind is not None:
            yield from _variables(kind, dimensions, f"{prefix}{name}.")


def size(cls: type, dimensions: Mapping[str, int] | None = None) -> int:
    """Number of elements of a record."""
    return sum(v.size for v in variables(cls, dimensions))


def leaves(value: object) -> list[Any]:
    """The values of a record, in the order of `variables`."""
    values: list[Any] = []
    for name, kind in _fields(type(value)):
        item = getattr(value, name)
        if isinstance(kind, Quantity):
            values.append(item)
        else:
            values.extend(leaves(item))
    return values


def pack(value: object) -> Array:
    """A record as one column of numbers or symbols, of shape (size(type(value)),)."""
    return joined(leaves(value))


def unpack(cls: type[R], column: Array, dimensions: Mapping[str, int] | None = None) -> R:
    """The record whose `pack` is a column; the inverse of `pack`.

    Args:
        cls: The type of the record.
        column: Numbers or symbols, of shape (size(cls),).
        dimensions: The structural constants that give named array lengths.
    """
    unpacked, _ = _unpack(cls, column, {} if dimensions is None else dimensions, 0)
    return unpacked


def _unpack(cls: type[R], column: Array, dimensions: Mapping[str, int], at: int) -> tuple[R, int]:
    values: dict[str, Any] = {}
    for name, kind in _fields(cls):
        if isinstance(kind, Quantity):
            n = prod(dimensions[d] if isinstance(d, str) else d for d in kind.shape)
            values[name] = column[at : at + n] if kind.shape else column[at]
            at += n
        elif kind is not None:
            values[name], at = _unpack(kind, column, dimensions, at)
    return cls(**values), at


def pack_all(values: Sequence[object]) -> Array:
    """Several records as one column of numbers or symbols, one below the other."""
    return joined([leaf for value in values for leaf in leaves(value)])


def unpack_all(cls: type[R], column: Array, dimensions: Mapping[str, int] | None = None) -> list[R]:
    """The records of type `cls` whose `pack_all` is `column`."""
    n = size(cls, dimensions)
    return [unpack(cls, column[at : at + n], dimensions) for at in range(0, column.shape[0], n)]


def part(cls: type[R], whole: Any) -> R:
    """The record of type `cls` with the values that `whole` has under the same names."""
    return cls(**{name: getattr(whole, name) for name, _ in _fields(cls)})


def combine(function: Callable[..., Any], first: R, *others: R) -> R:
    """A record whose every value is `function` of the same values of the given records."""
    values = {
        name: function(*(getattr(r, name) for r in (first, *others)))
        if isinstance(kind, Quantity)
        else combine(function, *(getattr(r, name) for r in (first, *others)))
        for name, kind in _fields(type(first))
    }
    return type(first)(**values)


def value_problems(value: object, where: str, declared: Sequence[Variable]) -> list[Problem]:
    """The problems of the numbers in a record; symbols are not checked.

    Args:
        value: The record.
        where: The path of the record, for messages.
        declared: Its variables, in order.
    """
    return [
        problem
        for variable, leaf in zip(declared, leaves(value), strict=True)
        if not is_symbolic(leaf)
        for problem in variable.quantity.problems(f"{where}.{variable.name}", leaf)
    ]
