"""Constant values in a mapping: of signals that an FMU does not show, and of its inputs that no signal drives."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from components.interfaces.problem import Problem, choices, did_you_mean
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from components.interfaces.socket import ANY_LENGTH
from fmus.unit_interface import Interface
from orchestrator.mapping.mapping_file import Amount, MappingFile
from orchestrator.mapping.relations import amount_in, unit_given
from orchestrator.system.value_texts import typed


def signal_constant(signal: Variable, amount: Amount, mapping: MappingFile, problems: list[Problem]) -> Any:
    """The constant value of a signal that the FMU does not show.

    Args:
        signal: The output signal of the socket.
        amount: The value as the mapping gives it.
        mapping: The mapping.
        problems: Receives a problem for a wrong value.

    Returns:
        The value in the shape of the signal; `None` where it is wrong.
    """
    key = f"{mapping.where}: {signal.name}.constant"
    value: Any = amount.value
    if signal.quantity.type.is_float and isinstance(value, int | float):
        value = amount_in(unit_given(signal, mapping), key, amount, problems)
    if value is None:
        return None
    value = _in_every_element(value, signal.shape)
    wrong = signal.quantity.problems(key, value)
    problems += wrong
    return None if wrong else value


def _in_every_element(value: Any, shape: tuple[int, ...]) -> Any:
    """A single value for all elements of an array; other values, and arrays whose length is open, as they are."""
    return value if isinstance(value, list) or ANY_LENGTH in shape else np.full(shape, value).tolist()  # type: ignore[unknown]


def held_inputs(
    theirs: Interface, driven: AbstractSet[str], mapping: MappingFile, problems: list[Problem]
) -> dict[str, Any]:
    """The values that a mapping gives to inputs of the FMU.

    Args:
        theirs: The interface of the FMU.
        driven: The inputs that signals drive, to which no constant can be given.
        mapping: The mapping.
        problems: Receives a problem for each wrong value.

    Returns:
        The value of each input in its own unit of measurement.
    """
    known = {v.name: v for v in theirs.inputs}
    held: dict[str, Any] = {}
    for name, amount in mapping.constants.items():
        key = f"{mapping.where}: constants.{name}"
        if name not in known:
            problems.append(Problem(key, "an unknown input", choices(known), did_you_mean(name, known)))
        elif name in driven:
            problems.append(Problem(key, "a constant for an input that a signal drives", "one of the two"))
        else:
            held[name] = _held(key, amount, known[name].quantity, problems)
    return held


def _held(key: str, amount: Amount, q: Quantity, problems: list[Problem]) -> Any:
    value: Any = typed(amount.value, q)
    if q.type.is_float and isinstance(value, int | float) and q.unit not in {"", amount.unit}:
        value = amount_in(q.unit, key, amount, problems)
    if value is not None:
        problems += q.problems(key, value)
    return value
