"""The path between its waypoints P0..P14, and how far the vehicle is from it; plain numpy, many ticks at once.

Waypoints alone do not say how they are joined. The path of the controllers here is read as lines and arcs (see
`components.controller.dubins`): at P1, P7, P8 and P11 it runs along the road, and an arc that starts or ends along the
road turns by twice the direction of its chord. P2 is the proof: where it does not lie on the first arc so found, the
waypoints of another construction are joined by straight lines instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

_PIECES: Final = (
    ((0, 1), 0),
    ((1, 3), 1),
    ((4, 5), 0),
    ((6, 7), -1),
    ((7, 8), 0),
    ((8, 9), 1),
    ((9, 10), 0),
    ((10, 11), -1),
    ((11, 14), 0),
)
"""From which waypoint to which; 0 a line, 1 an arc that starts along the road, -1 one that ends along the road."""

_NEAR: Final = 0.05
"""[m] how far P2 may lie from the first arc"""

_SAME: Final = 1e-6
"""[m] Waypoints that are nearer to each other coincide, and have no direction between them."""

_STEEPEST: Final = np.pi / 3
"""[rad] steepest chord of an arc"""

_FINE: Final = np.arange(1, 9) / 8
"""Where on an arc the polyline has its points"""


@dataclass(frozen=True)
class Pieces:
    """Lines and arcs of n paths, shape (n, pieces): start pose, curvature (positive to the left), arc length [m]."""

    x: Array
    y: Array
    psi: Array
    kappa: Array
    length: Array

    def points(self, s: Array) -> tuple[Array, Array, Array]:
        """Position and direction at the arc lengths `s` (n, pieces) from the start of each piece."""
        half = 0.5 * self.kappa * s
        chord = s * np.sinc(half / np.pi)
        return self.x + chord * np.cos(self.psi + half), self.y + chord * np.sin(self.psi + half), self.psi + 2 * half

    def take(self, i: int) -> Pieces:
        """Only the piece `i` of each path."""
        one = slice(i, i + 1)
        return Pieces(self.x[:, one], self.y[:, one], self.psi[:, one], self.kappa[:, one], self.length[:, one])

    def offsets(self, x: Array, y: Array) -> Array:
        """Signed distance (n, pieces) of one position per path from each piece, positive to the left."""
        dx, dy = x[:, None] - self.x, y[:, None] - self.y
        forward = dx * np.cos(self.psi) + dy * np.sin(self.psi)
        left = dy * np.cos(self.psi) - dx * np.sin(self.psi)
        arc = self.kappa != 0
        kappa = np.where(arc, self.kappa, 1.0)
        along = np.where(arc, np.arctan2(kappa * forward, 1 - kappa * left) / kappa, forward)
        low, high = np.zeros_like(along), self.length.copy()
        low[:, 0], high[:, -1] = -np.inf, np.inf  # straight on before the start and beyond the end
        p_x, p_y, psi = self.points(np.clip(along, low, high))
        side = (y[:, None] - p_y) * np.cos(psi) - (x[:, None] - p_x) * np.sin(psi)
        return np.copysign(np.hypot(x[:, None] - p_x, y[:, None] - p_y), side)


def path_error(waypoints_x: Array, waypoints_y: Array, x: Array, y: Array) -> Array:
    """Lateral distance [m] of (x, y) from the path of the same row, positive to the left of it.

    Waypoints have the shape (n, 15), positions (n,). Zero lengths are allowed for; a position that is not a number
    has an error that is none.
    """
    known = np.isfinite(x) & np.isfinite(y)
    x, y = np.where(known, x, 0.0), np.where(known, y, 0.0)
    arcs, lines = _dubins(waypoints_x, waypoints_y), _lines(waypoints_x, waypoints_y)
    found = [_nearest(pieces.offsets(x, y)) for pieces in (arcs, lines)]
    return np.where(known, np.where(_is_dubins(arcs, waypoints_x, waypoints_y), *found), np.nan)


def path_lines(waypoints_x: Array, waypoints_y: Array) -> list[Array]:
    """The paths of n rows (n, 15) as polylines (points, 2) that are fine enough to draw."""
    arcs = _dubins(waypoints_x, waypoints_y)
    points = [np.stack([waypoints_x[:, :1], waypoints_y[:, :1]], axis=-1)]
    for i, (_, kind) in enumerate(_PIECES):
        share = _FINE if kind else _FINE[-1:]
        x, y, _ = arcs.take(i).points(arcs.length[:, i : i + 1] * share)
        points.append(np.stack([x, y], axis=-1))
    fine = np.concatenate(points, axis=1)
    coarse = np.stack([waypoints_x, waypoints_y], axis=-1)
    arc_rows = _is_dubins(arcs, waypoints_x, waypoints_y)
    return [fine[i] if arc_rows[i] else coarse[i] for i in range(len(fine))]


def _nearest(offsets: Array) -> Array:
    return np.take_along_axis(offsets, np.argmin(np.abs(offsets), axis=1)[:, None], axis=1)[:, 0]


def _dubins(x: Array, y: Array) -> Pieces:
    first, last = ([ends[i] for ends, _ in _PIECES] for i in (0, 1))
    kind = np.array([kind for _, kind in _PIECES])
    dx, dy = x[:, last] - x[:, first], y[:, last] - y[:, first]
    chord, direction = np.hypot(dx, dy), np.arctan2(dy, dx)
    half = np.where(kind == 0, 0.0, kind * direction)  # half of the angle that the arc turns by
    psi = direction - half
    kappa = np.where(chord > 0, 2 * np.sin(half) / np.where(chord > 0, chord, 1.0), 0.0)
    return Pieces(x[:, first], y[:, first], psi, kappa, chord / np.sinc(half / np.pi))


def _lines(x: Array, y: Array) -> Pieces:
    dx, dy = np.diff(x, axis=1), np.diff(y, axis=1)
    return Pieces(x[:, :-1], y[:, :-1], np.arctan2(dy, dx), np.zeros_like(dx), np.hypot(dx, dy))


def _is_dubins(arcs: Pieces, x: Array, y: Array) -> NDArray[np.bool_]:
    dx, dy = np.diff(x, axis=1), np.diff(y, axis=1)
    apart = np.hypot(dx, dy) > _SAME
    steepest = np.where(apart, np.abs(np.arctan2(dy, dx)), 0.0).max(axis=1)
    return (np.abs(arcs.offsets(x[:, 2], y[:, 2])[:, 1]) < _NEAR) & (steepest < _STEEPEST)
