"""The ports and parameters that a model description declares: type, unit, shape, range and start value of each.

An array is one port, whatever the version of FMI: FMI 2.0's elements ``name[1]``, ``name[2]``, ... (also ``name[1,2]``,
``name[1][2]``, and counted from 0) are put together where they fill their shape. A dot in a name is structure, also
where the file says `flat`.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from math import prod
from typing import Any, Final

import numpy as np

from components.interfaces.quantity import DTYPES, Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.units_of_measurement import BASE_UNITS, BaseUnit
from fmus.toolchain.fmpy_library import ModelDescription
from fmus.toolchain.version import Version

LARGEST_ARRAY: Final = 10_000_000
"""Elements of one variable; more would fill the memory before anything ran."""

_OLD_TYPES = {"Real": Type.FLOAT64, "Integer": Type.INT32}
_ELEMENT = re.compile(r"(?P<name>.+?)(?P<index>(?:\[\d+(?:,\s*\d+)*\])+)")
_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}
_CAUSALITIES = {"input": "input", "output": "output", "parameter": "parameter", "structuralParameter": "parameter"}


@dataclass(frozen=True)
class Port:
    """One input, output or parameter of an FMU."""

    variable: Variable
    causality: str
    """`input`, `output`, `parameter` (structural ones too), or `initial` for a start value that may be set"""
    start: Any
    """The start value in the shape of the variable; None if there is none"""
    references: list[int]
    """Value references: one per element in FMI 2.0, one in all in FMI 3.0"""
    structural: bool = False
    clocks: tuple[int, ...] = ()
    """Value references of the clocks that the variable belongs to"""


def ports(root: Any, description: ModelDescription, version: Version, values: Mapping[str, Any]) -> list[Port]:
    """All ports; `values` of structural parameters give the lengths of arrays that depend on them."""
    units = {str(unit.name): _base(unit.baseUnit) for unit in description.unitDefinitions if unit.baseUnit is not None}
    wanted = {d.valueReference for v in description.modelVariables for d in v.dimensions}
    lengths = {
        v.valueReference: _length(values.get(v.name), v)
        for v in description.modelVariables
        if v.valueReference in wanted and v.start is not None
    }
    texts = {v.get("name"): [s.get("value") for s in v.iterfind("Start")] for v in root.iterfind("ModelVariables/*")}
    found = [
        _port(variable, units, lengths, texts)
        for variable in description.modelVariables
        if variable.causality in _CAUSALITIES and variable.type != "Clock" and not _is_second_name(variable)
    ]
    found = list(_arrays(found)) if version == Version.FMI2 else found
    known = {p.variable.name for p in found if p.causality != "output"}
    outputs = {p.variable.name: p.references for p in found if p.causality == "output"}
    starts = [replace(_port(v, units, lengths, texts), causality="initial") for v in _settable(description)]
    starts = list(_arrays(starts)) if version == Version.FMI2 else starts
    # what shares its name with an output is the same variable, or some elements of an array: then it stays unset
    return found + [
        p for p in starts if p.variable.name not in known and outputs.get(p.variable.name, p.references) == p.references
    ]


def _settable(description: ModelDescription) -> Iterator[Any]:
    """Outputs and local variables whose start value may be set before the initialisation."""
    for v in description.modelVariables:
        hidden = v.causality in ("output", "local", None) and v.initial in ("exact", "approx")
        if hidden and v.variability != "constant" and v.type != "Clock" and v.alias is None:
            yield v


def _is_second_name(variable: Any) -> bool:
    """Whether it is an alias of what is set: one value has one source. Outputs can be read by any of their names."""
    return variable.alias is not None and variable.causality != "output"


def aliases(description: ModelDescription) -> dict[str, str]:
    """The variable that each alias of FMI 3.0 is another name of."""
    return {v.name: v.alias.name for v in description.modelVariables if v.alias is not None}


def _length(given: Any, variable: Any) -> int:
    """The value of what may be the length of arrays; one that is none is told with the other parameters."""
    if isinstance(given, int) and given >= 0 and variable.causality == "structuralParameter":
        return given
    return _read(variable.start, Type.UINT64, variable.name, "start value")


def _base(unit: Any) -> BaseUnit:
    exponents = {base: int(n) for base in BASE_UNITS if (n := getattr(unit, base))}
    return BaseUnit(exponents, float(unit.factor), float(unit.offset))


def _port(
    variable: Any, units: Mapping[str, BaseUnit], lengths: Mapping[int, int], texts: Mapping[str, list[str]]
) -> Port:
    shape = tuple(int(d.start) if d.start is not None else lengths[d.valueReference] for d in variable.dimensions)
    if prod(shape) > LARGEST_ARRAY:
        raise ValueError(f"`{variable.name}` with {prod(shape)} elements, more than {LARGEST_ARRAY}")
    quantity = _quantity(variable, shape, units)
    given = texts.get(variable.name) or ([] if variable.start is None else [str(variable.start)])
    if quantity.type.is_number:
        given = " ".join(given).split()
    start = [_read(text, quantity.type, variable.name, "start value") for text in given]
    return Port(
        Variable(variable.name, quantity),
        _CAUSALITIES.get(variable.causality, ""),
        _shaped(start, quantity) if start else None,
        [variable.valueReference],
        structural=variable.causality == "structuralParameter",
        clocks=tuple(clock.valueReference for clock in variable.clocks or ()),
    )


def _shaped(start: list[Any], quantity: Quantity) -> Any:
    """Start values in the shape of their variable; a single one is that of all elements."""
    if not quantity.shape:
        return start[0]
    return np.resize(np.array(start, dtype=DTYPES[quantity.type]), Variable("", quantity).shape)


def _quantity(variable: Any, shape: tuple[int, ...], units: Mapping[str, BaseUnit]) -> Quantity:
    declared = variable.declaredType
    kind = _OLD_TYPES.get(variable.type) or Type(variable.type)
    unit = (variable.unit or (declared.unit if declared else None) or "") if kind.is_float else "1"
    limits = [getattr(variable, n) or (getattr(declared, n) if declared else None) for n in ("min", "max")]
    low, high = (
        None if b is None or kind is Type.ENUMERATION else _read(b, Type.FLOAT64, variable.name, "limit")
        for b in limits
    )
    return Quantity(
        unit,
        variable.description or variable.name,
        kind,
        shape,
        low,
        high,
        _enumeration(declared) if declared and declared.items else None,
        units.get(unit),
    )


def _enumeration(declared: Any) -> type[IntEnum]:
    items = {item.name: int(item.value) for item in declared.items}
    try:
        return IntEnum(declared.name, items)  # type: ignore[return-value]
    except ValueError:  # a name that Python keeps for itself
        return IntEnum(declared.name, {f"item {value}": value for value in items.values()})  # type: ignore[return-value]


def _read(text: str, kind: Type, name: str, what: str) -> Any:
    """What a text says that the file gives as the start value, or a limit, of a variable."""
    try:
        if kind is Type.BOOLEAN:
            return _BOOLEANS[text.lower()]
        if kind is Type.STRING:
            return text
        if kind is Type.BINARY:
            return bytes.fromhex(text)
        return float(text) if kind.is_float else DTYPES[kind](text).item()  # only what its width can hold
    except (ValueError, LookupError, OverflowError) as error:
        raise ValueError(f"`{name}` with the {what} `{text}`") from error


def _arrays(scalars: Iterable[Port]) -> Iterator[Port]:
    """Elements as arrays again; what does not fill its shape, or differs in type or unit, stays scalar."""
    grouped: dict[tuple[str, str], list[tuple[tuple[int, ...], Port]]] = {}
    for scalar in scalars:
        match = _ELEMENT.fullmatch(scalar.variable.name)
        name = match["name"] if match else scalar.variable.name
        index = tuple(int(i) for i in re.findall(r"\d+", match["index"])) if match else ()
        grouped.setdefault((name, scalar.causality), []).append((index, scalar))
    for (name, _), elements in grouped.items():
        yield from _joined(name, elements)


def _joined(name: str, elements: list[tuple[tuple[int, ...], Port]]) -> Iterator[Port]:
    parts = [part for _, part in sorted(elements, key=lambda element: element[0])]
    indices = sorted(index for index, _ in elements)
    first = indices[0]
    shape = (
        tuple(max(index[axis] for index in indices) - first[axis] + 1 for axis in range(len(first)))
        if all(len(index) == len(first) for index in indices)
        else ()
    )
    wanted = [tuple(i + first[axis] for axis, i in enumerate(index)) for index in np.ndindex(*shape)]
    alike = {(p.variable.quantity.type, p.variable.quantity.unit) for p in parts}
    if not shape or set(first) - {0, 1} or indices != wanted or len(alike) > 1:
        yield from (part for _, part in elements)
        return
    quantity = replace(parts[0].variable.quantity, shape=shape)
    starts = [part.start for part in parts]
    start = None if None in starts else _shaped(starts, quantity)
    references = [reference for part in parts for reference in part.references]
    yield replace(parts[0], variable=Variable(name, quantity), start=start, references=references)


def whole_name(name: str, known: Mapping[str, Any]) -> str | None:
    """The array among `known` that an element belongs to, or the name itself; None where neither is known."""
    if name in known:
        return name
    match = _ELEMENT.fullmatch(name)
    return match["name"] if match and match["name"] in known else None
