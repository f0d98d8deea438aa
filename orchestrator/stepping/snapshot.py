"""Snapshots: the whole state of a simulation at a tick, in memory or in a file.

A file is NumPy's `.npz` (a zip of arrays, read without pickle): `about` is JSON, `column_TYPE` are the signals and held
inputs of each type, `state_UNIT` is what FMI's serialisation gave of a unit, or a block's memory.
"""

from __future__ import annotations

import itertools
import json
import os
import weakref
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Self, TypeAlias

import numpy as np

from components.interfaces.arguments import checked_arguments
from components.interfaces.problem import refuse
from components.interfaces.quantity import DTYPES, Type
from fmus.toolchain.door import reading
from fmus.units.capabilities import StateCapability
from fmus.units.unit import Column, EndRequested, UnitError
from orchestrator.stepping.written_inputs import WrittenValue

FORMAT: Final = 1
"""The version of the file's form."""
_VALID: Final = "a snapshot that `Snapshot.write` has written"


Past: TypeAlias = tuple[tuple[int, object], ...]
"""First ticks, and what stands for the rows from there on; a simulation that goes back begins other rows."""
UnitStates: TypeAlias = dict[str, tuple[StateCapability, Any]]
"""By unit, its capability and the state that it has saved."""


class StateStore:
    """The states that were saved inside the units of a simulation, as long as somebody has a snapshot with them.

    A snapshot that nobody has any more is only noted: its states are released by the next call of a method here, so
    that no garbage collection calls an FMU in the midst of another call, or after it was closed.
    """

    def __init__(self) -> None:
        self._states: dict[int, UnitStates] = {}
        self._dropped: deque[int] = deque()
        self._numbers = itertools.count()

    def save(self, capabilities: Mapping[str, StateCapability]) -> SavedStates:
        """Save the states of units. Raises `UnitError`."""
        self._tidy()
        states: UnitStates = {}
        try:
            for name, capability in capabilities.items():
                states[name] = capability, capability.save()
        except BaseException:
            _forget(states)
            raise
        number = next(self._numbers)
        self._states[number] = states
        saved = SavedStates(self, number)
        weakref.finalize(saved, self._dropped.append, number).atexit = False
        return saved

    def states(self, number: int) -> UnitStates | None:
        """The states of a number; None where they have been released."""
        return self._states.get(number)

    def _tidy(self) -> None:
        while self._dropped:
            _forget(self._states.pop(self._dropped.popleft(), {}))

    def release(self) -> None:
        """Release all states, before a unit is closed."""
        while self._states:
            _forget(self._states.popitem()[1])


class SavedStates:
    """The states of a snapshot.

    Args:
        store: Where they are.
        number: Their number there.
    """

    def __init__(self, store: StateStore, number: int) -> None:
        self.store, self._number = store, number

    @property
    def states(self) -> UnitStates | None:
        """The states; None where they have been released, with their units."""
        return self.store.states(self._number)


def _forget(states: UnitStates) -> None:
    for capability, state in states.values():
        with suppress(UnitError):  # a unit that cannot release a state keeps it until it is closed
            capability.forget(state)
    states.clear()


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The whole state of a simulation at a tick, as `Simulation.save` gives it."""

    tick: int
    time: float
    """[s]"""
    columns: Mapping[Type, Column] = field(repr=False)
    """By type, the values of all signals, and of inputs that nothing drives."""
    held: frozenset[tuple[str, str]] = field(repr=False)
    """The inputs that were written: their unit and their name."""
    changes: tuple[WrittenValue, ...] = field(repr=False)
    """What was written since the start."""
    parameters: Mapping[str, Any] = field(repr=False)
    """The values of `Simulation.reset`."""
    ended: EndRequested | None
    without_state: tuple[str, ...]
    """The units that save no state, because of which a simulation goes back by a replay from its start."""
    digest: str = field(repr=False)
    """Tells the system apart from others."""
    past: Past = field(repr=False, default=())
    """Of which simulation's rows those up to its tick are."""
    saved: SavedStates | None = field(repr=False, default=None)
    content: Mapping[str, bytes] = field(repr=False, default_factory=dict[str, bytes])
    """UnitStates as bytes, by unit."""

    @property
    def inside(self) -> UnitStates | None:
        """The states that are inside the units; None where they have been released, or come from a file."""
        return None if self.saved is None else self.saved.states

    def states(self) -> Mapping[str, bytes]:
        """The states of all units that can write theirs, as bytes. Raises `UnitError`."""
        writable = {name: pair for name, pair in (self.inside or {}).items() if pair[0].serializes}
        return {name: c.serialized(state) for name, (c, state) in writable.items()} or self.content

    @checked_arguments
    def write(self, path: Path | str) -> None:
        """Write it to a file, which is replaced if it exists, for a simulation of the same system in any process.

        Args:
            path: The file; `.npz` is what its form is called.

        Raises:
            RequestError: The file cannot be written, a unit cannot write its state, or the simulation was closed.
        """
        if self.saved is not None and self.inside is None:
            raise refuse(
                str(path), "a snapshot of a simulation that is closed", "one of an open one", "Write it before."
            )
        target = Path(path)
        partial = target.with_name(f"{target.name}.{os.getpid()}.part")
        try:
            arrays = {"about": _as_bytes(self._about())}
            for kind, column in self.columns.items():
                arrays[f"column_{kind.value}"] = column if kind.is_number else _as_bytes(_plain(column))
            for unit, content in self.states().items():
                arrays[f"state_{unit}"] = np.frombuffer(content, dtype=np.uint8)
            with partial.open("wb") as file:
                np.savez_compressed(file, **arrays)
            partial.replace(target)
        except (OSError, UnitError) as error:
            partial.unlink(missing_ok=True)
            raise refuse(str(path), str(error), "a file that can be written") from error

    def _about(self) -> dict[str, Any]:
        ended = self.ended
        return {
            "format": FORMAT,
            "tick": self.tick,
            "time": self.time,
            "held": sorted(self.held),
            "changes": [[c.tick, c.path, _plain(c.value)] for c in self.changes],
            "parameters": {path: _plain(value) for path, value in self.parameters.items()},
            "ended": None if ended is None else [ended.unit, ended.time],
            "without_state": list(self.without_state),
            "digest": self.digest,
        }

    @classmethod
    @checked_arguments
    def read(cls, path: Path | str) -> Self:
        """Read a file that `write` has written.

        Args:
            path: The file.

        Raises:
            RequestError: It is damaged, or none of a snapshot, or another version wrote it.
        """
        if not Path(path).is_file():
            raise refuse(str(path), "no such file", _VALID)
        damaged = reading(str(path), _VALID, "Save another one.", "a damaged file")
        with damaged, Path(path).open("rb") as file, np.load(file) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about["format"] != FORMAT:
                raise refuse(str(path), f"the form {about['format']}", f"the form {FORMAT} of this version")
            return cls(
                tick=int(about["tick"]),
                time=float(about["time"]),
                columns={kind: _column(arrays[f"column_{kind.value}"], kind) for kind in Type},
                held=frozenset((str(unit), str(name)) for unit, name in about["held"]),
                changes=tuple(WrittenValue(int(k), str(name), _from_plain(v)) for k, name, v in about["changes"]),
                parameters={str(name): _from_plain(value) for name, value in dict(about["parameters"]).items()},
                ended=None
                if about["ended"] is None
                else EndRequested(str(about["ended"][0]), float(about["ended"][1])),
                without_state=tuple(str(name) for name in about["without_state"]),
                digest=str(about["digest"]),
                content={n.removeprefix("state_"): arrays[n].tobytes() for n in arrays.files if n.startswith("state_")},
            )


def _as_bytes(value: Any) -> Any:
    return np.frombuffer(json.dumps(value).encode(), dtype=np.uint8)


def _plain(value: Any) -> Any:
    """A value as JSON has it; bytes are an object with their digits."""
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value  # type: ignore[unknown]


def _from_plain(value: Any) -> Any:
    """The value again. Raises what the value of another file may cause."""
    if isinstance(value, dict):
        return bytes.fromhex(value["bytes"])  # type: ignore[unknown]
    return [_from_plain(item) for item in value] if isinstance(value, list) else value  # type: ignore[unknown]


def _column(array: Any, kind: Type) -> Column:
    """A column from the array that it was written as. Raises `ValueError`."""
    if not kind.is_number:
        items = _from_plain(json.loads(array.tobytes()))
        if any(not isinstance(item, str if kind is Type.STRING else bytes) for item in items):
            raise ValueError(f"a column of {kind.value} with other values")
        column = np.empty(len(items), dtype=np.object_)
        column[:] = items
        return column
    if array.dtype != DTYPES[kind] or array.ndim != 1:
        raise ValueError(f"a column of {array.dtype} for {kind.value}")
    return array
