"""Algebraic loops: outputs that depend on each other at one instant, found by iteration with state rollback.

The numbers that units of the loop give each other are the unknowns z. One evaluation gives all units these inputs,
steps those whose outputs show by stepping (each from the state it had before), and reads the outputs G(z). scipy's
hybrid Newton method solves G(z) = z. In Initialization Mode nothing steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import Linear
from fmus.units.capabilities import StateCapability
from fmus.units.unit import Unit, UnitError, is_failure
from orchestrator.stepping.schedule import Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.system.connection import Connection
from orchestrator.system.system import System

LOOP_TOLERANCE: Final = 1e-9
"""Largest difference between what a unit was given and what the others then show, relative to its size, at least 1."""


_DISCARD: Final = 2
"""The FMI status of a unit that cannot take a value."""
_FAR: Final = 1e6
"""What the residual is taken for where a unit cannot take the inputs."""


class AlgebraicLoop:
    """One group of units that need each other's outputs at the same instant.

    Args:
        system: The whole system.
        group: Names of the units in the loop.
        schedule: Says which of these units show their outputs by stepping.
        units: All running units by name.
        table: The signal table that the units are bound to.
    """

    def __init__(
        self, system: System, group: Sequence[str], schedule: Schedule, units: Mapping[str, Unit], table: SignalTable
    ) -> None:
        self._group = tuple(group)
        self._units, self._table = units, table
        self._stepped = [units[name] for name in group if name in schedule.early]
        self._states = [_state_of(unit) for unit in self._stepped]
        members = frozenset(group)
        inside = {(c.source, c.output): c for c in system.connections if members.issuperset((c.source, c.unit))}
        self._chain = ", ".join(str(wire) for wire in inside.values())
        slots = [table.slots(unit, output, "recorded") for unit, output in inside]
        self._slots = [(table.columns[kind], where) for kind, where in slots if kind.is_float]
        self._starts = [
            (table.columns[kind][where], start)
            for wire, (kind, where) in zip(inside.values(), slots, strict=True)
            if kind.is_float and (start := _start_of(system, wire)) is not None
        ]
        self._others = [(table.columns[kind], where) for kind, where in slots if not kind.is_float]

    def solve(self, t: float, h: float) -> None:
        """Find outputs at `t` that agree with each other, and leave all units there.

        Args:
            t: The present instant [s].
            h: The macro step [s].

        Raises:
            UnitError: There is no solution near the last one, or a unit failed.
        """
        saved = [state.save() for state in self._states]

        def evaluate(z: NDArray[np.float64]) -> NDArray[np.float64]:
            for state, before in zip(self._states, saved, strict=True):
                state.restore(before)
            return self._evaluate(z, t, h)

        try:
            self._solve(evaluate, f"at t = {t:g} s")
        finally:
            for state, before in zip(self._states, saved, strict=True):
                state.forget(before)

    def settle(self) -> None:
        """Find outputs that agree with each other, in Initialization Mode. Raises `UnitError`.

        The search begins with the start values of the inputs, as FMI has it.
        """
        for values, start in self._starts:
            values[:] = start

        def evaluate(z: NDArray[np.float64]) -> NDArray[np.float64]:
            return self._evaluate(z, None, 0.0)

        self._solve(evaluate, "at the start")

    def _solve(self, evaluate: Any, when: str) -> None:
        from scipy import optimize  # noqa: PLC0415 - slow to import, and most systems have no loop

        z = self._values()
        shown = evaluate(z)
        if not np.array_equal(shown, z):

            def residual(x: NDArray[np.float64]) -> NDArray[np.float64]:
                try:
                    return evaluate(x) - x
                except _DiscardedError:  # values that the unit cannot take: the solver tries nearer ones
                    return np.full_like(x, _FAR)

            start = z if (residual(shown) == _FAR).all() else shown
            root: Any = optimize.root(residual, start, method="hybr", options={"xtol": 1e-13})
            if not root.success:  # Levenberg-Marquardt takes longer, and copes with values that are discarded
                root = optimize.root(residual, start, method="lm", options={"xtol": 1e-14, "ftol": 1e-14})
            z = np.asarray(root.x, dtype=float)
            shown = evaluate(z)
        others = [column[where].copy() for column, where in self._others]
        again = evaluate(shown) if self._others else shown
        steady = all(np.array_equal(a, c[where]) for a, (c, where) in zip(others, self._others, strict=True))
        wrong = np.abs(again - z) / np.maximum(1.0, np.abs(z))
        if not (steady and (wrong <= LOOP_TOLERANCE).all()):
            action = f"the algebraic loop {self._chain} has no solution near its last one {when}"
            differ = f"inputs and outputs differ by {np.nanmax(wrong):.2g}"
            raise UnitError(", ".join(self._group), action, [differ if steady else "values that are no floats change"])

    def _values(self) -> NDArray[np.float64]:
        values = [column[where] for column, where in self._slots]
        return np.concatenate(values, dtype=np.float64) if values else np.zeros(0)  # a loop of Booleans alone

    def _evaluate(self, z: NDArray[np.float64], t: float | None, h: float) -> NDArray[np.float64]:
        at = 0
        for column, where in self._slots:
            n = where.stop - where.start
            column[where] = z[at : at + n]
            at += n
        for name in self._group:
            for function in self._table.giving(self._units[name]):
                _checked(self._units[name], function())
        if t is not None:
            for unit in self._stepped:
                _checked(unit, unit.step(t, h))
        for name in self._group:
            for function in self._units[name].getters():
                _checked(self._units[name], function())
        return self._values()


def _start_of(system: System, wire: Connection) -> Any:
    """The value of an output that gives the input on a wire its start value; None where there is none."""
    start = system.units[wire.unit].interface.starts.get(wire.input)
    if start is None or wire.input_element or wire.output_element or not isinstance(wire.conversion, Linear):
        return None
    return wire.conversion.inverse(np.ravel(np.asarray(start, dtype=float)))


def _state_of(unit: Unit) -> StateCapability:
    if unit.state is None:  # the schedule refuses such loops, by what the unit's interface says
        raise UnitError(unit.name, "its state could not be saved", unit.messages)
    return unit.state


class _DiscardedError(UnitError):
    """A unit that cannot evaluate its outputs for the inputs that it was given."""


def _checked(unit: Unit, status: object) -> None:
    if is_failure(status):
        kind = _DiscardedError if status == _DISCARD else UnitError
        raise kind(unit.name, f"returned status {status} while its algebraic loop was solved", unit.messages)
