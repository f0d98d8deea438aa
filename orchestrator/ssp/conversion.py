"""What becomes of values on their way through an SSP: changes of unit and transformations, joined into one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from components.interfaces.conversion import IDENTITY, Linear, Lookup, Transformation, unit_conversion
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connections import Index
from orchestrator.ssp.parameter_values import Value
from orchestrator.ssp.types import TRUTHS, Change, Declared, Names, Step, items_of

Items: TypeAlias = Mapping[str, int]


def joined(start: Declared, steps: Sequence[Step], findings: Findings) -> Transformation | None:
    """What all `steps` together do to the numbers of `start`; None where they cannot: the findings say why.

    At each step the unit changes to that of its end, where both are known, and then its transformation applies.
    """
    total: Transformation = IDENTITY
    here, items = start.quantity, start.items
    for step in steps:
        end = step.to.quantity
        if here is not None and end is not None and not step.as_it_is:
            unit = unit_conversion(here, end)
            if unit is None:
                valid = f"a unit that measures the same as `{end.unit}`"
                findings.wrong(step.where, f"the unit `{here.unit}`", valid)
                return None
            total = unit.after(total) if isinstance(total, Linear) else total
        if step.change is not None:
            made = _numbers(step.change, items, step.to.items, step, findings)
            after = None if made is None else _after(made, total)
            if after is None:
                if made is not None:
                    findings.wrong(step.where, "a linear transformation joined with a table", "one of them on the way")
                return None
            total = after
        here = end or (None if step.as_it_is else here)
        items = step.to.items or items
    return total


def _after(change: Transformation, first: Transformation) -> Transformation | None:
    if isinstance(change, Linear):
        return change.after(first) if isinstance(first, Linear) else (first if change == IDENTITY else None)
    if isinstance(first, Linear):
        return change if first == IDENTITY else None
    known = [*first.table, *change.table]
    between = {value: first.table.get(value, value) for value in known}
    return Lookup({value: change.table.get(then, then) for value, then in between.items()})


def _numbers(
    change: Change, items: Items | None, targets: Items | None, step: Step, findings: Findings
) -> Transformation | None:
    """A transformation whose enumeration items are their numbers."""
    if not isinstance(change, Names):
        return change
    if not items or not targets:
        findings.wrong(step.where, "a mapping of enumeration items", "connectors that are enumerations")
        return None
    for names, known in ((change.table, items), (change.table.values(), targets)):
        for name in names:
            if name not in known:
                findings.wrong(step.where, f"the enumeration item `{name}`", ", ".join(known))
                return None
    kept = {number: targets[name] for name, number in items.items() if name in targets}
    return Lookup(kept | {items[a]: targets[b] for a, b in change.table.items()})


def constant(value: Value, steps: Sequence[Step], variable: Variable, at: Index, findings: Findings) -> Any | None:
    """A value of a parameter set as `variable`, or its element `at`, takes it; None where it does not.

    Arrays are lists of all their elements. The last of the `steps` leads to the variable.
    """
    q = variable.quantity
    shape = variable.shape if at is None else ()
    texts = _split(value, q, shape)
    start = value.declared
    if q.enumeration is not None and start.items is None:
        start = Declared(start.label, start.unit, start.base, items_of(q.enumeration))
    total = joined(start, steps, findings)
    if total is None:
        return None
    where, size = value.step.where, int(np.prod(shape))
    if len(texts) != size:
        findings.wrong(where, f"{len(texts)} values", f"{size}, the length of `{variable.name}`")
        return None
    # an item is a number of the enumeration that a table maps from, else of the variable's own
    items = (start.items if total != IDENTITY else None) or items_of(q.enumeration) or start.items or {}
    reader = _reader(start, q, items)
    if reader is None:
        findings.wrong(where, f"a value of type {start.label}", f"{q.type}")
        return None
    read: list[Any] = []
    for text in texts:
        try:
            read.append(reader(text))
        except (ValueError, KeyError):
            findings.wrong(where, f"`{text}`", q.range)
            return None
    if q.type.is_number and total != IDENTITY:
        kind = np.float64 if q.type.is_float else (np.bool_ if q.type is Type.BOOLEAN else np.int64)
        read = total(np.array(read, dtype=kind)).tolist()
    return read if shape else read[0]


def _split(value: Value, q: Quantity, shape: tuple[int, ...]) -> tuple[str, ...]:
    """The texts of all elements; numbers of an array stand side by side in one."""
    if (shape or value.declared.shape) and len(value.texts) == 1 and q.type.is_number:
        return tuple(value.texts[0].split())
    return value.texts


def _reader(declared: Declared, q: Quantity, items: Items) -> Callable[[str], Any] | None:
    """What reads a text as a value; None where the types do not fit. Whole numbers are numbers too."""
    kind = declared.type
    if kind is None:
        return None
    if q.type.is_float and (kind.is_integer or kind.is_float):
        return float
    if kind.is_integer and (q.type.is_integer or q.type is Type.ENUMERATION):
        return int
    if kind is not q.type:
        return None
    return items.__getitem__ if kind is Type.ENUMERATION else _OTHERS.get(kind)


_OTHERS: Final[Mapping[Type, Callable[[str], Any]]] = {
    Type.BOOLEAN: lambda text: TRUTHS[text.strip()],
    Type.STRING: str,
    Type.BINARY: bytes.fromhex,
}
