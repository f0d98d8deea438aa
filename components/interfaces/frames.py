"""Frames after ISO 8855: x forward, y to the left, yaw and steering positive to the left."""

from __future__ import annotations

from components.interfaces.maths import absolute, clip, cos, fmax, sin


def to_road(psi: float, forward: float, left: float) -> tuple[float, float]:
    """A vector of the body frame, resolved in the road frame.

    ``x = forward cos(psi) - left sin(psi)``, ``y = forward sin(psi) + left cos(psi)``

    Args:
        psi: The yaw angle of the body [rad].
        forward: The component of the vector along the body.
        left: The component to the left.

    Returns:
        The components x and y, in the unit of measurement of the vector.
    """
    return forward * cos(psi) - left * sin(psi), forward * sin(psi) + left * cos(psi)


def slip_angle(v_x: float, v_y: float, delta: float, v_least: float) -> float:
    """The slip angle of a wheel, ``v_y / v_x - delta`` (3), which also holds down to rest and backwards.

    Below `v_least` the sideways speed in the wheel's own frame is divided by `v_least` instead of by `v_x`:
    ``(v_y - v_x delta) / v_least``. The slip is finite at rest, and 0 where the wheel rolls without slipping, so that
    forces proportional to it make a slow vehicle move as the kinematic one.

    Args:
        v_x: The speed of the wheel's centre along the body [m/s].
        v_y: The same to the left of the body [m/s].
        delta: The steering angle of the wheel [rad].
        v_least: Speed from which on (3) holds as it stands [m/s].

    Returns:
        The slip angle [rad].
    """
    return v_y / fmax(absolute(v_x), v_least) - delta * clip(v_x / v_least, -1.0, 1.0)


def corners(x: float, y: float, psi: float, length: float, width: float) -> list[tuple[float, float]]:
    """The corners of a box around its centre in the road frame: front left, then counter-clockwise."""
    points: list[tuple[float, float]] = []
    for forward, left in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)):
        dx, dy = to_road(psi, forward * length, left * width)
        points.append((x + dx, y + dy))
    return points
