"""Simulations that stay open between runs, for many runs of one system with other parameter values."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Self

from orchestrator.stepping.master import Simulation


class SimulationPool:
    """Simulations of one system, each of which is reset for its next run; there are as many as run at the same time.

    Of a system with an FMU that a process can hold only once, there can be only one at a time.

    Args:
        make: Makes a simulation, which is opened here.
    """

    def __init__(self, make: Callable[[], Simulation]) -> None:
        self._make = make
        self._idle: list[Simulation] = []
        self._changing = threading.Lock()

    @contextmanager
    def simulation(self, parameters: Mapping[str, Any] = MappingProxyType({})) -> Generator[Simulation]:
        """A simulation at its start, for a `with` statement; nobody else has it meanwhile, and an error closes it.

        Args:
            parameters: Values by full path, in place of those that the simulation was made with.

        Raises:
            RequestError: The simulation cannot be opened, or a parameter cannot have such a value.
            SimulationError: A unit cannot be initialised.
        """
        with self._changing:
            simulation = self._idle.pop() if self._idle else self._make()
        try:
            simulation.reset(parameters)
            simulation.__enter__()
            yield simulation
        except BaseException:
            simulation.close()
            raise
        with self._changing:
            self._idle.append(simulation)

    def close(self) -> None:
        """Close all simulations that nobody has."""
        with self._changing:
            while self._idle:
                self._idle.pop().close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
