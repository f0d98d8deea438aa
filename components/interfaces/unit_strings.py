"""Unit strings (Modelica spelling) and what they are in SI base units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, Final, cast

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
"""Exponents of the base units; every factor is 1 because all signals of our own are in SI units."""


@dataclass(frozen=True)
class BaseUnit:
    """A unit in SI base units: ``value in base units = factor * value + offset``, as in FMI's `BaseUnit`."""

    exponents: Mapping[str, int]
    factor: float = 1.0
    offset: float = 0.0

    def same_dimension(self, other: BaseUnit) -> bool:
        """Whether both measure the same: equal exponents of all base units."""
        return all(self.exponents.get(b, 0) == other.exponents.get(b, 0) for b in BASE_UNITS)


@cache
def base_unit(unit: str) -> BaseUnit | None:
    """What a unit string means; None for one that nobody knows.

    Strings that no FMU or SSP defines are read by pint (`km/h`, `deg/s`, `rpm`), with the radian as a base unit.
    """
    if unit in UNITS:
        return BaseUnit(UNITS[unit])
    try:
        quantity = _registry().Quantity(1.0, _registry().parse_units(_python_spelling(unit)))
        zero = _registry().Quantity(0.0, quantity.units).to_base_units()
        one = quantity.to_base_units()
    except Exception:  # noqa: BLE001 - pint raises what its parser raises: whatever it cannot read is no unit
        return None
    exponents = {_DIMENSIONS[name]: n for name, n in one.dimensionality.items() if name in _DIMENSIONS}
    if len(exponents) < len(one.dimensionality) or any(not float(n).is_integer() for n in exponents.values()):
        return None
    factor, offset = float(one.magnitude - zero.magnitude), float(zero.magnitude)
    return BaseUnit({base: int(n) for base, n in exponents.items()}, _tidy(factor), offset)


_DIMENSIONS: Final = MappingProxyType(
    {
        "[mass]": "kg",
        "[length]": "m",
        "[time]": "s",
        "[current]": "A",
        "[temperature]": "K",
        "[substance]": "mol",
        "[luminosity]": "cd",
        "[angle]": "rad",
    }
)


_SYMBOLS: Final = """
y- = 1e-24; z- = 1e-21; a- = 1e-18; f- = 1e-15; p- = 1e-12; n- = 1e-9; u- = 1e-6; m- = 1e-3; c- = 1e-2; d- = 1e-1
h- = 1e2; k- = 1e3; M- = 1e6; G- = 1e9; T- = 1e12; P- = 1e15
m = [length]; s = [time]; g = 1e-3 * kg; kg = [mass]; A = [current]; K = [temperature]; mol = [substance]
cd = [luminosity]; rad = [angle]
deg = 0.017453292519943295 * rad; rev = 6.283185307179586 * rad
N = kg * m / s ** 2; J = N * m; W = J / s; Pa = N / m ** 2; bar = 1e5 * Pa; V = W / A; C = A * s; Ohm = V / A
F = C / V; H = V * s / A; T = V * s / m ** 2; Wb = V * s; S = A / V; Hz = 1 / s; Nm = N * m
min = 60 * s; h = 3600 * s; d = 86400 * s; rpm = rev / min; kmh = km / h; kph = km / h; mph = 0.44704 * m / s
percent = 0.01; g_n = 9.80665 * m / s ** 2; l = 1e-3 * m ** 3; t = 1000 * kg; inch = 0.0254 * m; ft = 0.3048 * m
lbf = 4.4482216152605 * N; hp = 745.6998715822702 * W; degC = K; offset: 273.15
"""
"""The unit symbols of Modelica and of vehicle data sheets; pint's own list would read `Nm` as a yarn count."""


@cache
def _registry() -> Any:
    import pint  # noqa: PLC0415 - a quarter of a second that only unknown unit strings cost

    registry = cast(Any, pint.UnitRegistry)(None)
    registry.load_definitions([line.strip() for line in re.split(r"[\n;](?! offset)", _SYMBOLS) if line.strip()])
    return registry


def _python_spelling(unit: str) -> str:
    """`N.m/s2` as `N*m/s**2`. A product as divisor needs parentheses, as in Modelica: `J/kg.K` is ambiguous."""
    if unit.strip() in {"", "-"} or not re.fullmatch(r"[\w./()%\s^*\-\N{MICRO SIGN}\N{DEGREE SIGN}]+", unit):
        raise ValueError(unit)
    text = unit.replace("^", "").replace("**", "").replace("%", "percent").replace("\N{DEGREE SIGN}", "deg")
    if re.search(r"/[^/()]+[.*]", text):
        raise ValueError(unit)
    text = re.sub(r"([A-Za-z\N{MICRO SIGN}])(-?\d+)", r"\1**\2", text)
    return re.sub(r"(?<=[A-Za-z0-9)])\.(?=[A-Za-z(])", "*", text)


def _tidy(factor: float) -> float:
    """Pint's products of factors, rounded where only the last bits are off a short number."""
    short = float(f"{factor:.14g}")
    return short if math.isclose(short, factor, rel_tol=4e-16) else factor
