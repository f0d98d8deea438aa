"""The output buses of a system by record type, from which metrics and pictures are made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from components.interfaces.arguments import checked_arguments
from orchestrator.system.system import System

BusPaths: TypeAlias = Mapping[type, str]
"""The full path of an output bus, such as `plant.state`, by record type; a type that no unit shows has no entry."""


@checked_arguments
def shown(system: System) -> BusPaths:
    """The output buses of a system, as its sockets describe them.

    Args:
        system: Any system; units that fill no socket are left out.

    Returns:
        For each record type of an output bus, required or optional, the path of that bus in the first unit whose socket
        offers it. A unit may lack an optional bus, so the caller has to check whether its signals exist.
    """
    paths: dict[type, str] = {}
    for unit, socket in system.sockets.items():
        for bus, record in {**socket.outputs, **socket.optional}.items():
            paths.setdefault(record, f"{unit}.{bus}")
    return paths


def signal_path(buses: BusPaths, record: type, signal: str) -> str:
    """The full path of a signal of a bus.

    Args:
        buses: The buses of a system, as `shown` gives them.
        record: The record type of the bus.
        signal: The name of a signal within the bus, or of an element, such as `x[1]`.

    Returns:
        The path; where no unit shows the bus, a path that no signal has.
    """
    return f"{buses.get(record, '')}.{signal}"


def unit_that_shows(buses: BusPaths, record: type) -> str | None:
    """The name of the unit that shows a bus; `None` where no unit shows it.

    Args:
        buses: The buses of a system, as `shown` gives them.
        record: The record type of the bus.
    """
    return buses[record].partition(".")[0] if record in buses else None


def parameter_values(system: System, unit: str | None) -> Mapping[str, Any]:
    """The parameter values of a unit, with its own start values where the system gives none; empty without a unit."""
    if unit is None:
        return {}
    source = system.units[unit]
    return {**source.interface.starts, **source.parameters}
