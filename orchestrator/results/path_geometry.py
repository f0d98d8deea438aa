"""The path between its waypoints P0..P14, and the distance of the vehicle from it; plain numpy, many ticks at once.

Waypoints alone do not say how they are joined. The paths of the controllers of this project consist of lines and arcs
(see `components.controller.dubins`): at P1, P7, P8 and P11 the path runs along the road, and an arc that starts or ends
along the road turns by twice the direction of its chord. P2 tells whether a path is of this kind: where it does not lie
on the first arc found in this way, the waypoints are joined by straight lines instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.maths import Array

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
"""The first and last waypoint; 0 for a line, 1 for an arc that starts along the road, -1 for one that ends along it."""

_NEAR: Final = 0.05
"""[m] Distance from the first arc within which P2 counts as lying on it."""

_SAME: Final = 1e-6
"""[m] Waypoints that are nearer to each other than this coincide, and have no direction between them."""

_STEEPEST: Final = np.pi / 3
"""[rad] Largest angle between the chord of an arc and the road."""

_FINE: Final = np.arange(1, 9) / 8
"""Shares of the length of an arc at which its polyline has points."""


@dataclass(frozen=True)
class Pieces:
    """The lines and arcs of n paths, each field of shape `(n, pieces)`."""

    x: Array
    """[m] Start of the piece, along the road."""
    y: Array
    """[m] Start of the piece, across the road."""
    psi: Array
    """[rad] Direction at the start."""
    kappa: Array
    """[1/m] Curvature, positive to the left; 0 for a line."""
    length: Array
    """[m] Arc length."""

    def points(self, s: Array) -> tuple[Array, Array, Array]:
        """Position and direction at the arc lengths `s` `(n, pieces)` from the start of each piece."""
        half = 0.5 * self.kappa * s
        chord = s * np.sinc(half / np.pi)
        return self.x + chord * np.cos(self.psi + half), self.y + chord * np.sin(self.psi + half), self.psi + 2 * half

    def take(self, i: int) -> Pieces:
        """Only the piece `i` of each path."""
        one = slice(i, i + 1)
        return Pieces(self.x[:, one], self.y[:, one], self.psi[:, one], self.kappa[:, one], self.length[:, one])

    def offsets(self, x: Array, y: Array) -> Array:
        """Distance `(n, pieces)` of one position `(n,)` per path from each piece, positive to the left of it."""
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
    """Lateral distance of positions from the path of the same row. Pieces may have no length.

    Args:
        waypoints_x: The waypoints of each path along the road [m], `(n, 15)`.
        waypoints_y: The same across the road.
        x: One position per path along the road [m], `(n,)`.
        y: The same across the road.

    Returns:
        The distances [m], `(n,)`, positive to the left of the path; NaN where a position is not finite.
    """
    known = np.isfinite(x) & np.isfinite(y)
    x, y = np.where(known, x, 0.0), np.where(known, y, 0.0)
    arcs = _dubins(waypoints_x, waypoints_y)
    errors, is_dubins = _nearest(arcs.offsets(x, y)), _is_dubins(arcs, waypoints_x, waypoints_y)
    if not is_dubins.all():
        errors = np.where(is_dubins, errors, _nearest(_lines(waypoints_x, waypoints_y).offsets(x, y)))
    return np.where(known, errors, np.nan)


def path_lines(waypoints_x: Array, waypoints_y: Array) -> list[Array]:
    """The paths of n rows as polylines that are fine enough to draw.

    Args:
        waypoints_x: The waypoints of each path along the road [m], `(n, 15)`.
        waypoints_y: The same across the road.

    Returns:
        One polyline `(points, 2)` for each path.
    """
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
