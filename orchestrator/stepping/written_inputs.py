"""Inputs that were written while a simulation ran: what each of them received, instant by instant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY
from orchestrator.system.system import System


class WrittenInputs:
    """The inputs of a system that were held at values, and given back to their connections.

    Args:
        system: The system.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._changes: list[tuple[int, str, Any]] = []

    def add(self, tick: int, path: str, value: Any) -> None:
        """Note that an input is held at a value from a tick on, or follows its connection again (None)."""
        self._changes.append((tick, path, value))

    def columns(self, recorded: Mapping[str, Any], ticks: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """Give what the written inputs received: the values of their connections, or those that were written.

        Args:
            recorded: The recorded columns of the outputs, each of shape `(n,)`.
            ticks: The tick of each row, `(n,)`.

        Returns:
            A column of shape `(n,)` for each element; one whose connection was not recorded is left out.
        """
        found: dict[str, NDArray[Any]] = {}
        for path in dict.fromkeys(path for _, path, _ in self._changes):
            found |= self._received(path, recorded, ticks)
        return found

    def _received(self, path: str, recorded: Mapping[str, Any], ticks: NDArray[np.int64]) -> dict[str, Any]:
        unit, _, name = path.partition(".")
        variable = self._system.variable(path, role="inputs")
        wires = [c for c in self._system.connections if (c.unit, c.input) == (unit, name)]
        found: dict[str, Any] = {}
        for i, element in enumerate(variable.elements):
            wire = next((c for c in wires if c.input_element is None or c.input_element.at == i), None)
            if wire is None:
                connected = np.full(len(ticks), np.ravel(self._system.held[path])[i])
            else:
                at = wire.output_element.at if wire.output_element else (i if wire.input_element is None else 0)
                output = self._system.variable(f"{wire.source}.{wire.output}").elements[at]
                connected = recorded.get(f"{wire.source}.{output}")
                if connected is None:
                    continue
                connected = connected if wire.conversion == IDENTITY else wire.conversion(connected)
            values = connected.copy()
            for tick, _, value in (change for change in self._changes if change[1] == path):
                values[ticks >= tick] = connected[ticks >= tick] if value is None else np.ravel(value)[i]
            found[f"{unit}.{element}"] = values
        return found
