"""The conversions of a value on its way through an SSP: unit conversions and transformations, composed into one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from components.interfaces.conversion import IDENTITY, Linear, Lookup, Transformation, unit_conversion
from components.interfaces.quantity import TRUTHS, Quantity, Type
from components.interfaces.record import Variable
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.parameter_values import ParameterValue
from orchestrator.ssp.transformations import ConversionStep, DeclaredTransformation, EnumerationMapping
from orchestrator.ssp.types import DeclaredType, EnumerationItems, items_of
from orchestrator.system.named_variables import ElementIndex


def composed(start: DeclaredType, steps: Sequence[ConversionStep], findings: Findings) -> Transformation | None:
    """The transformation that all `steps` together apply to the numbers of `start`.

    At each step the value is first converted to the unit of measurement of the step's end, where both units are
    declared; then the transformation of the step applies.

    Returns:
        The transformation; None where the findings say why the steps cannot be composed.
    """
    total: Transformation = IDENTITY
    here, items = start.quantity, start.items
    for step in steps:
        end = step.to.quantity
        if here is not None and end is not None and not step.unconverted:
            conversion = unit_conversion(here, end)
            if conversion is None:
                valid = f"a unit that measures the same as `{end.unit}`"
                findings.add_problem(step.where, f"the unit `{here.unit}`", valid)
                return None
            total = conversion.after(total) if isinstance(total, Linear) else total
        if step.transformation is not None:
            numeric = _numeric(step.transformation, items, step, findings)
            if numeric is None:
                return None
            both = _after(numeric, total)
            if both is None:
                valid = "one of them on the way"
                findings.add_problem(step.where, "a linear transformation joined with a table", valid)
                return None
            total = both
        here = end or (None if step.unconverted else here)
        items = step.to.items or items
    return total


def _after(second: Transformation, first: Transformation) -> Transformation | None:
    """The transformation `second` after `first`; None where one is linear and the other a table."""
    if isinstance(second, Linear):
        return second.after(first) if isinstance(first, Linear) else (first if second == IDENTITY else None)
    if isinstance(first, Linear):
        return second if first == IDENTITY else None
    known = [*first.table, *second.table]
    between = {value: first.table.get(value, value) for value in known}
    return Lookup({value: second.table.get(then, then) for value, then in between.items()})


def _numeric(
    transformation: DeclaredTransformation, items: EnumerationItems | None, step: ConversionStep, findings: Findings
) -> Transformation | None:
    """The transformation with the numbers of enumeration items in place of their names."""
    if not isinstance(transformation, EnumerationMapping):
        return transformation
    targets = step.to.items
    if not items or not targets:
        findings.add_problem(step.where, "a mapping of enumeration items", "connectors that are enumerations")
        return None
    for names, known in ((transformation.table, items), (transformation.table.values(), targets)):
        for name in names:
            if name not in known:
                findings.add_problem(step.where, f"the enumeration item `{name}`", ", ".join(known))
                return None
    kept = {number: targets[name] for name, number in items.items() if name in targets}
    return Lookup(kept | {items[a]: targets[b] for a, b in transformation.table.items()})


def constant(
    value: ParameterValue,
    steps: Sequence[ConversionStep],
    variable: Variable,
    index: ElementIndex,
    findings: Findings,
) -> Any | None:
    """A value of a parameter set, converted for a variable or one element of it.

    Args:
        value: The value.
        steps: The conversions on its way; the last one leads to the variable.
        variable: The variable.
        index: The element; None for the whole variable.
        findings: Where problems are gathered.

    Returns:
        A scalar, or for an array a flat list of all its elements; None where the findings say why it does not fit.
    """
    q = variable.quantity
    shape = variable.shape if index is None else ()
    texts = _split(value, q, shape)
    start = value.declared
    if q.enumeration is not None and start.items is None:
        start = DeclaredType(start.label, start.unit, start.base, items_of(q.enumeration))
    total = composed(start, steps, findings)
    if total is None:
        return None
    where, size = value.step.where, int(np.prod(shape))
    if len(texts) != size:
        findings.add_problem(where, f"{len(texts)} values", f"{size}, the length of `{variable.name}`")
        return None
    # an item is a number of the enumeration that a table maps from, else of the variable's own
    items = (start.items if total != IDENTITY else None) or items_of(q.enumeration) or start.items or {}
    reader = _reader(start, q, items)
    if reader is None:
        findings.add_problem(where, f"a value of type {start.label}", f"{q.type}")
        return None
    scalars: list[Any] = []
    for text in texts:
        try:
            scalars.append(reader(text))
        except (ValueError, KeyError):
            findings.add_problem(where, f"`{text}`", q.range)
            return None
    if q.type.is_number and total != IDENTITY:
        kind = np.float64 if q.type.is_float else (np.bool_ if q.type is Type.BOOLEAN else np.int64)
        scalars = total(np.array(scalars, dtype=kind)).tolist()
    return scalars if shape else scalars[0]


def _split(value: ParameterValue, q: Quantity, shape: tuple[int, ...]) -> tuple[str, ...]:
    """The texts of all elements; the numbers of an array may stand side by side in one text."""
    if (shape or value.declared.shape) and len(value.texts) == 1 and q.type.is_number:
        return tuple(value.texts[0].split())
    return value.texts


def _reader(declared: DeclaredType, q: Quantity, items: EnumerationItems) -> Callable[[str], Any] | None:
    """The function that reads a text as a value; None where the types do not fit. A float may be an integer."""
    kind = declared.type
    if kind is None:
        return None
    if q.type.is_float and (kind.is_integer or kind.is_float):
        return float
    if kind.is_integer and (q.type.is_integer or q.type is Type.ENUMERATION):
        return int
    if kind is not q.type:
        return None
    return items.__getitem__ if kind is Type.ENUMERATION else _OTHER_READERS.get(kind)


_OTHER_READERS: Final[Mapping[Type, Callable[[str], Any]]] = {
    Type.BOOLEAN: lambda text: TRUTHS[text.strip()],
    Type.STRING: str,
    Type.BINARY: bytes.fromhex,
}
