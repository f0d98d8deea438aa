"""The signals of a system and the rows of a run by signal; plain numpy, no viewer.

Nothing here asks for more than there is: a unit that fills no socket, a bus that a controller does not offer, or a
column that was not recorded simply does not show.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from orchestrator.pictures.shapes import Array, entity
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

LARGEST: Final = 1e9
"""Geometry ends here: viewers compute with 32 bits"""

POSE: Final = ("state", "x", "y", "psi")
OBSTACLES: Final = ("obstacles", "valid", "id", "x", "y", "psi", "length", "width")
PATH: Final = ("path", "x", "y")
PLAN: Final = ("plan", "x", "y", "x_d", "y_upper", "y_lower")
"""Bus and signals that it takes to draw the vehicle, the obstacles, the path and the plan"""


@dataclass(frozen=True)
class Signal:
    """One recorded output of a system."""

    unit: str
    variable: Variable

    @cached_property
    def path(self) -> str:
        """The full name, `plant.state.v_x`."""
        return f"{self.unit}.{self.variable.name}"

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """The columns of the results that hold its elements."""
        return tuple(f"{self.unit}.{element}" for element in self.variable.elements)

    @cached_property
    def entity(self) -> str:
        """Where a recording holds it."""
        return entity("signals", *self.path.split("."))

    @property
    def bus(self) -> str:
        """Unit and bus, `plant.state`; the unit alone where the name has no bus."""
        return self.path.rpartition(".")[0]

    @cached_property
    def states(self) -> dict[int, str]:
        """The names of the values of an enumeration or a Boolean; empty for numbers and arrays."""
        quantity = self.variable.quantity
        if quantity.shape:
            return {}
        if quantity.type is Type.BOOLEAN:
            return {0: "false", 1: "true"}
        return {item.value: item.name for item in quantity.enumeration or ()}

    @property
    def is_number(self) -> bool:
        """Whether it can be drawn as a series; texts and binary values cannot."""
        return self.variable.quantity.type.is_number

    @property
    def is_text(self) -> bool:
        """Whether its values are texts."""
        return self.variable.quantity.type is Type.STRING

    @cached_property
    def names(self) -> list[str]:
        """The name of each element within its bus."""
        return [column.rpartition(".")[2] for column in self.columns]

    @cached_property
    def labels(self) -> list[str]:
        """Name and unit of each element as they stand in a legend."""
        unit = self.variable.quantity.unit
        return [name + (f" [{unit}]" if unit else "") for name in self.names]


def signals(system: System) -> list[Signal]:
    """All outputs of all units, in order."""
    return [Signal(unit, variable) for unit, source in system.units.items() for variable in source.interface.outputs]


def bus_paths(unit: str | None, bus: str, *names: str) -> list[str]:
    """The paths of several signals of one bus."""
    return [f"{unit}.{bus}.{name}" for name in names]


class Recorded:
    """Which signals of a system are recorded, and which of them at the same ticks: only those meet in a picture.

    Each of the `groups` names the columns that are recorded at the same ticks; all at every tick if not given.
    """

    def __init__(self, system: System, groups: Sequence[Collection[str]] | None = None) -> None:
        known = signals(system)
        kept = [{c for s in known for c in s.columns}] if groups is None else [set(group) for group in groups]
        found = [[s for s in known if group.issuperset(s.columns)] for group in kept]
        paths = {s.path for group in found for s in group}
        self.signals = [s for s in known if s.path in paths]
        self._numbers = [{s.path for s in group if s.is_number} for group in found]

    def bus(self, unit: str | None, bus: str, *names: str) -> bool:
        """Whether several signals of one bus are recorded at the same ticks."""
        return self.together(*bus_paths(unit, bus, *names))

    def together(self, *paths: str) -> bool:
        """Whether signals that are numbers are recorded at the same ticks."""
        return any(group.issuperset(paths) for group in self._numbers)


class SignalColumns:
    """The rows of a run by signal, as numbers. A signal that was not recorded is not in `signals`; texts are apart."""

    def __init__(self, frame: pd.DataFrame | Mapping[str, Any], known: Sequence[Signal]) -> None:
        kept = {name: i for i, name in enumerate(map(str, frame))}
        recorded = [s for s in known if all(c in kept for c in s.columns)]
        self.signals = [s for s in recorded if s.is_number]
        """Recorded signals whose values are numbers"""
        self.texts: dict[str, list[list[str]]] = {
            s.path: [list(frame[c]) for c in s.columns] for s in recorded if s.is_text
        }
        """Values of each element of the recorded texts"""
        names = ["time", *(c for s in self.signals for c in s.columns)]
        at = {name: i for i, name in enumerate(names)}
        self._rows = _numbers(frame, names, list(kept))
        self._places = {s.path: [at[c] for c in s.columns] for s in self.signals}
        self.time: Array = self._rows[:, 0]

    def has(self, path: str) -> bool:
        """Whether a signal was recorded as numbers."""
        return path in self._places

    def of(self, path: str) -> Array:
        """The values (n,) of a scalar, or (n, elements) of an array."""
        places = self._places[path]
        if len(places) == 1:
            return self._rows[:, places[0]]
        return np.ascontiguousarray(self._rows[:, places])

    def bus(self, unit: str | None, bus: str, *names: str) -> tuple[Array, ...] | None:
        """Several signals of one bus, cut to what a picture can hold; `None` unless all of them are there."""
        paths = bus_paths(unit, bus, *names)
        if not all(path in self._places for path in paths):
            return None
        return tuple(np.clip(self.of(path), -LARGEST, LARGEST) for path in paths)


def _numbers(frame: Any, names: list[str], kept: list[str]) -> Array:
    """The columns `names` side by side, in Fortran order; column by column costs ten times as much in short frames."""
    blocks = getattr(frame, "dtypes", None)
    if blocks is not None and all(kind.kind in "fiub" for kind in blocks.unique()):
        rows = frame.to_numpy(dtype=np.float64)
        at = {name: i for i, name in enumerate(kept)}
        return np.asfortranarray(rows if names == kept else rows[:, [at[name] for name in names]])
    return np.asfortranarray(np.column_stack([np.asarray(frame[n], dtype=np.float64) for n in names]))


@dataclass(frozen=True)
class Cast:
    """Which unit plays which part in the picture: the first that fills the socket, or none."""

    plant: str | None
    traffic: str | None
    controller: str | None


def cast(system: System) -> Cast:
    """The cast of a system."""
    filled = {socket.name: unit for unit, socket in reversed(list(system.sockets.items()))}
    return Cast(filled.get("plant"), filled.get("traffic"), filled.get("controller"))
