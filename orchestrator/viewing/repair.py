"""A recording that opens, and the rows, of a run whose files may be missing or damaged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import RequestError, refuse
from orchestrator.results.kept_summary import DAMAGED
from orchestrator.results.run_folder import VALID_RUN, KeptRun, parts
from orchestrator.system.parquet_tables import joined, read_parquet
from orchestrator.viewing.rerun_program import answer_of

_VALID_ROWS: Final = "the signals.parquet of a run"


def whole_recording(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Path:
    """A recording of a run that a viewer can open: its own, one made anew from its rows, or a repaired copy.

    Args:
        run: The run.
        scratch: A folder for a recording that is not its own.
        tell: Called with a line that says where such a recording comes from, and what is damaged.

    Returns:
        The file.

    Raises:
        RequestError: Neither the recording nor the rows can be read.
    """
    if run.recording is not None and _is_whole(run.recording):
        return run.recording
    if run.rows is not None:
        copy = _copy(run, scratch)
        from orchestrator.viewing.comparison import rebuild  # noqa: PLC0415 - Rerun is slow to import

        try:
            rebuild(run, _from_parquet(run, run.rows, tell), copy)
        except RequestError as error:  # the recording may still be read in part
            if run.recording is None:
                raise
            _tell(error, tell)
        else:
            state = "no recording.rrd" if run.recording is None else "a recording.rrd that is damaged"
            tell(f"{run.where}: {state}; opening one made from {run.rows.name}")
            tell_of_summary(run, tell)
            return copy
    return _repaired(run, scratch, tell)


def rows(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Mapping[str, Any]:
    """All rows of a run, from `signals.parquet`, or from its recording where that file is missing or damaged.

    Args:
        run: The run.
        scratch: A folder for a recording that is not its own.
        tell: Called with a line that says where such a recording comes from, and what is damaged.

    Returns:
        The values of each column, `(n,)`; NaN where a signal was not recorded at a tick.

    Raises:
        RequestError: Neither can be read.
    """
    if run.rows is not None:
        try:
            return _from_parquet(run, run.rows, tell)
        except RequestError as error:
            if run.recording is None:
                raise
            _tell(error, tell)
    if run.recording is not None and _is_whole(run.recording):
        try:
            return _from_recording(run, run.recording, tell)
        except RequestError as error:
            _tell(error, tell)
    return _from_recording(run, _repaired(run, scratch, tell), tell)


def tell_of_summary(run: KeptRun, tell: Callable[[str], None]) -> None:
    """Name what is damaged in the summary of a run, of which the rest is shown."""
    if damage := run.summary.get(DAMAGED):
        tell(f"{run.where}: damaged and left out: {damage}")


def _from_recording(run: KeptRun, recording: Path, tell: Callable[[str], None]) -> Mapping[str, Any]:
    import numpy as np  # noqa: PLC0415 - only a run without rows needs them

    from orchestrator.pictures.signals import signals  # noqa: PLC0415
    from orchestrator.recording.kept_series import kept_series  # noqa: PLC0415
    from orchestrator.viewing.sound_rows import sound_rows  # noqa: PLC0415

    where = str(run.recording or run.where)
    series = kept_series(recording, where, VALID_RUN, "Run it again.")
    ticks = np.unique(np.concatenate([own for own, _ in series.values()] or [np.zeros(0, dtype=np.int64)]))
    columns: dict[str, Any] = {"time": run.scenario.start + ticks * run.scenario.h}
    for signal in signals(run.scenario.system):
        if signal.entity in series and series[signal.entity][1].shape[1] == len(signal.columns):
            own, values = series[signal.entity]
            whole = np.full((len(ticks), values.shape[1]), np.nan)
            whole[np.isin(ticks, own)] = values
            columns |= dict(zip(signal.columns, whole.T, strict=True))
    return sound_rows(run, columns, where, tell)


def _from_parquet(run: KeptRun, path: Path, tell: Callable[[str], None]) -> Mapping[str, Any]:
    """The rows in a file, or in a folder with parts of them, of which damaged ones are left out."""
    from orchestrator.viewing.sound_rows import sound_rows  # noqa: PLC0415 - only damaged and compared runs need it

    tables: list[Any] = []
    files = [path] if path.is_file() else parts(path.parent)
    for part in files:
        try:
            tables.append(read_parquet(part, str(part), _VALID_ROWS, "Run it again, or open recording.rrd itself."))
        except RequestError as error:
            if not tables and part == files[-1]:
                raise
            _tell(error, tell)
    frame = joined(tables).replace_schema_metadata(None).to_pandas()  # what is noted beside the rows may be damaged
    return sound_rows(run, {str(name): frame[name].to_numpy() for name in frame}, str(path), tell)


def _repaired(run: KeptRun, scratch: Path, tell: Callable[[str], None]) -> Path:
    """A copy of what can be read of the recording of a run. Raises `RequestError`."""
    if run.recording is not None:
        copy = _copy(run, scratch)
        answer_of("rrd", "optimize", "--continue-on-error", str(run.recording), "-o", str(copy))
        if copy.is_file() and _is_whole(copy):
            tell(f"{run.where}: the recording was cut short or is damaged; opening a repaired copy of what can be read")
            return copy
    raise refuse(run.where, "a recording that cannot be read", VALID_RUN, "Run it again.")


def _copy(run: KeptRun, scratch: Path) -> Path:
    return scratch / f"{run.name.removesuffix('.rrd')}.rrd"


def _tell(error: RequestError, tell: Callable[[str], None]) -> None:
    """Say what is damaged where something else takes its place."""
    for problem in error.problems:
        tell(f"{problem.where}: {problem.found}; it is not used")


def _is_whole(recording: Path) -> bool:
    # The text of the tool is read because its exit code is 0 even for a file without messages; a notice may be first.
    return "\n1 file verified without error" in f"\n{answer_of('rrd', 'verify', str(recording))}"
