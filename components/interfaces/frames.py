"""Frames after ISO 8855: x forward, y to the left, yaw and steering positive to the left."""

from __future__ import annotations

from components.interfaces.maths import cos, sin


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


def corners(x: float, y: float, psi: float, length: float, width: float) -> list[tuple[float, float]]:
    """The corners of a box around its centre in the road frame: front left, then counter-clockwise."""
    points: list[tuple[float, float]] = []
    for forward, left in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)):
        dx, dy = to_road(psi, forward * length, left * width)
        points.append((x + dx, y + dy))
    return points
