"""FMUs that are started again instead of opened again: many short runs of the same few FMUs in one process.

Unpacking and loading an FMU takes longer than most of these runs. FMI's reset brings it back to where it was when it
was new; a unit whose reset fails is let go.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import atexit
from dataclasses import dataclass
from pathlib import Path

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.toolchain.version import Version
from fmus.units.fmu_unit import Fmu3Unit
from fmus.units.unit import Unit, UnitError
from orchestrator.system.source import Fmu

_idle: dict[tuple[Path, str], list[KeptUnit]] = {}


class KeptUnit(Fmu3Unit):
    """A running FMU that waits for its next run once it is closed."""

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive)
        self._key = (archive.path, name)

    @override
    def close(self) -> None:
        self.messages.clear()
        try:
            self._check("the reset failed", self._fmu.reset)
        except UnitError:
            self.release()
        else:
            _idle.setdefault(self._key, []).append(self)

    def release(self) -> None:
        """Let go of the FMU for good."""
        super().close()


@dataclass(frozen=True)
class KeptFmu(Fmu):
    """An FMU file whose units are kept for the next run."""

    @override
    def make(self, name: str) -> Unit:
        if self.archive.version != Version.FMI3:
            return super().make(name)
        waiting = _idle.get((self.archive.path, name))
        return waiting.pop() if waiting else KeptUnit(name, self.archive)


def keep(changed: Fmu, read: Fmu) -> KeptFmu:
    """An FMU with other parameters, from one whose file has been read already."""
    made = KeptFmu(changed.path, changed.parameters, changed.lenient)
    vars(made)["archive"] = read.archive
    return made


@atexit.register
def release_all() -> None:
    """Let go of all units that wait, and of their files."""
    for units in _idle.values():
        while units:
            units.pop().release()
