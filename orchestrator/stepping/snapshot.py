"""Snapshots: the whole state of a simulation at a tick, in memory or in a file.

A file is NumPy's `.npz` (a zip of arrays, read without pickle): `about` is JSON, `column_TYPE` are the signals and held
inputs of each type, `state_UNIT` is what FMI's serialisation gave of a unit, or a block's memory.
"""

from __future__ import annotations

import json
import weakref
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Self

import numpy as np

from components.interfaces.arguments import checked_arguments
from components.interfaces.problem import Problem, raise_if_any, refuse
from components.interfaces.quantity import DTYPES, Type
from fmus.toolchain.door import reading
from fmus.units.capabilities import StateCapability
from fmus.units.unit import Column, EndRequested, UnitError
from orchestrator.stepping.written_inputs import WrittenValue

FORMAT: Final = 1
"""The version of the file's form."""
_VALID: Final = "a snapshot that `Snapshot.write` has written"


class SavedStates:
    """The states of units that were saved inside them, by unit; they are released with this, or with the units."""

    def __init__(self, states: Mapping[str, tuple[StateCapability, Any]]) -> None:
        self.states = dict(states)
        self.release = weakref.finalize(self, _forget, self.states)
        """Releases the states; called once, by whoever comes first."""

    @property
    def are_there(self) -> bool:
        """Whether they have not been released."""
        return self.release.alive


def _forget(states: dict[str, tuple[StateCapability, Any]]) -> None:
    for capability, state in states.values():
        try:
            capability.forget(state)
        except UnitError:  # a unit that cannot release a state keeps it until it is closed
            continue
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
    digest: Any = field(repr=False)
    """Gives what tells the system apart from others."""
    saved: SavedStates | None = field(repr=False, default=None)
    content: Mapping[str, bytes] = field(repr=False, default_factory=dict[str, bytes])
    """States as bytes, by unit."""

    def states(self) -> Mapping[str, bytes]:
        """The states of all units that can write theirs, as bytes. Raises `UnitError`."""
        if self.saved is None or not self.saved.are_there:
            return self.content
        writable = {name: pair for name, pair in self.saved.states.items() if pair[0].serializes}
        return {name: capability.serialized(state) for name, (capability, state) in writable.items()}

    @checked_arguments
    def write(self, path: Path | str) -> None:
        """Write it to a file, which is replaced if it exists, for a simulation of the same system in any process.

        Args:
            path: The file; `.npz` is what its form is called.

        Raises:
            RequestError: The file cannot be written, or a unit cannot write its state.
        """
        arrays: dict[str, Any] = {}
        for kind, column in self.columns.items():
            arrays[f"column_{kind.value}"] = column if kind.is_number else _as_bytes(_texts(column, kind))
        try:
            for unit, content in self.states().items():
                arrays[f"state_{unit}"] = np.frombuffer(content, dtype=np.uint8)
            with Path(path).open("wb") as file:
                np.savez_compressed(file, about=_as_bytes(self._about()), **arrays)
        except (OSError, UnitError) as error:
            raise refuse(str(path), str(error), "a file that can be written") from error

    def _about(self) -> dict[str, Any]:
        ended = self.ended
        return {
            "format": FORMAT,
            "tick": self.tick,
            "time": self.time,
            "held": sorted(self.held),
            "changes": [[c.tick, c.path, np.asarray(c.value).tolist()] for c in self.changes],
            "parameters": {path: np.asarray(value).tolist() for path, value in self.parameters.items()},
            "ended": None if ended is None else [ended.unit, ended.time],
            "without_state": list(self.without_state),
            "digest": self.digest(),
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
            digest = str(about["digest"])
            return cls(
                tick=int(about["tick"]),
                time=float(about["time"]),
                columns={kind: _column(arrays[f"column_{kind.value}"], kind) for kind in Type},
                held=frozenset((str(unit), str(name)) for unit, name in about["held"]),
                changes=tuple(WrittenValue(int(tick), str(name), value) for tick, name, value in about["changes"]),
                parameters=dict(about["parameters"]),
                ended=None if about["ended"] is None else EndRequested(*about["ended"]),
                without_state=tuple(about["without_state"]),
                digest=lambda: digest,
                content={n.removeprefix("state_"): arrays[n].tobytes() for n in arrays.files if n.startswith("state_")},
            )

    def check(self, digest: str, columns: Mapping[Type, Column]) -> None:
        """Refuse a snapshot of another system.

        Args:
            digest: What tells the present system apart.
            columns: Its columns.

        Raises:
            RequestError: It is one.
        """
        same = self.digest() == digest and all(self.columns[k].shape == c.shape for k, c in columns.items())
        valid = "one of the same system: units, FMUs, connections, step and algorithm"
        raise_if_any([] if same else [Problem("snapshot", "one of another system", valid, "Make one with `save`.")])


def _as_bytes(value: Any) -> Any:
    return np.frombuffer(json.dumps(value).encode(), dtype=np.uint8)


def _texts(column: Column, kind: Type) -> list[str]:
    return column.tolist() if kind is Type.STRING else [item.hex() for item in column.tolist()]


def _column(array: Any, kind: Type) -> Column:
    """A column from the array that it was written as. Raises `ValueError`."""
    if not kind.is_number:
        texts = json.loads(array.tobytes())
        items = [str(text) if kind is Type.STRING else bytes.fromhex(text) for text in texts]
        column = np.empty(len(items), dtype=np.object_)
        column[:] = items
        return column
    if array.dtype != DTYPES[kind] or array.ndim != 1:
        raise ValueError(f"a column of {array.dtype} for {kind.value}")
    return array
