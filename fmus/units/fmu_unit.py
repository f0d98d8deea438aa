"""FMUs as units in this process: one foreign call per direction and type, on memory that is shared.

FMPy loads the library and leads the instance through its life cycle; the calls of every macro step go to the library's
functions directly (`fmus.units.value_calls`). What differs between the versions is in `fmus.units.co_simulation`.
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from abc import abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Final, TypeAlias

import numpy as np
from typing_extensions import override

from components.interfaces.problem import refuse
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.kept_files import kept_files
from fmus.reading.library import loaded
from fmus.reading.unpack import unpack
from fmus.toolchain.fmpy_library import FMICallException
from fmus.toolchain.scratch import scratch_folder
from fmus.units.fmi_api import FmiApi
from fmus.units.fmu_state import FmuState
from fmus.units.only_instance import only_instance
from fmus.units.unit import (
    DEFAULT_SETUP,
    Column,
    ExperimentSetup,
    Operation,
    TypedColumns,
    Unit,
    UnitError,
    carry_out,
    is_failure,
    views,
    widths,
)
from fmus.units.value_calls import AccessVerb, ValueCalls

NONSENSE: Final = (MemoryError, OverflowError, ValueError, ctypes.ArgumentError, OSError)
"""What FMPy and ctypes raise for numbers that a library must not give, such as the size of a state."""
_FAILURES: Final = frozenset({"logStatusDiscard", "logStatusError", "logStatusFatal"})
"""FMI's names for the categories of messages that say why a call failed."""

_Moves: TypeAlias = tuple[ValueCalls, list[Operation], list[Operation]]


class FmuUnit(Unit):
    """What the units of all versions of FMI share: unpacking, life cycle, values and state.

    The stop time of a run is told only to an FMU that does not run without it: one that is told may compute its whole
    result for that time.

    Args:
        name: Name of the unit, which is also that of the instance.
        archive: The FMU file.

    Raises:
        RequestError: The library cannot be loaded, or refuses to make an instance.
    """

    api: ClassVar[FmiApi]

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive.interface)
        self._archive = archive
        self._failed_in = ""
        self.called = lambda: self._failed_in
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []
        self._bound_to: tuple[object, ...] = (None, None, None)
        self._moves: dict[tuple[Any, frozenset[str]], _Moves] = {}
        """The calls for this library and these columns, by instance and by the inputs that nobody has a value for."""
        self._settings: dict[str, tuple[Column, Operation]] = {}
        """For each parameter that has been set, the value, and the call that sets it."""
        self._parameters: Mapping[str, Any] = {}
        self._setup = DEFAULT_SETUP
        self._stop_is_told = False
        self._resources = ExitStack()  # released in the opposite order, whether all of them were taken or not
        try:
            if archive.only_once:
                self._resources.enter_context(only_instance(archive))
            folder = archive.unpacked or self._kept() or self._unpacked()
            self._fmu = loaded(self._fmpy_class(), archive, folder, name)
            self._resources.callback(self._fmu.freeLibrary)
            self._fmu.dll.warned = lambda function: self.warned(function=f"`{function}`")
            self._make_instance()
            self._resources.callback(self._free_instance)
        except BaseException:
            self._resources.close()
            raise
        if archive.interface.rolls_back:
            serializes = bool(archive.interface_type.canSerializeFMUstate)
            self.state = FmuState(self._fmu, self.api, self._check, serializes=serializes)

    def _kept(self) -> Path | None:
        """The folder with the files of the FMU in the user's cache, where this unit may share them."""
        if not self._archive.shares_files:
            return None
        kept = kept_files(self._archive)
        if kept.remark:
            self.remark(kept.remark)
        return kept.folder

    def _unpacked(self) -> Path:
        """The folder with the files of the FMU, for this unit alone."""
        folder = Path(self._resources.enter_context(scratch_folder("fmu")))
        unpack(self._archive.path, folder, self._archive.where, VALID_FMU)
        return folder

    def _fmpy_class(self) -> type[Any]:
        return self.api.co_simulation

    @abstractmethod
    def _instantiate(self, *, logging: bool) -> None:
        """Call FMPy's `instantiate`, which raises bare Exception, with all messages or with none."""

    @abstractmethod
    def _enter(self, parameters: Mapping[str, Any], setup: ExperimentSetup) -> None:
        """Lead the instance to Initialization Mode. Raises `UnitError`."""

    @abstractmethod
    def _prepare_step(self) -> None:
        """Prepare the call of every step."""

    def _make_instance(self) -> None:
        try:
            self._make_quiet_instance()
        except Exception as error:
            reason = f" ({'; '.join(self.messages.said())})" if self.messages else ", and does not say why"
            token = f"{self.api.token} `{self._archive.description.guid}`"
            raise refuse(
                self._archive.where,
                f"a library that refuses to make an instance{reason}",
                f"a library that takes the {token} of its modelDescription.xml",
                "Export the FMU again.",
            ) from error
        self._take_address()

    def _make_quiet_instance(self) -> None:
        """Make an instance that says why a call failed, and nothing else: a log of everything takes time."""
        try:
            self._instantiate(logging=False)
        except Exception:  # noqa: BLE001 - a second attempt with logging, without which many give no reason
            self._instantiate(logging=True)
        categories = [c.name for c in self._archive.description.logCategories if c.name in _FAILURES]
        if categories:
            with suppress(FMICallException):
                self._fmu.setDebugLogging(loggingOn=True, categories=categories)

    def _take_address(self) -> None:
        """Note the address of the instance for the calls that are made directly."""
        self._component = int(ctypes.cast(self._fmu.component, ctypes.c_void_p).value or 0)
        self._settings, self._setting = {}, self._value_calls()

    def _free_instance(self) -> None:
        getattr(self._fmu, f"{self.api.prefix}FreeInstance")(self._fmu.component)

    def _check(self, action: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a method of FMPy's object; `action` names the failure in the error. Raises `UnitError`."""
        try:
            return function(*arguments)
        except (FMICallException, *NONSENSE) as error:
            raise UnitError(self.name, f"{action}: {in_words(error)}", self.messages) from error

    def _log(self, status: int, message: bytes | None) -> None:
        if status:
            self.messages.append(message, status)

    def _value_calls(self) -> ValueCalls:
        given = self._archive.references, self._archive.negated
        return ValueCalls(self._fmu, self.api, self._component, *given, unit=self)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        place = self._fmu, inputs, outputs
        if not all(known is new for known, new in zip(self._bound_to, place, strict=True)):
            self._bound_to, self._moves = place, {}  # what the previous calls keep alive is not needed any more
        key = self._component, frozenset(unset)
        if key not in self._moves:
            self._moves[key] = self._moves_of(inputs, outputs, unset)
        self._calls, setters, getters = self._moves[key]
        self._setters, self._getters = [*setters], [*getters]

    def _moves_of(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str]) -> _Moves:
        """The calls that move values, those that set and those that get, and what keeps alive what they use."""
        self._calls = calls = self._value_calls()
        if unset:
            setters = [move for name, move in self._each("Set", inputs).items() if name not in unset]
        else:
            setters = calls.movers("Set", self.interface.inputs, inputs)
        return calls, setters, calls.movers("Get", self.interface.recorded, outputs)

    def _each(self, verb: AccessVerb, columns: TypedColumns) -> dict[str, Operation]:
        """A call for each input or output, by name."""
        return self._calls.each(verb, self.interface.inputs if verb == "Set" else self.interface.recorded, columns)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        wanted = self._archive.suggested.tolerance if setup.tolerance is None else setup.tolerance
        self._parameters, self._setup = parameters, replace(setup, tolerance=wanted)
        self._stop_is_told = False
        try:
            self._enter(parameters, replace(self._setup, stop=None))
        except UnitError as failure:
            self._tell_stop(failure)
        self._prepare_step()

    def _tell_stop(self, failure: UnitError) -> None:
        """Begin again, and tell the FMU the stop time. Raises `failure` where that is no use."""
        if self._stop_is_told or self._setup.stop is None:
            raise failure
        self._stop_is_told = True
        try:
            self._reset_instance()
            self._enter(self._parameters, self._setup)
        except UnitError:
            raise failure from None
        self.messages.clear()
        self.remarks.append(f"it does not run without the stop time, so it was told {self._setup.stop:g} s")

    def _set_parameters(self, parameters: Mapping[str, Any], *, structural: bool = False) -> None:
        given = [v for v in (*self.interface.parameters, *self.interface.initials) if v.name in parameters]
        wanted = [v for v in given if (v.name in self._archive.structural) is structural]
        self._prepare_setting(wanted)
        for variable in wanted:
            self._set_parameter(variable, parameters[variable.name])

    def _prepare_setting(self, variables: Iterable[Variable]) -> None:
        """Prepare the calls that set parameters, which a reset leaves valid."""
        new = [v for v in variables if v.name not in self._settings]
        columns = {kind: zeros(kind, n) for kind, n in widths(new).items()}
        moves, slots = self._setting.each("Set", new, columns), views(new, columns)
        self._settings |= {v.name: (slots[v.name], moves[v.name]) for v in new}

    def _set_parameter(self, variable: Variable, value: Any) -> None:
        slot, move = self._settings[variable.name]
        slot[:] = np.ravel(np.array(value, dtype=slot.dtype)) if variable.shape else value
        if (status := move()) and is_failure(status):
            action = f"setting the parameter {variable.name} to {value} (status {status})"
            raise UnitError(self.name, action, self.messages)
        if status:
            self.warned(status, f"setting the parameter {variable.name}")

    @override
    def tune(self, parameter: str, value: Any) -> None:
        variable = next(v for v in self.interface.parameters if v.name == parameter)
        self._prepare_setting([variable])
        self._set_parameter(variable, value)

    @override
    def setters(self) -> list[Operation]:
        return self._setters

    @override
    def getters(self) -> list[Operation]:
        return self._getters

    @override
    def exit_initialization(self) -> None:
        try:
            self._check("the initialization failed", self._fmu.exitInitializationMode)
        except UnitError as failure:
            self._tell_stop(failure)
            carry_out(self._setters)
            self._check("the initialization failed", self._fmu.exitInitializationMode)

    @override
    def terminate(self) -> None:
        self._check("it could not be terminated", self._fmu.terminate)

    @override
    def reset(self) -> None:
        self._reset_instance()
        self._failed_in = ""
        self._forget_calls()

    def _reset_instance(self) -> None:
        """Return the instance to the state after it was made. Raises `UnitError`."""
        self._check("the reset failed", self._fmu.reset)

    @override
    def close(self) -> None:
        self._resources.close()


def in_words(error: Exception) -> str:
    """Why a call failed."""
    if isinstance(error, FMICallException):
        return str(error)
    return f"its answer is none that can be ({type(error).__name__}{f': {error}' if str(error) else ''})"
