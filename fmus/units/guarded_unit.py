"""An FMU of another maker in this process: what it changes of the process is put back after its calls.

A call that never returns or that crashes ends the process all the same; only a process of its own keeps that away.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Generator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.toolchain.process_state import ProcessState
from fmus.units.make import fmu_unit
from fmus.units.unit import DEFAULT_SETUP, ExperimentSetup, Operation, TypedColumns, Unit

_OFTEN: Final = 0.1
"""[s] The time after which everything is put back while the unit is stepped."""


class GuardedUnit(Unit):
    """A unit whose FMU may change the process.

    Args:
        name: Name of the unit.
        archive: The FMU file.

    Raises:
        RequestError: The library of the FMU cannot be used.
    """

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive.interface)
        self._process = ProcessState()
        self._next = 0.0
        try:
            with self._guarded():
                self._inner = fmu_unit(name, archive)
        except BaseException:
            self._process.close()
            raise
        self.messages, self.remarks = self._inner.messages, self._inner.remarks
        self.events, self.state, self.called = self._inner.events, self._inner.state, self._inner.called

    @contextmanager
    def _guarded(self) -> Generator[None]:
        try:
            yield
        finally:
            self._process.restore()

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        self._inner.bind(inputs, outputs, unset)

    @override
    def setters(self) -> list[Operation]:
        return self._inner.setters()

    @override
    def getters(self) -> list[Operation]:
        return self._inner.getters()

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        with self._guarded():
            self._inner.enter_initialization(parameters, setup)

    @override
    def exit_initialization(self) -> None:
        with self._guarded():
            self._inner.exit_initialization()

    @override
    def step(self, t: float, h: float) -> object:
        try:
            return self._inner.step(t, h)
        finally:
            self._process.restore_quickly()
            if (now := time.monotonic()) > self._next:
                self._next = now + _OFTEN
                self._process.restore()

    @override
    def tune(self, parameter: str, value: Any) -> None:
        with self._guarded():
            self._inner.tune(parameter, value)

    @override
    def terminate(self) -> None:
        with self._guarded():
            self._inner.terminate()

    @override
    def reset(self) -> None:
        with self._guarded():
            self._inner.reset()
        self._forget_calls()

    @override
    def close(self) -> None:
        with self._guarded():
            self._inner.close()
        self._process.close()
