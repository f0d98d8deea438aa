"""One FMU at the end of FMPy's calls, the same for FMI 2.0 and 3.0, with all it logged."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, fmi3
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from fmus.toolchain.version import Version

_SUFFIXES = {
    Version.FMI2: {"Real": "Real", "Integer": "Integer", "Boolean": "Boolean", "Enumeration": "Integer"},
    Version.FMI3: {"Float64": "Float64", "Int32": "Int32", "Boolean": "Boolean", "Enumeration": "Int64"},
}


class FmuDriver:
    """An instance of an FMU; `messages` holds what it logged."""

    def __init__(
        self, path: Path, token: str | None = None, messages: list[str] | None = None, *, event_mode: bool = False
    ) -> None:
        self._folder = tempfile.TemporaryDirectory()
        folder = fmpy.extract(str(path), self._folder.name)
        self.description: Any = fmpy.read_model_description(folder)
        self.version = Version(int(self.description.fmiVersion[0]))
        self.messages: list[str] = [] if messages is None else messages
        kind = {Version.FMI2: fmi2.FMU2Slave, Version.FMI3: fmi3.FMU3Slave}[self.version]
        self.fmu = kind(
            guid=token or self.description.guid,
            unzipDirectory=folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="sample",
        )
        self._alive = False
        self._event_mode = event_mode
        try:
            self._instantiate()
        except Exception:
            self.close()
            raise
        self._alive = True

    def _instantiate(self) -> None:
        if self.version is Version.FMI3:
            self.fmu.instantiate(
                eventModeUsed=self._event_mode,
                logMessage=lambda _env, _status, _category, text: self.messages.append(text.decode()),
            )
            return
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(
            lambda _env, _name, _status, _category, text: self.messages.append(text.decode())
        )
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.fmu.instantiate(callbacks=callbacks)

    def close(self) -> None:
        """Free the instance and what was unpacked; the library stays loaded, as another instance may use it."""
        if self._alive:
            (self.fmu.fmi2FreeInstance if self.version is Version.FMI2 else self.fmu.fmi3FreeInstance)(
                self.fmu.component
            )
        self._folder.cleanup()

    def enter(self, start_time: float = 0.0) -> None:
        """Into Initialization Mode."""
        if self.version is Version.FMI2:
            self.fmu.setupExperiment(startTime=start_time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start_time)

    def start(self, values: Mapping[str, Any] | None = None) -> None:
        """Through Initialization Mode, with these values set."""
        self.enter()
        for name, value in (values or {}).items():
            self.set(name, value)
        self.fmu.exitInitializationMode()

    def step(self, time: float, h: float) -> None:
        """One communication step."""
        self.fmu.doStep(time, h)

    @property
    def clock(self) -> int:
        """The value reference of the one clock."""
        (clock,) = [v for v in self.description.modelVariables if v.type == "Clock"]
        return clock.valueReference

    def tick(self, *, active: bool = True) -> None:
        """Set the clock, in Event Mode."""
        self.fmu.setClock([self.clock], [active])

    def interval(self, reference: int | None = None) -> tuple[float, int]:
        """The interval of a clock, and its qualifier."""
        found, qualifier = (fmi3.fmi3Float64 * 1)(), (fmi3.fmi3IntervalQualifier * 1)()
        references = (fmi3.fmi3ValueReference * 1)(self.clock if reference is None else reference)
        self.fmu.getIntervalDecimal(references, found, qualifier)
        return found[0], qualifier[0]

    def set_interval(self, value: float) -> None:
        """Set the clock's interval, in Initialization Mode."""
        self.fmu.setIntervalDecimal((fmi3.fmi3ValueReference * 1)(self.clock), (fmi3.fmi3Float64 * 1)(value))

    def references(self, name: str) -> tuple[list[int], str, int]:
        """Value references, type and number of elements of a variable, given by its name without an index."""
        found = [v for v in self.description.modelVariables if v.name == name or v.name.startswith(f"{name}[")]
        if not found:
            raise KeyError(name)
        dimensions = [int(d.start) for d in found[0].dimensions or []]
        return [v.valueReference for v in found], found[0].type, int(np.prod([len(found), *dimensions]))

    def get(self, name: str) -> NDArray[np.float64]:
        """All elements of a variable."""
        references, kind, n = self.references(name)
        function = getattr(self.fmu, "get" + _SUFFIXES[self.version][kind])
        values = function(references) if self.version is Version.FMI2 else function(references, nValues=n)
        return np.asarray(list(values), dtype=float)

    def set(self, name: str, value: float | Sequence[float] | NDArray[np.float64]) -> None:
        """All elements of a variable."""
        references, kind, _ = self.references(name)
        suffix = _SUFFIXES[self.version][kind]
        convert = float if suffix in ("Real", "Float64") else int
        getattr(self.fmu, f"set{suffix}")(references, [convert(v) for v in np.ravel(value)])

    def outputs(self) -> NDArray[np.float64]:
        """All outputs, one after the other."""
        names = [v.name.split("[")[0] for v in self.description.modelVariables if v.causality == "output"]
        parts = [self.get(name) for name in dict.fromkeys(names)]
        return np.concatenate(parts)

    def take(self) -> Any:
        """The FMU state."""
        return self.fmu.getFMUstate() if self.version is Version.FMI2 else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        """Back to an FMU state."""
        (self.fmu.setFMUstate if self.version is Version.FMI2 else self.fmu.setFMUState)(state)

    def release(self, state: Any) -> None:
        """Free an FMU state."""
        (self.fmu.freeFMUstate if self.version is Version.FMI2 else self.fmu.freeFMUState)(state)

    def serialize(self, state: Any) -> bytes:
        """The FMU state as bytes."""
        return (self.fmu.serializeFMUstate if self.version is Version.FMI2 else self.fmu.serializeFMUState)(state)

    def deserialize(self, data: bytes) -> Any:
        """The FMU state that bytes hold."""
        name = "deSerializeFMUstate" if self.version is Version.FMI2 else "deserializeFMUState"
        return getattr(self.fmu, name)(data)


def refused(driver: FmuDriver, call: Callable[[], object], text: str) -> None:
    """The call returns an error, and this is what was logged last."""
    driver.messages.clear()
    with pytest.raises(FMICallException):
        call()
    assert driver.messages[-1].partition(": ")[0].startswith(f"fmi{driver.version}")
    assert driver.messages[-1].partition(": ")[2] == text
