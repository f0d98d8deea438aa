"""Friction circles: how much of the friction limit each axle uses along and across the vehicle.

The bus `tyre` tells the share of the limit in use (`mu_f`, `mu_r`) and the lateral forces. Across, the share is the
lateral force over mu F_z, with the static axle loads that the plant's parameters give (m, g, l_f, l_r, mu); along, it
is what is left of the whole, ``sqrt(share^2 - lateral^2)``, towards driving or braking as the sign of the torque says,
or that of the acceleration where the torque is not known. A plant without these parameters shows its whole share
across, on the side of the lateral force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from orchestrator.pictures import palette
from orchestrator.pictures.plots import parameter_values
from orchestrator.pictures.shapes import (
    Array,
    Colour,
    Lines,
    LineStyle,
    Points,
    PointStyle,
    Shape,
    Still,
    Style,
    entity,
)
from orchestrator.pictures.signals import Cast, Recorded, SignalColumns
from orchestrator.system.system import System

APART: Final = 1.5
"""Half of the distance between the middles of the two circles, in shares of the limit"""

_MIDDLES: Final = np.array([[-APART, 0.0], [APART, 0.0]])

_TYRE: Final = ("tyre", "mu_f", "mu_r", "F_cf", "F_cr")

_TINY: Final = 1e-6
"""Share of the limit that counts as rounding"""


def limits(parameters: Mapping[str, Any]) -> tuple[float, float] | None:
    """The largest force [N] of one front and one rear tyre, mu F_z; None where the plant does not tell its loads."""
    names = ("m", "g", "mu", "l_f", "l_r")
    values = [parameters.get(name) for name in names]
    if not all(isinstance(value, int | float) for value in values):
        return None
    m, g, mu, l_f, l_r = (float(v) for v in values if v is not None)
    found = mu * m * g * l_r / (l_f + l_r) / 2, mu * m * g * l_f / (l_f + l_r) / 2
    return found if min(found) > 0 else None


def shares(columns: SignalColumns, who: Cast, most: tuple[float, float] | None) -> Array | None:
    """Use of the limit (n, 2 axles, 2): along the vehicle (driving positive) and across (left positive)."""
    found = columns.bus(who.plant, *_TYRE)
    if found is None:
        return None
    whole, force = np.stack(found[:2], axis=1), np.stack(found[2:], axis=1)
    across = np.sign(force) * whole if most is None else force / np.array(most)
    across = np.clip(across, -whole, whole)
    rest = whole * whole - across * across
    along = np.sqrt(np.where(rest > _TINY * whole * whole, rest, 0.0))
    told = columns.bus(who.controller, "actuation", "T_r") or columns.bus(who.plant, "motion", "a_x")
    backwards = np.zeros(len(whole), dtype=bool) if told is None else told[0] < 0
    return np.stack([np.where(backwards[:, None], -along, along), across], axis=-1)


def is_known(recorded: Recorded, who: Cast) -> bool:
    """Whether the plant's use of friction and its forces are recorded."""
    return recorded.bus(who.plant, *_TYRE)


def styles(run: str, colour: Colour) -> Iterator[Style]:
    """The circles, and how the use of friction is drawn in them."""
    angle = np.linspace(0, 2 * np.pi, 65)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    yield Still(
        entity=entity("friction", "limit"),
        strips=[*(circle + middle for middle in _MIDDLES)],
        colour=palette.LIMIT,
        size=1.5,
    )
    above = [np.array([[x - 0.01, -1.3], [x + 0.01, -1.3]]) for x in _MIDDLES[:, 0]]
    yield Still(
        entity=entity("friction", "axles"), strips=above, colour=palette.EDGE, size=0.1, labels=["front", "rear"]
    )
    cross = np.array([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]])
    grid = [shape + middle for middle in _MIDDLES for shape in (circle / 2, *cross)]
    yield Still(entity=entity("friction", "grid"), strips=grid, colour=palette.GRID, size=0.5)
    yield PointStyle(entity=entity("friction", run, "past"), size=2, colour=palette.paler(colour), plane=True)
    yield LineStyle(entity=entity("friction", run, "now"), size=3, colour=colour, plane=True)


def shapes(columns: SignalColumns, who: Cast, most: tuple[float, float] | None, run: str) -> Iterator[Shape]:
    """Each row's use of friction as a stroke from the middle of each circle, and its end as a point that stays."""
    found = shares(columns, who, most)
    if found is None:
        return
    ends = _MIDDLES + np.stack([-found[..., 1], -found[..., 0]], axis=-1)  # left and up; planes have y down
    strokes = np.stack([np.broadcast_to(_MIDDLES, ends.shape), ends], axis=2)
    counts = np.full(len(found), 2)
    yield Lines(entity=entity("friction", run, "now"), strips=strokes.reshape(-1, 2, 2), counts=counts)
    yield Points(entity=entity("friction", run, "past"), places=ends.reshape(-1, 2), counts=counts)


def loads(system: System, who: Cast) -> tuple[float, float] | None:
    """`limits` of the plant of a system."""
    return None if who.plant is None else limits(parameter_values(system, who.plant))
