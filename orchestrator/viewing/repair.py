"""A recording that opens, and the rows, of a run whose files may be missing or damaged."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from components.interfaces.problem import RequestError, refuse
from orchestrator.results.run_folder import VALID_RUN, KeptRun
from orchestrator.viewing.rerun_program import executable


def whole_recording(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Path:
    """A recording of a run that a viewer can open: its own, one made anew from its rows, or a repaired copy.

    Args:
        run: The run.
        scratch: A folder for a recording that is not its own.
        tell: Called with a line that says where such a recording comes from.

    Returns:
        The file.

    Raises:
        RequestError: Neither the recording nor the rows can be read.
    """
    if run.recording is not None and _is_whole(run.recording):
        return run.recording
    copy = scratch / f"{run.name.removesuffix('.rrd')}.rrd"
    if run.rows is not None:
        from orchestrator.viewing.comparison import rebuild  # noqa: PLC0415 - Rerun is slow to import

        try:
            rebuild(run, rows(run, scratch, tell), copy)
        except RequestError:  # the rows are damaged; the recording may still be read in part
            if run.recording is None:
                raise
        else:
            state = "no recording.rrd" if run.recording is None else "a recording.rrd that is damaged"
            tell(f"{run.where}: {state}; opening one made from {run.rows.name}")
            return copy
    if run.recording is not None:
        _rerun("rrd", "optimize", "--continue-on-error", str(run.recording), "-o", str(copy))
        if copy.is_file() and _is_whole(copy):
            tell(f"{run.where}: the recording was cut short or is damaged; opening a repaired copy of what can be read")
            return copy
    raise refuse(run.where, "a recording that cannot be read", VALID_RUN, "Run it again.")


def rows(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Mapping[str, Any]:
    """All rows of a run, from `signals.parquet`, or from its recording where that file is missing.

    Args:
        run: The run.
        scratch: A folder for a recording that is not its own.
        tell: Called with a line that says where such a recording comes from.

    Returns:
        The values of each column, `(n,)`; NaN where a signal was not recorded at a tick.

    Raises:
        RequestError: The file cannot be read.
    """
    if run.rows is not None:
        return _from_parquet(run.rows)
    import numpy as np  # noqa: PLC0415 - only a run without rows needs them

    from orchestrator.pictures.signals import signals  # noqa: PLC0415
    from orchestrator.recording.series_reader import read_series  # noqa: PLC0415

    series = read_series(whole_recording(run, scratch, tell))
    ticks = np.unique(np.concatenate([own for own, _ in series.values()] or [np.zeros(0, dtype=np.int64)]))
    columns: dict[str, Any] = {"time": run.scenario.start + ticks * run.scenario.h}
    for signal in signals(run.scenario.system):
        if signal.entity in series:
            own, values = series[signal.entity]
            whole = np.full((len(ticks), values.shape[1]), np.nan)
            whole[np.isin(ticks, own)] = values
            columns |= dict(zip(signal.columns, whole.T, strict=True))
    return columns


def _from_parquet(path: Path) -> Mapping[str, Any]:
    import pandas as pd  # noqa: PLC0415 - slow to import

    try:
        frame = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        remedy = "Run it again, or open recording.rrd itself."
        raise refuse(str(path), "a file that cannot be read", "the signals.parquet of a run", remedy) from error
    return {str(name): frame[name].to_numpy() for name in frame}


def _is_whole(recording: Path) -> bool:
    # The text of the tool is read because its exit code is 0 even for a file without any messages.
    return _rerun("rrd", "verify", str(recording)).startswith("1 file verified without error")


def _rerun(*arguments: str) -> str:
    """What Rerun's own program prints."""
    done = subprocess.run([executable(), *arguments], capture_output=True, text=True, check=False)  # noqa: S603
    return done.stdout + done.stderr
