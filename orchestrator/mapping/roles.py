"""Mapping roles: what a variable of another maker may be in place of a signal, each described here and nowhere else.

A mapping file names the role of a variable with `as`:
``delta_f = { variable = "wheel", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class RoleNumber:
    """A number that some roles take."""

    unit: str
    """The unit of measurement that the number is converted to."""
    required: bool = True


@dataclass(frozen=True)
class MappingRole:
    """What a variable may be in place of a signal."""

    signal: str
    """The signal that it stands for, without its bus."""
    unit: str
    """The unit of measurement that the variable is converted to."""
    scale: Callable[[Mapping[str, float]], float]
    """The variable per unit of the signal, from the numbers of the role."""
    hint: str
    """How a mapping template offers the role."""
    numbers: tuple[str, ...] = ()
    """The numbers that the role takes, as `ROLE_NUMBERS` describes them."""
    is_rate: bool = False
    """Whether the variable is the derivative of the signal; the entry `angle` may then name the signal itself."""


ROLE_NUMBERS: Final[Mapping[str, RoleNumber]] = {
    "ratio": RoleNumber("1"),
    "R_w": RoleNumber("m"),
    "m": RoleNumber("kg"),
    "limit": RoleNumber("rad/s", required=False),
}
"""The numbers that roles take, by the name that a mapping file gives them."""

ROLES: Final[Mapping[str, MappingRole]] = {
    "steering_wheel_angle": MappingRole(
        signal="delta_f",
        unit="rad",
        scale=lambda n: n["ratio"],
        hint='{ variable = "...", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }',
        numbers=("ratio",),
    ),
    "steering_rate": MappingRole(
        signal="delta_f",
        unit="rad/s",
        scale=lambda _: 1.0,
        hint='as = "steering_rate"',
        numbers=("limit",),
        is_rate=True,
    ),
    # T_r is the torque on one of the two driven wheels
    "axle_torque": MappingRole("T_r", "N.m", lambda _: 2.0, 'as = "axle_torque"'),
    "wheel_force": MappingRole("T_r", "N", lambda n: 1 / n["R_w"], '"wheel_force"', ("R_w",)),
    "force": MappingRole("T_r", "N", lambda n: 2 / n["R_w"], '"force"', ("R_w",)),
    "acceleration": MappingRole("T_r", "m/s2", lambda n: 2 / (n["R_w"] * n["m"]), '"acceleration"', ("R_w", "m")),
}
"""All roles, by the name that a mapping file gives them."""


def roles_of(signal: str) -> dict[str, MappingRole]:
    """The roles that a variable may have in place of a signal, which is named without its bus; most have none."""
    return {name: role for name, role in ROLES.items() if role.signal == signal}
