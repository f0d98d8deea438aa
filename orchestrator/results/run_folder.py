"""A run as it was kept on disk: what there is of it, also when it was cut short."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

from components.interfaces.problem import Problem, refuse

if TYPE_CHECKING:  # opening a whole recording needs none of them, and a person waits
    from orchestrator.pictures.signals import Signal
    from orchestrator.system.experiment import Scenario

RECORDING, SIGNALS, SYSTEM, SUMMARY = "recording.rrd", "signals.parquet", "system.ssp", "summary.json"
VALID = "a run folder, or an .rrd file"
_TOLD: Final = {"scenario", "title", "status", "units", "versions"}
_REMEDY = "Make a run: macrostep run static"


@dataclass(frozen=True)
class KeptRun:
    """A run folder, or a recording on its own (`folder` is None)."""

    where: str
    folder: Path | None
    recording: Path | None
    """None where there is none"""

    @property
    def name(self) -> str:
        """What the run is called."""
        return (self.folder or Path(self.where)).resolve().name

    @cached_property
    def scenario(self) -> Scenario:
        """The system and the experiment, from `system.ssp`. Raises `RequestError`."""
        if self.folder is None:
            raise refuse(self.where, "a recording on its own", "a run folder", "Its system.ssp says what was recorded.")
        from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415

        return ssp_reader.read(self.folder / SYSTEM)

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """What `summary.json` tells; empty for a run that was cut short, and for a file that is something else."""
        try:
            told = json.loads(((self.folder or Path()) / SUMMARY).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return cast(dict[str, Any], told) if isinstance(told, dict) and told.keys() >= _TOLD else {}

    @cached_property
    def signals(self) -> list[Signal]:
        """All signals of the system."""
        from orchestrator.pictures.signals import signals  # noqa: PLC0415

        return signals(self.scenario.system)

    @property
    def has_rows(self) -> bool:
        """Whether `signals.parquet` is there."""
        return self.folder is not None and (self.folder / SIGNALS).is_file()


def find(request: Path) -> KeptRun | Problem:
    """The run at a path, or what is wrong with it."""
    where = str(request)
    if request.is_dir():
        return _in_folder(request)
    if not request.exists():
        return Problem(where, "no such file or folder", VALID, _REMEDY)
    if not _begins_as_recording(request):
        return Problem(where, "a file that is no recording", VALID, _REMEDY)
    return KeptRun(where, request.parent if _is_run(request.parent) else None, request)


def _in_folder(folder: Path) -> KeptRun | Problem:
    path = folder / RECORDING
    recording = path if path.is_file() else None
    run = KeptRun(str(folder), folder if _is_run(folder) else None, recording)
    if recording is None and not run.has_rows:
        what = f"a run without {RECORDING} and {SIGNALS}" if run.folder else f"a folder without {RECORDING}"
        return Problem(run.where, what, VALID, "Run it again." if run.folder else _REMEDY)
    return run


def _is_run(folder: Path) -> bool:
    return (folder / SYSTEM).is_file()


def _begins_as_recording(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(3) == b"RRF"
