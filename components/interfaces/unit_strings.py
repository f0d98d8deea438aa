"""The unit strings in use (Modelica spelling) and what they are in SI base units."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

BASE_UNITS: Final = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units of FMI, in the order of its `BaseUnit` element."""


def _unit(**exponents: int) -> MappingProxyType[str, int]:
    return MappingProxyType(exponents)


UNITS: Final = MappingProxyType(
    {
        "1": _unit(),
        "m": _unit(m=1),
        "m2": _unit(m=2),
        "1/m": _unit(m=-1),
        "1/m2": _unit(m=-2),
        "m4": _unit(m=4),
        "s": _unit(s=1),
        "1/s": _unit(s=-1),
        "m/s": _unit(m=1, s=-1),
        "m/s2": _unit(m=1, s=-2),
        "rad": _unit(rad=1),
        "rad/s": _unit(rad=1, s=-1),
        "rad/s2": _unit(rad=1, s=-2),
        "rad/m": _unit(m=-1, rad=1),
        "rad.s/m": _unit(m=-1, s=1, rad=1),
        "1/rad2": _unit(rad=-2),
        "s2/m2": _unit(m=-2, s=2),
        "s2/rad2": _unit(s=2, rad=-2),
        "s4/rad2": _unit(s=4, rad=-2),
        "kg": _unit(kg=1),
        "kg.m2": _unit(kg=1, m=2),
        "N": _unit(kg=1, m=1, s=-2),
        "N.s": _unit(kg=1, m=1, s=-1),
        "N.m": _unit(kg=1, m=2, s=-2),
        "N/rad": _unit(kg=1, m=1, s=-2, rad=-1),
    }
)
"""Exponents of the base units; every factor is 1 because all signals are in SI units."""
