"""FMUs that are started again instead of opened again: for many short runs of the same few FMUs in one process.

Unpacking and loading an FMU takes longer than most of these runs. FMI's reset returns an instance to its initial
state; a unit whose reset fails is released.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import atexit
from pathlib import Path
from typing import TypeAlias

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.units.co_simulation import Fmu3Unit
from fmus.units.unit import UnitError

_Key: TypeAlias = tuple[Path, str, tuple[str, ...]]
"""File, name of the unit, and what is recorded besides its outputs."""
_idle: dict[_Key, list[ReusedUnit]] = {}


class ReusedUnit(Fmu3Unit):
    """An FMU of FMI 3.0 Co-Simulation that waits for its next run once it is closed."""

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive)
        self._key = _key(name, archive)

    @override
    def close(self) -> None:
        self.messages.clear()
        try:
            self.reset()
        except UnitError:
            self.release()
        else:
            _idle.setdefault(self._key, []).append(self)

    def release(self) -> None:
        """Release the FMU, so that it cannot be used again."""
        super().close()


def reused_unit(name: str, archive: Archive) -> ReusedUnit:
    """A unit of the FMU in `archive` that waits for its next run, or a new one."""
    waiting = _idle.get(_key(name, archive))
    return waiting.pop() if waiting else ReusedUnit(name, archive)


def _key(name: str, archive: Archive) -> _Key:
    return archive.path, name, tuple(v.name for v in archive.interface.observed)


@atexit.register
def release_all() -> None:
    """Release all units that wait, and their files."""
    for units in _idle.values():
        while units:
            units.pop().release()
