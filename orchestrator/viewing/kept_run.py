"""A run as it was kept on disk: its system, its rows and its recording, also when it was cut short."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from components.interfaces.problem import Problem, RequestError, refuse
from orchestrator.viewing.rerun_program import executable

if TYPE_CHECKING:  # opening a whole recording needs none of them, and a person waits
    from orchestrator.scenario import Scenario
    from orchestrator.viewing.signals import Signal

RECORDING, SIGNALS, SYSTEM, SUMMARY = "recording.rrd", "signals.parquet", "system.ssp", "summary.json"
_VALID = "a run folder, or an .rrd file"
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
        """What `summary.json` tells; empty for a run that was cut short."""
        try:
            return json.loads(((self.folder or Path()) / SUMMARY).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    @cached_property
    def signals(self) -> list[Signal]:
        """All signals of the system."""
        from orchestrator.viewing.signals import signals  # noqa: PLC0415

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
        return Problem(where, "no such file or folder", _VALID, _REMEDY)
    if not _begins_as_recording(request):
        return Problem(where, "a file that is no recording", _VALID, _REMEDY)
    return KeptRun(where, request.parent if _is_run(request.parent) else None, request)


def _in_folder(folder: Path) -> KeptRun | Problem:
    path = folder / RECORDING
    recording = path if path.is_file() else None
    run = KeptRun(str(folder), folder if _is_run(folder) else None, recording)
    if recording is None and not run.has_rows:
        what = f"a run without {RECORDING} and {SIGNALS}" if run.folder else f"a folder without {RECORDING}"
        return Problem(run.where, what, _VALID, "Run it again." if run.folder else _REMEDY)
    return run


def whole_recording(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Path:
    """A recording of `run` that a viewer can open: its own, a repaired copy, or one made anew from its rows.

    Copies are written into `scratch`, and `tell` is told in one line. Raises `RequestError`.
    """
    if run.recording is not None and _is_whole(run.recording):
        return run.recording
    copy = scratch / f"{run.name.removesuffix('.rrd')}.rrd"
    if run.has_rows:
        from orchestrator.viewing.comparison import rebuild  # noqa: PLC0415 - Rerun is slow to import

        try:
            rebuild(run, copy)
        except RequestError:  # killed while it wrote them
            if run.recording is None:
                raise
        else:
            state = "no recording.rrd" if run.recording is None else "a recording.rrd that is damaged"
            tell(f"{run.where}: {state}; opening one made from signals.parquet")
            return copy
    if run.recording is not None:
        _rerun("rrd", "optimize", "--continue-on-error", str(run.recording), "-o", str(copy))
        if copy.is_file() and _is_whole(copy):
            tell(f"{run.where}: the recording was cut short or is damaged; opening a repaired copy of what can be read")
            return copy
    raise refuse(run.where, "a recording that cannot be read", _VALID, "Run it again.")


def rows(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Mapping[str, Any]:
    """All rows of a run by column, from `signals.parquet`, or from its recording where that is missing.

    Where a signal was not recorded at a tick its number is NaN.

    Raises `RequestError`.
    """
    if run.has_rows and run.folder is not None:
        import pandas as pd  # noqa: PLC0415 - slow to import

        path = run.folder / SIGNALS
        try:
            frame = pd.read_parquet(path)
        except (OSError, ValueError) as error:
            remedy = "Run it again, or open recording.rrd itself."
            raise refuse(str(path), "a file that cannot be read", "the signals.parquet of a run", remedy) from error
        return {str(name): frame[name].to_numpy() for name in frame}
    import numpy as np  # noqa: PLC0415

    from orchestrator.viewing.rerun_stream import read_series  # noqa: PLC0415 - Rerun is slow to import

    series = read_series(whole_recording(run, scratch, tell))
    ticks = np.unique(np.concatenate([found for found, _ in series.values()] or [np.zeros(0, dtype=np.int64)]))
    columns: dict[str, Any] = {"time": ticks * run.scenario.h}
    for signal in run.signals:
        if signal.entity in series:
            own, values = series[signal.entity]
            whole = np.full((len(ticks), values.shape[1]), np.nan)
            whole[np.isin(ticks, own)] = values
            columns |= dict(zip(signal.columns, whole.T, strict=True))
    return columns


def _is_run(folder: Path) -> bool:
    return (folder / SYSTEM).is_file()


def _begins_as_recording(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(3) == b"RRF"


def _is_whole(recording: Path) -> bool:
    return _rerun("rrd", "verify", str(recording)).startswith("1 file verified without error")


def _rerun(*arguments: str) -> str:
    done = subprocess.run([executable(), *arguments], capture_output=True, text=True, check=False)  # noqa: S603
    return done.stdout + done.stderr
