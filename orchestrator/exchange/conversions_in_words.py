"""The conversions between an FMU and the socket that it fills, as equations with units of measurement."""

from __future__ import annotations

import math
from collections.abc import Mapping

from components.interfaces.conversion import Linear
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from fmus.units.adaptation import Link
from orchestrator.mapping.fitting_result import Fitting


def conversions_in_words(fitting: Fitting, theirs: Interface) -> list[str]:
    """How each signal follows from the FMU's variables, or an input of the FMU from the signal; one line each.

    Args:
        fitting: The FMU in its socket.
        theirs: The interface of the FMU.
    """
    adaptation = fitting.adaptation
    ours = {v.name: v for v in (*fitting.interface.inputs, *fitting.interface.outputs)}
    units = {v.name: v for v in (*theirs.inputs, *theirs.outputs)}
    lines = [_equation(link, ours, units) for link in adaptation.outputs]
    for link in adaptation.inputs:
        lines += [_equation(link, ours, units, to_theirs=True) + _limits(link)]
    for rate in adaptation.rates:
        limit = "" if math.isinf(rate.limit) else f", at most {rate.limit:g} per s"
        lines.append(f"{_names(rate.rate, units)} = rate towards {rate.rate.signal}{limit}")
    lines += [f"{name} = integral of what the FMU shows, from 0" for name in adaptation.integrated]
    lines += [f"{name}{_unit(ours.get(name))} = {value}" for name, value in adaptation.constants.items()]
    lines += [f"{name}{_unit(units.get(name))} = {value}, held" for name, value in adaptation.held.items()]
    lines += [f"{bus}: {convention.in_words}" for bus, found in adaptation.conventions.items() for convention in found]
    return lines


def _equation(
    link: Link, ours: Mapping[str, Variable], theirs: Mapping[str, Variable], *, to_theirs: bool = False
) -> str:
    signal, variables = f"{link.signal}{_unit(ours.get(link.signal))}", _names(link, theirs)
    if to_theirs:
        return f"{variables} = {_applied(link.relation.inverse, signal)}"
    return f"{signal} = {_applied(link.relation, variables)}"


def _names(link: Link, theirs: Mapping[str, Variable]) -> str:
    names = list(dict.fromkeys(name for name, _ in link.theirs))
    shown = names[0] if len(names) == 1 else f"{names[0]} ... {names[-1]}"
    return f"{shown}{_unit(theirs.get(names[0]))}"


def _unit(variable: Variable | None) -> str:
    return f" [{variable.quantity.unit}]" if variable is not None and variable.quantity.type.is_float else ""


def _applied(relation: Linear, name: str) -> str:
    factor = {1.0: "", -1.0: "-"}.get(relation.factor, f"{relation.factor:.6g} * ")
    offset = "" if relation.offset == 0 else f" {'-' if relation.offset < 0 else '+'} {abs(relation.offset):.6g}"
    return f"{factor}{name}{offset}"


def _limits(link: Link) -> str:
    """The limits of what the FMU is given."""
    low, high = math.isfinite(link.low), math.isfinite(link.high)
    if low and high:
        return f", kept in [{link.low:g}, {link.high:g}]"
    return f", at least {link.low:g}" if low else f", at most {link.high:g}" if high else ""
