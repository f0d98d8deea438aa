"""The signals of a system, and the rows of a run by signal; plain numpy, no viewer.

Nothing here demands that a signal exists: a bus that no unit shows, and a column that was not recorded, are left out.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from components.interfaces.buses import ObstacleList, Plan, VehicleState, Waypoints
from components.interfaces.maths import Array
from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from orchestrator.pictures.shapes import entity
from orchestrator.system.shown import BusPaths, signal_path
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

LARGEST_COORDINATE: Final = 1e9
"""Geometry is cut off here, because viewers compute with 32 bits."""

BusSignals: TypeAlias = tuple[type, *tuple[str, ...]]
"""The record type of a bus, and the names of some of its signals."""

POSE_SIGNALS: Final[BusSignals] = (VehicleState, "x", "y", "psi")
OBSTACLE_SIGNALS: Final[BusSignals] = (ObstacleList, "valid", "id", "x", "y", "psi", "length", "width")
PATH_SIGNALS: Final[BusSignals] = (Waypoints, "x", "y")
PLAN_SIGNALS: Final[BusSignals] = (Plan, "x", "y", "x_d", "y_upper", "y_lower")
"""What the vehicle, the obstacles, the path and the plan are drawn from."""


@dataclass(frozen=True)
class Signal:
    """One output of a unit."""

    unit: str
    variable: Variable

    @cached_property
    def path(self) -> str:
        """The full name, `plant.state.v_x`."""
        return f"{self.unit}.{self.variable.name}"

    @cached_property
    def parts(self) -> tuple[str, ...]:
        """The parts of the full name, which are those of its entity paths too."""
        return tuple(self.path.split("."))

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """The columns of the results that hold its elements."""
        return tuple(f"{self.unit}.{element}" for element in self.variable.elements)

    @cached_property
    def entity(self) -> str:
        """The path of its entity in a recording."""
        return entity("signals", *self.parts)

    @property
    def bus(self) -> str:
        """The path of its bus, `plant.state`; the unit alone where the name has no bus."""
        return self.path.rpartition(".")[0]

    @cached_property
    def name(self) -> str:
        """Its name within its bus, `v_x`."""
        return self.path.rpartition(".")[2]

    @property
    def unit_of_measurement(self) -> str:
        """Its unit of measurement, as Modelica spells it; empty where it has none."""
        return self.variable.quantity.unit

    @cached_property
    def states(self) -> dict[int, str]:
        """The names of the values of an enumeration or a Boolean; empty for numbers and arrays."""
        quantity = self.variable.quantity
        if quantity.shape:
            return {}
        if quantity.type is Type.BOOLEAN:
            return {0: "false", 1: "true"}
        return quantity.enumeration.names if quantity.enumeration else {}

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
        """The name and the unit of measurement of each element, as a legend shows them."""
        unit = self.unit_of_measurement
        return [name + (f" [{unit}]" if unit else "") for name in self.names]


def signals(system: System) -> list[Signal]:
    """All outputs of all units and what is observed besides, in the order of the system."""
    return [Signal(unit, variable) for unit, source in system.units.items() for variable in source.interface.recorded]


class Recorded:
    """Which signals of a system are recorded, and which of them at the same ticks: only those are drawn together.

    Args:
        system: The system.
        groups: The columns of each group that is recorded at the same ticks; every column at every tick if not given.
    """

    def __init__(self, system: System, groups: Sequence[Collection[str]] | None = None) -> None:
        outputs = signals(system)
        columns = [{c for s in outputs for c in s.columns}] if groups is None else [set(group) for group in groups]
        complete = [[s for s in outputs if group.issuperset(s.columns)] for group in columns]
        paths = {s.path for group in complete for s in group}
        self.signals = [s for s in outputs if s.path in paths]
        """The recorded signals."""
        self._numbers = [{s.path for s in group if s.is_number} for group in complete]

    def bus(self, buses: BusPaths, record: type, *names: str) -> bool:
        """Whether several signals of one bus are recorded at the same ticks.

        Args:
            buses: The buses of the system.
            record: The record type of the bus.
            names: The signals of the bus.
        """
        return self.together(*(signal_path(buses, record, name) for name in names))

    def together(self, *paths: str) -> bool:
        """Whether signals that are numbers are recorded at the same ticks."""
        return any(group.issuperset(paths) for group in self._numbers)


class SignalColumns:
    """The rows of a run by signal, as numbers; texts are kept apart.

    Args:
        frame: The column `time` [s], and one column for each signal element that was recorded.
        known: The signals of the system; those that were not recorded are left out.
    """

    def __init__(self, frame: pd.DataFrame | Mapping[str, Any], known: Sequence[Signal]) -> None:
        kept = {name: i for i, name in enumerate(map(str, frame))}
        recorded = [s for s in known if all(c in kept for c in s.columns)]
        self.signals = [s for s in recorded if s.is_number]
        """Recorded signals whose values are numbers."""
        self.texts: dict[str, list[list[str]]] = {
            s.path: [list(frame[c]) for c in s.columns] for s in recorded if s.is_text
        }
        """The values of each element of the recorded texts, by the path of the signal."""
        names = ["time", *(c for s in self.signals for c in s.columns)]
        at = {name: i for i, name in enumerate(names)}
        self._rows = _numbers(frame, names, list(kept))
        self._places = {s.path: [at[c] for c in s.columns] for s in self.signals}
        self.time: Array = self._rows[:, 0]
        """The time of each row [s], `(n,)`."""

    def has(self, path: str) -> bool:
        """Whether a signal was recorded as numbers."""
        return path in self._places

    def of(self, path: str) -> Array:
        """The values of a signal: `(n,)` of a scalar, `(n, elements)` of an array."""
        places = self._places[path]
        if len(places) == 1:
            return self._rows[:, places[0]]
        return np.ascontiguousarray(self._rows[:, places])

    def bus(self, buses: BusPaths, record: type, *names: str) -> tuple[Array, ...] | None:
        """Several signals of one bus, cut off at `LARGEST_COORDINATE`.

        Args:
            buses: The buses of the system.
            record: The record type of the bus.
            names: The signals of the bus.

        Returns:
            The values of each signal, as `of` gives them; None unless all of them were recorded.
        """
        paths = [signal_path(buses, record, name) for name in names]
        if not all(path in self._places for path in paths):
            return None
        return tuple(np.clip(self.of(path), -LARGEST_COORDINATE, LARGEST_COORDINATE) for path in paths)


def _numbers(frame: Any, names: list[str], kept: list[str]) -> Array:
    """The columns `names` side by side, in Fortran order; column by column takes ten times as long in short frames."""
    blocks = getattr(frame, "dtypes", None)
    if blocks is not None and all(kind.kind in "fiub" for kind in blocks.unique()):
        rows = frame.to_numpy(dtype=np.float64)
        at = {name: i for i, name in enumerate(kept)}
        return np.asfortranarray(rows if names == kept else rows[:, [at[name] for name in names]])
    return np.asfortranarray(np.column_stack([np.asarray(frame[n], dtype=np.float64) for n in names]))
