"""Which bus of a system shows what: for each record type, the output bus that metrics and pictures are made from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from orchestrator.system.system import System

BusPaths: TypeAlias = Mapping[type, str]
"""The full path of an output bus, `plant.state`, by the record type of the bus; without an entry nothing shows it."""


def shown(system: System) -> BusPaths:
    """The output buses of a system, as its sockets describe them.

    Args:
        system: Any system; units that fill no socket are left out.

    Returns:
        For each record type of an output bus, required or optional, the path of that bus in the first unit whose socket
        offers it. A unit need not have an optional bus: whether its signals exist is for the caller to see.
    """
    paths: dict[type, str] = {}
    for unit, socket in system.sockets.items():
        for bus, record in {**socket.outputs, **socket.optional}.items():
            paths.setdefault(record, f"{unit}.{bus}")
    return paths


def signal_path(buses: BusPaths, record: type, signal: str) -> str:
    """The full path of a signal of a bus; a name that no signal has where nothing shows the bus.

    Args:
        buses: The buses of a system, as `shown` gives them.
        record: The record type of the bus.
        signal: The name of the signal within the bus, also of an element, such as `x[1]`.
    """
    return f"{buses.get(record, '')}.{signal}"


def unit_that_shows(buses: BusPaths, record: type) -> str | None:
    """The name of the unit that shows a bus; None where nothing shows it.

    Args:
        buses: The buses of a system, as `shown` gives them.
        record: The record type of the bus.
    """
    return buses[record].partition(".")[0] if record in buses else None
