"""Units of measurement, spelled as in Modelica, and what they are in SI base units."""

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


@dataclass(frozen=True)
class BaseUnit:
    """A unit of measurement in SI base units, as in FMI: ``value in base units = factor * value + offset``."""

    exponents: Mapping[str, int]
    factor: float = 1.0
    offset: float = 0.0

    def same_dimension(self, other: BaseUnit) -> bool:
        """Whether both measure the same, that is, whether the exponents of all base units are equal."""
        return all(self.exponents.get(b, 0) == other.exponents.get(b, 0) for b in BASE_UNITS)


@dataclass(frozen=True)
class UnitOfMeasurement:
    """A unit of measurement of our own signals and parameters."""

    quantity: str
    """The measured quantity, as the name of an FMI type."""
    base: BaseUnit


def _si(quantity: str, **exponents: int) -> UnitOfMeasurement:
    return UnitOfMeasurement(quantity, BaseUnit(MappingProxyType(exponents)))


UNITS_OF_MEASUREMENT: Final = MappingProxyType(
    {
        "1": _si("Dimensionless"),
        "m": _si("Length", m=1),
        "m2": _si("Area", m=2),
        "1/m": _si("Curvature", m=-1),
        "1/m2": _si("InverseArea", m=-2),
        "m4": _si("SecondMomentOfArea", m=4),
        "s": _si("Time", s=1),
        "1/s": _si("Rate", s=-1),
        "m/s": _si("Velocity", m=1, s=-1),
        "m/s2": _si("Acceleration", m=1, s=-2),
        "rad": _si("Angle", rad=1),
        "rad/s": _si("AngularVelocity", rad=1, s=-1),
        "rad/s2": _si("AngularAcceleration", rad=1, s=-2),
        "rad/m": _si("AnglePerLength", m=-1, rad=1),
        "rad.s/m": _si("AnglePerVelocity", m=-1, s=1, rad=1),
        "1/rad2": _si("InverseAngleSquared", rad=-2),
        "s2/m2": _si("InverseVelocitySquared", m=-2, s=2),
        "s2/rad2": _si("InverseAngularVelocitySquared", s=2, rad=-2),
        "s4/rad2": _si("InverseAngularAccelerationSquared", s=4, rad=-2),
        "kg": _si("Mass", kg=1),
        "kg.m2": _si("MomentOfInertia", kg=1, m=2),
        "N": _si("Force", kg=1, m=1, s=-2),
        "N.s": _si("Impulse", kg=1, m=1, s=-1),
        "N.m": _si("Torque", kg=1, m=2, s=-2),
        "N/rad": _si("CorneringStiffness", kg=1, m=1, s=-2, rad=-1),
        "m3": _si("Volume", m=3),
        "m/s3": _si("Jerk", m=1, s=-3),
        "Hz": _si("Frequency", s=-1),
        "kg/m3": _si("Density", kg=1, m=-3),
        "kg.m/s": _si("Momentum", kg=1, m=1, s=-1),
        "N/m": _si("Stiffness", kg=1, s=-2),
        "N.s/m": _si("Damping", kg=1, s=-1),
        "N.m/rad": _si("RotationalStiffness", kg=1, m=2, s=-2, rad=-1),
        "N.m.s/rad": _si("RotationalDamping", kg=1, m=2, s=-1, rad=-1),
        "Pa": _si("Pressure", kg=1, m=-1, s=-2),
        "J": _si("Energy", kg=1, m=2, s=-2),
        "W": _si("Power", kg=1, m=2, s=-3),
        "K": _si("Temperature", K=1),
        "A": _si("ElectricCurrent", A=1),
        "V": _si("Voltage", kg=1, m=2, s=-3, A=-1),
        "Ohm": _si("Resistance", kg=1, m=2, s=-3, A=-2),
    }
)
"""By symbol; every factor is 1 because all signals of our own are in SI units."""


LONGEST_UNIT: Final = 100
"""The most characters of a unit of measurement that is read."""
_LARGEST_EXPONENT: Final = re.compile(r"[^\W\d_)]\s*[-^*]*\s*\d{3}|\)\s*[-^*]*\s*\d{3}|\d{10}")
"""An exponent of 100 or more, with which pint would compute for hours, or a number beyond all measure."""


@cache
def base_unit(unit: str) -> BaseUnit | None:
    """A unit of measurement in SI base units; `None` for an unknown one.

    Units that no FMU or SSP defines are read by pint (`km/h`, `deg/s`, `rpm`), with the radian as a base unit.
    """
    if unit in UNITS_OF_MEASUREMENT:
        return UNITS_OF_MEASUREMENT[unit].base
    try:
        quantity = _registry().Quantity(1.0, _registry().parse_units(_python_spelling(unit)))
        zero = _registry().Quantity(0.0, quantity.units).to_base_units()
        one = quantity.to_base_units()
    except Exception:  # noqa: BLE001 - pint passes on whatever its parser raises
        return None
    exponents = {_DIMENSIONS[name]: n for name, n in one.dimensionality.items() if name in _DIMENSIONS}
    if len(exponents) < len(one.dimensionality) or any(not float(n).is_integer() for n in exponents.values()):
        return None
    try:
        factor, offset = float(one.magnitude - zero.magnitude), float(zero.magnitude)
    except (ArithmeticError, ValueError):
        return None
    if not (math.isfinite(factor) and factor and math.isfinite(offset)):
        return None
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
"""The symbols of Modelica and of vehicle data sheets; in pint's own list `Nm` is a count of yarn."""


@cache
def _registry() -> Any:
    import pint  # noqa: PLC0415 - the import takes a quarter of a second, which only unknown units cost

    registry = cast(Any, pint.UnitRegistry)(None)
    registry.load_definitions([line.strip() for line in re.split(r"[\n;](?! offset)", _SYMBOLS) if line.strip()])
    return registry


def _python_spelling(unit: str) -> str:
    """`N.m/s2` as `N*m/s**2`. A product as divisor needs parentheses, as in Modelica: `J/kg.K` is ambiguous."""
    if len(unit) > LONGEST_UNIT or _LARGEST_EXPONENT.search(unit):
        raise ValueError(unit)
    if unit.strip() in {"", "-"} or not re.fullmatch(r"[\w./()%\s^*\-\N{MICRO SIGN}\N{DEGREE SIGN}]+", unit):
        raise ValueError(unit)
    text = unit.replace("^", "").replace("**", "").replace("%", "percent").replace("\N{DEGREE SIGN}", "deg")
    if re.search(r"/[^/()]+[.*]", text):
        raise ValueError(unit)
    text = re.sub(r"([A-Za-z\N{MICRO SIGN}])(-?\d+)", r"\1**\2", text)
    return re.sub(r"(?<=[A-Za-z0-9)])\.(?=[A-Za-z(])", "*", text)


def _tidy(factor: float) -> float:
    """A product of factors, rounded where it differs from a short number in its last bits only."""
    short = float(f"{factor:.14g}")
    return short if math.isclose(short, factor, rel_tol=4e-16) else factor
