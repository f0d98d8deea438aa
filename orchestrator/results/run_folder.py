"""The run folder: the names of its files, the start of a new one, and what remains of a run that was cut short.

A run folder holds `SIGNALS` (all signals, with units of measurement in the metadata), `RECORDING` (Rerun), `SUMMARY`
(metrics, verdicts, versions, hashes, parameters), `SYSTEM` and pictures in `FIGURES`, all of which its manifest lists.
The summary is written last: a folder without it belongs to a run that was cut short, whose rows are in `ROWS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.problem import Problem, refuse
from orchestrator.results.claimed_folder import ClaimedFolder, claim
from orchestrator.results.manifest import Contents
from orchestrator.system.contents import is_file, is_folder

if TYPE_CHECKING:  # opening a whole recording does not need it, and a person waits
    from orchestrator.system.experiment import Scenario

RECORDING: Final = "recording.rrd"
SIGNALS: Final = "signals.parquet"
SYSTEM: Final = "system.ssp"
SUMMARY: Final = "summary.json"
FIGURES: Final = "figures"
"""A folder of PNG files."""

ROWS: Final = "rows"
"""A folder of parquet files while the run lasts, each with some of the rows; `pandas.read_parquet` reads it as one."""
PART: Final = "part-*.parquet"
"""The files in it, in the order of their names."""
MEANING: Final = "_common_metadata"
"""What the columns of these files are, as parquet has it."""
DRAFT: Final = ".draft.json"
"""The summary as it is known before the end of the run."""
RESERVE: Final = ".reserve"
"""Room on the disk that is kept for the summary."""
PICTURES: Final = ("trajectory", "actuation", "yaw_rate", "acceleration", "friction", "speed", "path_error")
"""The names of the figures."""

UNFINISHED: Final = (DRAFT, RESERVE, *(f"{ROWS}/{name}" for name in (PART, f".{PART}", MEANING, f".{MEANING}")))
"""What a run writes that is not there any more when it is finished."""
RUN: Final = Contents(
    "run",
    (
        *(SUMMARY, f".{SUMMARY}", SYSTEM, SIGNALS, f".{SIGNALS}", RECORDING, f".{RECORDING}"),
        *UNFINISHED,
        *(f"{FIGURES}/{name}.png" for name in PICTURES),
    ),
)
"""What a run writes."""

VALID_RUN: Final = "a run folder, or an .rrd file"
"""What a request for a run may name, as messages put it."""
_REMEDY: Final = "Make a run: macrostep run static"


def new_folder(scenario: str, out: Path | None, here: Path | None = None) -> ClaimedFolder:
    """Make the folder for a run, which this process alone writes to.

    Args:
        scenario: The scenario's name, which names the folder where nothing else does.
        out: The folder; the next free ``runs/NAME-1``, ``-2``, ... if not given.
        here: What relative paths are relative to; the working folder if not given.

    Returns:
        The folder, in which nothing is left of a former run.

    Raises:
        RequestError: Something that no run wrote is in the way, another process writes there, or nobody can.
    """
    return claim(scenario, out, RUN, here)


def is_run(folder: Path) -> bool:
    """Whether a folder holds a run, whole or cut short."""
    return is_file(folder / SYSTEM)


def write_system(scenario: Scenario, folder: Path) -> None:
    """Write the system and the experiment of a run before its first step, so that even a run that dies can be repeated.

    Args:
        scenario: What is run.
        folder: The run folder.
    """
    from orchestrator.ssp import writer as ssp_writer  # noqa: PLC0415 - reading runs does not need it

    ssp_writer.write(scenario, folder / SYSTEM)


def parts(folder: Path) -> list[Path]:
    """The files with some of the rows of a run, in the order of their rows."""
    return sorted((folder / ROWS).glob(PART))


@dataclass(frozen=True)
class KeptRun:
    """A run folder, or a recording on its own."""

    where: str
    """The path as it was requested."""
    folder: Path | None
    """None for a recording on its own."""
    recording: Path | None
    """None where there is no recording."""

    @property
    def name(self) -> str:
        """What the run is called."""
        return (self.folder or Path(self.where)).resolve().name

    @cached_property
    def scenario(self) -> Scenario:
        """The system and the experiment, from `system.ssp`.

        Raises:
            RequestError: There is no such file, or it cannot be read.
        """
        if self.folder is None:
            raise refuse(self.where, "a recording on its own", "a run folder", "Its system.ssp says what was recorded.")
        from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415 - opening a whole recording does not need it

        return ssp_reader.read(self.folder / SYSTEM)

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """The content of `summary.json`, as far as it is sound; empty for a run that was cut short."""
        from orchestrator.results.kept_summary import kept_summary  # noqa: PLC0415 - as above

        return kept_summary((self.folder or Path()) / SUMMARY)

    @property
    def rows(self) -> Path | None:
        """What `pandas.read_parquet` reads the rows from: `signals.parquet`, or the parts of one that was cut short."""
        if self.folder is None:
            return None
        if (self.folder / SIGNALS).is_file():
            return self.folder / SIGNALS
        return self.folder / ROWS if parts(self.folder) else None


def find(request: Path) -> KeptRun | Problem:
    """The run at a path.

    Args:
        request: A run folder, or a recording.

    Returns:
        The run, or what is wrong with the path.
    """
    where = str(request)
    if is_folder(request):
        return _in_folder(request)
    if not is_file(request):
        return Problem(where, "no such file or folder", VALID_RUN, _REMEDY)
    if not _begins_as_recording(request):
        return Problem(where, "a file that is no recording", VALID_RUN, _REMEDY)
    return KeptRun(where, request.parent if is_run(request.parent) else None, request)


def _in_folder(folder: Path) -> KeptRun | Problem:
    path = folder / RECORDING
    recording = path if path.is_file() else None
    run = KeptRun(str(folder), folder if is_run(folder) else None, recording)
    if recording is None and run.rows is None:
        what = f"a run without {RECORDING} and {SIGNALS}" if run.folder else f"a folder without {RECORDING}"
        return Problem(run.where, what, VALID_RUN, "Run it again." if run.folder else _REMEDY)
    return run


def _begins_as_recording(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(3) == b"RRF"
