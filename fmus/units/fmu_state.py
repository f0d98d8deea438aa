"""The state of an FMU, saved inside it, or as bytes."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from typing_extensions import override

from fmus.units.capabilities import StateCapability
from fmus.units.fmi_api import FmiApi


class FmuState(StateCapability):
    """The FMU state, which stays inside the FMU; a saved state is a pointer to it."""

    def __init__(self, fmu: Any, api: FmiApi, check: Callable[..., Any], *, serializes: bool = False) -> None:
        self._check, self.serializes = check, serializes
        self._get, self._set, self._free = (getattr(fmu, n) for n in (api.get_state, api.set_state, api.free_state))
        self._write, self._read = fmu.serializeFMUState, fmu.deserializeFMUState

    @override
    def save(self) -> Any:
        return self._check("its state could not be saved", self._get)

    @override
    def restore(self, state: Any) -> None:
        self._check("its state could not be restored", self._set, state)

    @override
    def forget(self, state: Any) -> None:
        self._check("its state could not be released", self._free, state)

    @override
    def serialized(self, state: Any) -> bytes:
        return bytes(self._check("its state could not be written", self._write, state))

    @override
    def deserialized(self, content: bytes) -> Any:
        return self._check("its state could not be read", self._read, content)
