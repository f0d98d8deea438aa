"""Declared against measured feedthrough: which outputs move when one input is moved and no step is made."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.units.unit import views
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.determinism import SEED
from orchestrator.exchange.passport.excitation import amplitudes, course, own_step
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic, enumerated, named
from orchestrator.exchange.passport.running import Running, copied, followed, put
from orchestrator.exchange.passport.workplace import Workplace

DECLARED: Final = Topic("feedthrough.declared", "No output follows an input at once without being declared to")

_MOMENTS: Final = (0, 1, 7)
"""The numbers of steps after which inputs are moved."""
_MOST_INPUTS: Final = 200


def moved_outputs(place: Workplace, h: float) -> NDArray[np.bool_]:
    """Whether an input moves an output without a step, `(outputs, inputs)`.

    At each of some instants, one input at a time is moved; the others keep the values of the course.
    """
    interface = place.archive.interface
    found = np.zeros((len(interface.outputs), len(interface.inputs)), dtype=bool)
    given = course(place.archive, h, max(_MOMENTS) + 1, SEED)
    still = {kind: np.zeros_like(table[0]) for kind, table in given.inputs.items()}
    reach = views(interface.inputs, {**still, **amplitudes(place.archive)})
    with Running(place.archive, h) as running:
        done = 0
        for moment in _MOMENTS:
            place.tell(f"moving inputs after {moment} steps")
            followed(running, given, done, moment)
            done = moment
            put(running.inputs, {kind: table[moment] for kind, table in given.inputs.items()})
            for column, variable in enumerate(interface.inputs[:_MOST_INPUTS]):
                found[:, column] |= _moved(running, variable, reach[variable.name])
    return found


def _moved(running: Running, variable: Variable, reach: NDArray[Any]) -> NDArray[np.bool_]:
    """Which outputs change when an input is moved; it is moved back afterwards."""
    column = views(running.interface.inputs, running.inputs)[variable.name]
    kept = column.copy()
    running.set()
    running.show()
    before = copied(running.outputs)
    column[:] = another_value(variable, kept, reach)
    running.set()
    running.show()
    after = copied(running.outputs)
    column[:] = kept
    running.set()
    running.show()
    mine, theirs = (views(running.interface.outputs, columns) for columns in (before, after))
    return np.array([_differ(mine[v.name], theirs[v.name]) for v in running.interface.outputs], dtype=bool)


def another_value(variable: Variable, value: NDArray[Any], reach: NDArray[Any]) -> NDArray[Any]:
    """Valid values that differ from those of an input; texts and bytes stay as they are."""
    q = variable.quantity
    if q.type is Type.BOOLEAN:
        return ~value
    if q.enumeration is not None:
        items = [item.value for item in q.enumeration]
        return np.array([next((i for i in items if i != v), v) for v in value.tolist()], dtype=value.dtype)
    if not q.type.is_number:
        return value
    low, high = q.bounds
    change = reach if q.type.is_float else np.ones_like(value)
    up = value + change
    return np.where(up > (np.inf if high is None else high), value - change, up) if low is None or high else up


def _differ(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return one.tolist() != other.tolist() if one.dtype == object else one.tobytes() != other.tobytes()


def lines(bench: Bench) -> list[Line]:
    """The line about feedthrough."""
    interface = bench.archive.interface
    if not interface.inputs or not interface.outputs:
        return [DECLARED.does_not_apply("it has no inputs, or no outputs")]
    try:
        measured = bench.measure(moved_outputs, own_step(bench.archive))
    except MeasurementError as error:
        return [DECLARED.fails(str(error))]
    declared = interface.feedthrough
    undeclared = [
        f"`{output.name}` follows `{given.name}`, which it does not declare"
        for row, output in enumerate(interface.outputs)
        for column, given in enumerate(interface.inputs)
        if measured[row, column] and not declared[row, column]
    ]
    counts = {
        "declared": Measured(float(declared.sum()), "1"),
        "measured": Measured(float(measured.sum()), "1"),
    }
    return [DECLARED.judged(undeclared, _fine(declared, measured, sorted(interface.undeclared)), counts)]


def _fine(declared: NDArray[np.bool_], measured: NDArray[np.bool_], silent: list[str]) -> str:
    text = f"{measured.sum()} pairs of output and input are seen, all of {declared.sum()} that are declared"
    if unseen := int((declared & ~measured).sum()):
        text = f"{measured.sum()} pairs of output and input are seen, {unseen} more are declared"
    return enumerated([text, f"nothing is declared for {named(silent)}, which counts as all"] if silent else [text])
