"""Friction circles: how much of the friction limit each axle uses along and across the vehicle.

The bus `tyre` tells the share of the limit in use (`mu_f`, `mu_r`) and the lateral forces. Across the vehicle the share
is the lateral force over mu F_z, with the static axle loads that follow from the plant's parameters (m, g, l_f, l_r,
mu). Along the vehicle it is the rest of the whole share, ``sqrt(share^2 - lateral^2)``, with the sign of the torque, or
with that of the acceleration where the torque is not known. A plant without these parameters shows its whole share
across, on the side of the lateral force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from components.interfaces.buses import Actuation, Motion, Tyre, VehicleState
from components.interfaces.maths import Array
from orchestrator.pictures import palette
from orchestrator.pictures.shapes import (
    Colour,
    Lines,
    LineStyle,
    Points,
    PointStyle,
    Still,
    Style,
    entity,
)
from orchestrator.pictures.signals import Recorded, SignalColumns
from orchestrator.system.shown import BusPaths, parameter_values, unit_that_shows
from orchestrator.system.system import System

APART: Final = 1.5
"""Half of the distance between the centres of the two circles, in shares of the limit."""

_CENTRES: Final = np.array([[-APART, 0.0], [APART, 0.0]])

_TYRE_SIGNALS: Final = (Tyre, "mu_f", "mu_r", "F_cf", "F_cr")

_TINY: Final = 1e-6
"""Share of the limit below which a difference is a rounding error."""


def force_limits(parameters: Mapping[str, Any]) -> tuple[float, float] | None:
    """The largest force [N] of one front and one rear tyre, mu F_z.

    Args:
        parameters: The parameter values of a plant.

    Returns:
        Both forces; None where the parameters do not give the axle loads.
    """
    names = ("m", "g", "mu", "l_f", "l_r")
    values = [parameters.get(name) for name in names]
    if not all(isinstance(value, int | float) for value in values):
        return None
    m, g, mu, l_f, l_r = (float(v) for v in values if v is not None)
    forces = mu * m * g * l_r / (l_f + l_r) / 2, mu * m * g * l_f / (l_f + l_r) / 2
    return forces if min(forces) > 0 else None


def plant_force_limits(system: System, buses: BusPaths) -> tuple[float, float] | None:
    """`force_limits` of the plant of a system; None where the system has no plant."""
    plant = unit_that_shows(buses, VehicleState)
    return None if plant is None else force_limits(parameter_values(system, plant))


def shares(columns: SignalColumns, buses: BusPaths, largest: tuple[float, float] | None) -> Array | None:
    """The use of the friction limit.

    Args:
        columns: The rows of a run.
        buses: The buses of its system.
        largest: The largest forces [N] of a front and a rear tyre; None where they are not known.

    Returns:
        For each row and axle the share along the vehicle (driving positive) and across (left positive), `(n, 2, 2)`;
        None where the use of friction was not recorded.
    """
    tyre = columns.bus(buses, *_TYRE_SIGNALS)
    if tyre is None:
        return None
    whole, force = np.stack(tyre[:2], axis=1), np.stack(tyre[2:], axis=1)
    across = np.sign(force) * whole if largest is None else force / np.array(largest)
    across = np.clip(across, -whole, whole)
    rest = whole * whole - across * across
    along = np.sqrt(np.where(rest > _TINY * whole * whole, rest, 0.0))
    direction = columns.bus(buses, Actuation, "T_r") or columns.bus(buses, Motion, "a_x")
    backwards = np.zeros(len(whole), dtype=bool) if direction is None else direction[0] < 0
    return np.stack([np.where(backwards[:, None], -along, along), across], axis=-1)


def is_known(recorded: Recorded, buses: BusPaths) -> bool:
    """Whether the plant's use of friction and its lateral forces are recorded."""
    return recorded.bus(buses, *_TYRE_SIGNALS)


def styles(run: str, colour: Colour) -> Iterator[Style]:
    """The circles, and how the use of friction is drawn in them.

    Args:
        run: The run's part of the entity paths; empty for a run on its own.
        colour: The colour of the run.
    """
    angle = np.linspace(0, 2 * np.pi, 65)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    circles = [*(circle + centre for centre in _CENTRES)]
    yield Still(entity=entity("friction", "limit"), strips=circles, colour=palette.LIMIT, size=1.5)
    above = [np.array([[x - 0.01, -1.3], [x + 0.01, -1.3]]) for x in _CENTRES[:, 0]]
    names = ["front", "rear"]
    yield Still(entity=entity("friction", "axles"), strips=above, colour=palette.EDGE, size=0.1, labels=names)
    cross = np.array([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]])
    grid = [shape + centre for centre in _CENTRES for shape in (circle / 2, *cross)]
    yield Still(entity=entity("friction", "grid"), strips=grid, colour=palette.GRID, size=0.5)
    yield PointStyle(entity=entity("friction", run, "past"), size=2, colour=palette.paler(colour), plane=True)
    yield LineStyle(entity=entity("friction", run, "now"), size=3, colour=colour, plane=True)


def shapes(
    columns: SignalColumns, buses: BusPaths, largest: tuple[float, float] | None, run: str
) -> Iterator[Lines | Points]:
    """The use of friction in each row, as a line from the centre of each circle and as a point at its end.

    Args:
        columns: The rows of a run.
        buses: The buses of its system.
        largest: The largest forces [N] of a front and a rear tyre; None where they are not known.
        run: The run's part of the entity paths; empty for a run on its own.
    """
    used = shares(columns, buses, largest)
    if used is None:
        return
    ends = _CENTRES + np.stack([-used[..., 1], -used[..., 0]], axis=-1)  # left and up; y points down in the plane
    strokes = np.stack([np.broadcast_to(_CENTRES, ends.shape), ends], axis=2)
    counts = np.full(len(used), 2)
    yield Lines(entity=entity("friction", run, "now"), strips=strokes.reshape(-1, 2, 2), counts=counts)
    yield Points(entity=entity("friction", run, "past"), places=ends.reshape(-1, 2), counts=counts)
