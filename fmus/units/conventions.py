"""Conversions between our conventions and those of foreign files: axes, reference points and velocities, in place.

Each convention acts on the signals of one bus, given as arrays of numbers or symbols by name: `state` and `ego` have
one element each, the `obstacles` one per slot. `ours` converts values that follow the convention to those of the
contract (ISO 8855, centre of gravity, body frame); `theirs` is its inverse.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol, TypeAlias

from components.interfaces.maths import atan2, cos, hypot, sin

Views: TypeAlias = Mapping[str, Any]
"""The signals of a bus by name, as views of the memory that holds them."""

LEFTWARD: Final = frozenset(
    {"y", "psi", "v_y", "r", "beta", "delta_f", "alpha_f", "alpha_r", "F_cf", "F_cr", "a_y", "r_dot"}
    | {"y_d", "y_upper", "y_lower"}
)
"""Signals that are positive to the left: they change sign where y points to the right and z down."""


class Convention(Protocol):
    """A way to give the signals of a bus that differs from ours."""

    def ours(self, bus: Views) -> None:
        """From this convention to ours."""
        ...

    def theirs(self, bus: Views) -> None:
        """From ours to this convention."""
        ...

    @property
    def in_words(self) -> str:
        """What its values are, and how ours follow from them."""
        ...


@dataclass(frozen=True)
class ReferencePoint:
    """Position and lateral speed of a point of the vehicle `ahead` [m] of its centre of gravity.

    ``x = x_p - a cos(psi)``, ``y = y_p - a sin(psi)``, ``v_y = v_yp - a r``; the rear axle has ``a = -l_r``.
    """

    ahead: float

    @property
    def in_words(self) -> str:
        """What its values are, and how ours follow from them."""
        a = f"{'+' if self.ahead < 0 else '-'} {abs(self.ahead):g} m"
        place = f"{abs(self.ahead):g} m {'behind' if self.ahead < 0 else 'ahead of'} the centre of gravity"
        return f"of a point {place}: x {a} cos(psi), y {a} sin(psi), v_y {a} r"

    def ours(self, bus: Views) -> None:
        """From the point to the centre of gravity."""
        self._move(bus, -self.ahead)

    def theirs(self, bus: Views) -> None:
        """From the centre of gravity to the point."""
        self._move(bus, self.ahead)

    @staticmethod
    def _move(bus: Views, forward: float) -> None:
        x, y, psi, v_y, r = bus["x"], bus["y"], bus["psi"], bus["v_y"], bus["r"]
        x += forward * cos(psi)
        y += forward * sin(psi)
        v_y += forward * r


@dataclass(frozen=True)
class BoxEnd:
    """Positions of boxes at `share` of their length ahead of the centre: 0.5 is the front, -0.5 the rear bumper."""

    share: float

    @property
    def in_words(self) -> str:
        """What its values are, and how ours follow from them."""
        a = f"{'+' if self.share < 0 else '-'} {abs(self.share):g} length"
        return f"of the {'front' if self.share > 0 else 'rear'} bumper: x {a} cos(psi), y {a} sin(psi)"

    def ours(self, bus: Views) -> None:
        """From the end to the centre."""
        self._move(bus, -self.share)

    def theirs(self, bus: Views) -> None:
        """From the centre to the end."""
        self._move(bus, self.share)

    @staticmethod
    def _move(bus: Views, share: float) -> None:
        x, y, psi = bus["x"], bus["y"], bus["psi"]
        ahead = share * bus["length"]
        x += ahead * cos(psi)
        y += ahead * sin(psi)


@dataclass(frozen=True)
class SpeedAndSlip:
    """Speed v and slip angle beta in the places of `v_x` and `v_y`: ``v_x = v cos(beta)``, ``v_y = v sin(beta)``."""

    @property
    def in_words(self) -> str:
        """What its values are, and how ours follow from them."""
        return "speed v and slip angle beta: v_x = v cos(beta), v_y = v sin(beta)"

    def ours(self, bus: Views) -> None:
        """From v and beta."""
        v, beta = bus["v_x"].copy(), bus["v_y"].copy()
        bus["v_x"][:], bus["v_y"][:] = v * cos(beta), v * sin(beta)

    def theirs(self, bus: Views) -> None:
        """To v and beta."""
        v_x, v_y = bus["v_x"].copy(), bus["v_y"].copy()
        bus["v_x"][:], bus["v_y"][:] = hypot(v_x, v_y), atan2(v_y, v_x)


@dataclass(frozen=True)
class RoadFrameVelocity:
    """`v_x` and `v_y` resolved in the road frame instead of the body frame."""

    @property
    def in_words(self) -> str:
        """What its values are, and how ours follow from them."""
        return "velocity in the road frame, turned by -psi into the body frame"

    def ours(self, bus: Views) -> None:
        """From the road frame to the body frame."""
        self._turn(bus, -1.0)

    def theirs(self, bus: Views) -> None:
        """From the body frame to the road frame."""
        self._turn(bus, 1.0)

    @staticmethod
    def _turn(bus: Views, sense: float) -> None:
        c, s = cos(bus["psi"]), sense * sin(bus["psi"])
        v_x, v_y = bus["v_x"].copy(), bus["v_y"].copy()
        bus["v_x"][:], bus["v_y"][:] = c * v_x - s * v_y, s * v_x + c * v_y
