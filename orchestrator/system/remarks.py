"""What a person should know of a system that runs: what is passed on although it may have no meaning."""

from __future__ import annotations

from collections.abc import Iterator

from components.interfaces.conversion import IDENTITY
from components.interfaces.quantity import Quantity, Type
from orchestrator.system.system import System


def enumeration_remarks(system: System) -> Iterator[str]:
    """A remark on each connection of an integer to an enumeration, whose values may be none of its items."""
    for wire in system.connections:
        found = system.variable(f"{wire.source}.{wire.output}").quantity
        wanted = system.variable(f"{wire.unit}.{wire.input}", role="inputs").quantity
        if found.type is Type.INT32 and wanted.type is Type.ENUMERATION and wire.conversion == IDENTITY:
            yield f"{wire}: an integer drives an enumeration; every value is passed on, also one that is {_no(wanted)}"


def _no(wanted: Quantity) -> str:
    if wanted.enumeration is None:
        return "none of its items"
    return f"not in {', '.join(f'{item.value} ({item.name})' for item in wanted.enumeration)}"
