"""Arrays of FMI 2.0: their elements `name[1]`, `name[2]`, ... are variables, joined where they fill a shape.

The elements may be written ``name[1,2]`` and ``name[1][2]`` too, and be counted from 0.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from components.interfaces.record import Variable
from fmus.reading.start_values import shaped
from fmus.toolchain.limits import MOST_DIMENSIONS

if TYPE_CHECKING:
    from fmus.reading.declared_variables import DeclaredVariable

_INDEX: Final = re.compile(r"[0-9]{1,18}(?:,\s{0,9}[0-9]{1,18}){0,31}")
"""What stands in brackets behind the name of an array."""


def joined_arrays(scalars: Iterable[DeclaredVariable]) -> Iterator[DeclaredVariable]:
    """Arrays joined of their elements; elements that do not fill a shape, or differ in type or unit, stay scalar.

    So do those whose array would have the name of another variable, or of an array of another causality.
    """
    grouped: dict[tuple[str, str], list[tuple[tuple[int, ...], DeclaredVariable]]] = {}
    for scalar in scalars:
        name, index = _element(scalar.variable.name)
        grouped.setdefault((name, scalar.causality), []).append((index, scalar))
    users = Counter(name for name, _ in grouped)
    for (name, _), elements in grouped.items():
        if users[name] > 1 or (len(elements) == 1 and not elements[0][0]):
            yield from (element for _, element in elements)
        else:
            yield from _joined(name, elements)


def _element(name: str) -> tuple[str, tuple[int, ...]]:
    """The name of an array and the indices, of the name of an element; the name itself and () of any other."""
    rest, indices = name, tuple[int, ...]()
    while rest.endswith("]") and len(indices) < MOST_DIMENSIONS:  # most names do not, and there may be very many
        before, bracket, index = rest[:-1].rpartition("[")
        if not (before and bracket and _INDEX.fullmatch(index)):
            break
        rest, indices = before, (*map(int, index.split(",")), *indices)
    return (rest, indices) if len(indices) <= MOST_DIMENSIONS else (name, ())


def settable_arrays(scalars: list[DeclaredVariable], outputs: Mapping[str, list[int]]) -> Iterator[DeclaredVariable]:
    """Arrays joined of their elements, which stay scalar where other elements of the same output cannot be set."""
    elements: dict[str | None, list[DeclaredVariable]] = {}
    for scalar in scalars:
        elements.setdefault(array_name(scalar.variable.name), []).append(scalar)
    for joined in joined_arrays(scalars):
        name, references = joined.variable.name, joined.references
        if outputs.get(name, references) == references:
            yield joined
        else:
            yield from (s for s in elements.get(name, ()) if s.variable.name not in outputs)


def _joined(name: str, elements: list[tuple[tuple[int, ...], DeclaredVariable]]) -> Iterator[DeclaredVariable]:
    parts = [part for _, part in sorted(elements, key=lambda element: element[0])]
    indices = sorted(index for index, _ in elements)
    first = indices[0]
    shape = (
        tuple(max(index[axis] for index in indices) - first[axis] + 1 for axis in range(len(first)))
        if all(len(index) == len(first) for index in indices)
        else ()
    )
    alike = {(p.variable.quantity.type, p.variable.quantity.unit, p.negated) for p in parts}
    is_whole = bool(shape) and prod(shape) == len(indices)  # `p[1]` and `p[2000000000]` alone fill no array
    expected = [
        tuple(i + first[axis] for axis, i in enumerate(index)) for index in np.ndindex(*shape if is_whole else ())
    ]
    if not is_whole or set(first) - {0, 1} or indices != expected or len(alike) > 1:
        yield from (part for _, part in elements)
        return
    quantity = replace(parts[0].variable.quantity, shape=shape)
    starts = [part.start for part in parts]
    start = None if None in starts else shaped(starts, quantity)
    references = [reference for part in parts for reference in part.references]
    variability = parts[0].variability if len({part.variability for part in parts}) == 1 else ""
    whole = replace(parts[0], variable=Variable(name, quantity), variability=variability)
    yield replace(whole, start=start, references=references)


def whole_name(name: str, known: Mapping[str, Any]) -> str | None:
    """The variable that a name stands for: itself, or the array of which it names an element.

    Args:
        name: The name.
        known: The variables, by name.

    Returns:
        The name of the variable; None where there is none.
    """
    if name in known:
        return name
    array = array_name(name)
    return array if array in known else None


def array_name(name: str) -> str | None:
    """The name of the array of which a name would be an element; None where it has no index."""
    array, indices = _element(name)
    return array if indices else None
