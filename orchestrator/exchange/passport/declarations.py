"""What is odd in the description: limits, units of measurement, nominal values and start values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from components.interfaces.units_of_measurement import base_unit
from fmus.reading.archive import Archive
from orchestrator.exchange.passport.passport_line import Line, Topic, named

STARTS: Final = Topic("declared.starts", "Start values are finite and lie within their limits")
DECLARED_LIMITS: Final = Topic("declared.limits", "Limits and nominal values are in order")
UNITS: Final = Topic("declared.units", "The units of floating-point inputs, outputs and parameters are known")

_EXCHANGED: Final = ("input", "output", "parameter", "structuralParameter", "calculatedParameter")
_FLOATS: Final = ("Real", "Float32", "Float64")


def lines(archive: Archive) -> list[Line]:
    """The lines about the description."""
    variables = list(archive.description.modelVariables)
    n = len(variables)
    found = [
        STARTS.judged(list(odd_starts(archive)), f"all of {n} variables"),
        DECLARED_LIMITS.judged([text for v in variables for text in _odd_limits(v)], f"all of {n} variables"),
    ]
    floats = [v for v in variables if v.type in _FLOATS and v.causality in _EXCHANGED]
    if not floats:
        return [*found, UNITS.does_not_apply("it exchanges no floating-point values")]
    without = [v.name for v in floats if not _unit(v)]
    missing = f"; without a unit, which FMI allows: {named(without)}" if without else ""
    return [*found, UNITS.judged(list(_odd_units(floats, archive)), f"all of {len(floats)} variables{missing}")]


def odd_starts(archive: Archive) -> Iterator[str]:
    """The start values that are not finite, or outside the limits of their variable."""
    for variable in archive.description.modelVariables:
        values = _numbers(variable.start)
        if values is None:
            continue
        low, high = _limit(variable, "min"), _limit(variable, "max")
        if not np.isfinite(values).all():
            yield f"`{variable.name}` starts with {_first(values[~np.isfinite(values)])}"
        elif low is not None and (values < low).any():
            yield f"`{variable.name}` starts with {_first(values[values < low])}, below its minimum {low:g}"
        elif high is not None and (values > high).any():
            yield f"`{variable.name}` starts with {_first(values[values > high])}, above its maximum {high:g}"


def _odd_limits(variable: Any) -> Iterator[str]:
    low, high = _limit(variable, "min"), _limit(variable, "max")
    if low is not None and high is not None and low > high:
        yield f"`{variable.name}` has the minimum {low:g} above its maximum {high:g}"
    nominal = _limit(variable, "nominal")
    if nominal is not None and not (math.isfinite(nominal) and nominal != 0):
        yield f"`{variable.name}` has the nominal value {nominal:g}"


def _odd_units(variables: list[Any], archive: Archive) -> Iterator[str]:
    defined: Mapping[str, Any] = {unit.name: unit for unit in archive.description.unitDefinitions}
    for variable in variables:
        unit = _unit(variable)
        if unit and base_unit(unit) is None and getattr(defined.get(unit), "baseUnit", None) is None:
            yield f"`{variable.name}` has the unit `{unit}`, which is neither known nor defined in SI units"


def _unit(variable: Any) -> str:
    declared = variable.declaredType
    return variable.unit or (declared.unit if declared is not None else None) or ""


def _limit(variable: Any, name: str) -> float | None:
    declared = variable.declaredType
    text = getattr(variable, name) or (getattr(declared, name, None) if declared is not None else None)
    values = _numbers(text)
    return None if values is None or not values.size else float(values[0])


def _numbers(text: Any) -> Any:
    """The numbers that a text lists; None where it lists something else, as start values of Strings do."""
    if text is None or str(text).lower() in ("true", "false"):
        return None
    try:
        return np.array([float(part) for part in str(text).split()])
    except ValueError:
        return None


def _first(values: Any) -> str:
    return f"{float(values.ravel()[0]):g}"
