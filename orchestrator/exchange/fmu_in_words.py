"""An FMU in words, for a person who checks it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from components.interfaces.problem import Problem
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.reading.library import platforms
from fmus.reading.observation import observable, observing
from fmus.toolchain.platform_names import platform_tuple
from fmus.unit_interface import Interface, SuggestedExperiment

_OBSERVABLE: Final = {"local": "local", "calculatedParameter": "calculated"}
"""The causalities of variables that are listed besides inputs, outputs and parameters, in words."""
_MOST_OBSERVABLE: Final = 100
"""The most local variables that are listed."""


def described(name: str, archive: Archive) -> Iterator[str]:
    """What an FMU is: its name, model, interface types, platforms, maker and capabilities, one line each."""
    d: Any = archive.description
    interfaces = " and ".join(kind.in_words for kind in archive.interface_types)
    yield f"{name}: `{archive.interface.kind}`, FMI {d.fmiVersion}, {interfaces}"
    if d.description:
        yield f"  {d.description}"
    suffix = "" if archive.library else f"; none for this machine ({platform_tuple()})"
    sources = ", with sources" if any(name.startswith("sources/") for name in archive.files) else ""
    if len(archive.interface_types) > 1:
        other = next(kind for kind in archive.interface_types if kind is not archive.chosen)
        yield f"  runs as {archive.chosen.in_words}; as {other.in_words} with --interface {other.short}"
    yield f"  runs on {', '.join(platforms(archive)) or 'no platform'}{suffix}{sources}"
    if d.generationTool:
        yield f"  made by {d.generationTool}{f', {d.generationDateAndTime}' if d.generationDateAndTime else ''}"
    if times := _suggested(archive.suggested):
        yield f"  its experiment: {times}"
    can = {"rolls back": archive.interface.rolls_back, "has event mode": archive.interface.event_mode}
    if able := [what for what, is_so in can.items() if is_so]:
        yield f"  {', '.join(able)}"


def _suggested(wished: SuggestedExperiment) -> str:
    """The experiment that an FMU suggests, in words; empty where it suggests none."""
    said = (
        ("start time", wished.start or None, " s"),
        ("stop time", wished.stop, " s"),
        ("step", wished.step, " s"),
        ("internal step", wished.fixed_step, " s"),
        ("tolerance", wished.tolerance, ""),
    )
    steps = [] if wished.any_step or wished.step is None else ["not said to take other steps"]
    return ", ".join([f"{name} {value:g}{unit}" for name, value, unit in said if value is not None] + steps)


def rule_breaches(archive: Archive, broken: Sequence[Problem]) -> Iterator[str]:
    """Whether it keeps the rules of FMI, with all remarks; `broken` is what a strict reader refuses."""
    if broken:
        yield "  breaks rules of FMI, and runs with --lenient only"
    else:
        yield f"  {'breaks rules of FMI that no run needs' if archive.breaks_rules else 'keeps the rules of FMI'}"
    yield from (f"  note: {remark}" for remark in archive.remarks)


def variables(archive: Archive) -> list[str]:
    """The variables of an FMU; of those that can only be recorded, at most `_MOST_OBSERVABLE`."""
    theirs = archive.interface
    shown = {v.name for v in theirs.outputs}
    starts = [v for v in theirs.initials if v.name not in shown]
    groups = (("input", theirs.inputs), ("output", theirs.outputs), ("parameter", theirs.parameters), ("local", starts))
    rows = [("variable", "", "--set", "type", "unit", "start", "")]
    settable = _settable(theirs)
    rows += [
        (f"  {v.name}", causality, *_row(v, theirs, settable)) for causality, variables in groups for v in variables
    ]
    found = observable(archive)
    listed = {row[0].strip() for row in rows}
    others = {name: words for name, c in found.items() if name not in listed and (words := _OBSERVABLE.get(c))}
    only_shown = observing(archive, [*others][:_MOST_OBSERVABLE], {}).interface.observed
    rows += [(f"  {v.name}", others[v.name], *_row(v, theirs, settable)) for v in only_shown]
    left_out = len(others) - len(only_shown)
    return aligned(rows) + ([f"  and {left_out} more, which --record takes as well"] if left_out else [])


def _settable(theirs: Interface) -> dict[str, str]:
    """What may be set before the run besides inputs, each with what it is and its variability, by name."""
    groups = (("start value", theirs.initials), ("", theirs.parameters))
    words = {v.name: (what, theirs.variability.get(v.name, "")) for what, variables in groups for v in variables}
    return {name: ", ".join(word for word in both if word) for name, both in words.items()}


def _row(v: Variable, theirs: Interface, settable: Mapping[str, str]) -> tuple[str, ...]:
    q = v.quantity
    shape = f"[{', '.join(map(str, v.shape))}]" if v.shape else ""
    start = theirs.starts.get(v.name)
    text = "" if start is None else str(start.ravel()[0]) + " ..." if v.shape else str(start)
    return (
        settable.get(v.name, ""),
        f"{q.type}{shape}",
        q.unit if q.type.is_float else "",
        text,
        q.description if q.description != v.name else "",
    )


def aligned(rows: Any) -> list[str]:
    """Align rows of texts in columns."""
    table = [tuple(row) for row in rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))] if table else []
    return ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in table]
