"""What a program changes of a running system: inputs are held at values, tunable parameters are given others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from components.interfaces.problem import choices, did_you_mean, refuse
from components.interfaces.record import Variable
from fmus.units.unit import Unit
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.stepping.tunable_parameters import is_parameter, tunable_parameter, tunable_paths, value_at_start
from orchestrator.system.system import System


class Writer:
    """Writes to inputs, whose units have to be bound again afterwards, and to parameters.

    Args:
        system: The system.
        table: The signal table that its units are bound to.
        units: The running units by name, as they are when something is written.
    """

    def __init__(self, system: System, table: SignalTable, units: Mapping[str, Unit]) -> None:
        self._system, self._table, self._units = system, table, units

    def write(self, path: str, value: Any) -> None:
        """Hold an input at a value, or give a parameter another one.

        Args:
            path: The full path of the input or the parameter.
            value: A value of its quantity.

        Raises:
            RequestError: There is no such input, the parameter is fixed, or the value is none that it can take.
            UnitError: The unit refuses the value of a parameter.
        """
        unit, _, name = path.partition(".")
        tunes = is_parameter(self._system, path)
        variable = written_variable(self._system, path)
        if problems := variable.quantity.problems(path, value):
            raise refuse(path, problems[0].found, problems[0].valid)
        if tunes:
            self._units[unit].tune(name, value)
        else:
            self._table.hold(unit, name, value)

    def release(self, path: str) -> None:
        """Give an input back to what drives it, or a parameter the value that it had at the start.

        Args:
            path: The full path of the input or the parameter.

        Raises:
            RequestError: There is no such input, or the parameter is fixed.
            UnitError: The unit refuses the value of a parameter.
        """
        unit, _, name = path.partition(".")
        if is_parameter(self._system, path):
            tunable_parameter(self._system, path)
            self._units[unit].tune(name, value_at_start(self._system, path))
        else:
            known_path(self._system, path, "inputs")
            self._table.release(unit, name)


def written_variable(system: System, path: str) -> Variable:
    """The input or the tunable parameter of a path. Raises `RequestError` where there is none."""
    if is_parameter(system, path):
        return tunable_parameter(system, path)
    return system.variable(known_path(system, path, "inputs"), role="inputs")


def known_path(system: System, path: str, role: str) -> str:
    """The same path.

    Args:
        system: The system.
        path: The full path of a variable.
        role: The list of the interface that it stands in: `inputs`, or `recorded`.

    Raises:
        RequestError: There is no such variable.
    """
    known = [f"{n}.{v.name}" for n, s in system.units.items() for v in getattr(s.interface, role)]
    if path not in known:
        shown = [f"{n}.{v.name}" for n, s in system.units.items() for v in s.interface.outputs]
        if role == "inputs" and path in shown:
            raise refuse(path, "an output, which its unit computes", "an input or a tunable parameter")
        what = "input" if role == "inputs" else "output"
        meant = [*known, *tunable_paths(system)] if role == "inputs" else known
        raise refuse(path, f"no such {what}", choices(known), did_you_mean(path, meant))
    return path
