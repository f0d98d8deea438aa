"""An FMU in words, for a person who checks it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from components.interfaces.problem import Problem
from fmus.reading.archive import Archive
from fmus.reading.library import platforms
from fmus.toolchain.platform_names import platform_tuple
from fmus.unit_interface import SuggestedExperiment


def described(path: Path, archive: Archive) -> Iterator[str]:
    """What an FMU is: its model, interface types, platforms, maker and capabilities, one line each."""
    d: Any = archive.description
    interfaces = " and ".join(kind.in_words for kind in archive.interface_types)
    yield f"{path.name}: `{archive.interface.kind}`, FMI {d.fmiVersion}, {interfaces}"
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


def aligned(rows: Any) -> list[str]:
    """Align rows of texts in columns."""
    table = [tuple(row) for row in rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))] if table else []
    return ["  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in table]
