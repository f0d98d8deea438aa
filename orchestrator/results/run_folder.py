"""The run folder: the names of its files, the start of a new one, and what remains of a run that was cut short.

A run folder holds `SIGNALS` (all signals, with units of measurement in the metadata), `RECORDING` (Rerun), `SUMMARY`
(metrics, verdicts, versions, hashes, parameters), `SYSTEM` and pictures in `FIGURES`. The summary is written last: a
folder without it belongs to a run that was cut short.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

from components.interfaces.problem import Problem, refuse

if TYPE_CHECKING:  # opening a whole recording does not need it, and a person waits
    from orchestrator.system.experiment import Scenario

RECORDING: Final = "recording.rrd"
SIGNALS: Final = "signals.parquet"
SYSTEM: Final = "system.ssp"
SUMMARY: Final = "summary.json"
FIGURES: Final = "figures"
"""A folder of PNG files."""

VALID_RUN: Final = "a run folder, or an .rrd file"
"""What a request for a run may name, as messages put it."""
_KEYS: Final = {"scenario", "title", "status", "units", "versions"}
"""The entries of every summary; a file without them is not one."""
_REMEDY: Final = "Make a run: macrostep run static"


def new_folder(scenario: str, out: Path | None) -> Path:
    """Make the folder for a run.

    Args:
        scenario: The scenario's name, which names the folder where nothing else does.
        out: The folder; the next free ``runs/NAME-1``, ``-2``, ... if not given.

    Returns:
        The folder, with nothing in it but an empty folder for figures. A former run is replaced.

    Raises:
        RequestError: Something other than a run is there, or the place cannot be written to.
    """
    return emptied_folder(scenario, out, "run", is_run, inside=FIGURES)


def emptied_folder(name: str, out: Path | None, what: str, is_former: Callable[[Path], bool], inside: str = "") -> Path:
    """Make a folder for results, in the place of former results of the same kind.

    Args:
        name: What names the folder where `out` does not.
        out: The folder; the next free ``runs/NAME-1``, ``-2``, ... if not given.
        what: What the results are, for messages.
        is_former: Tells whether a folder holds former results, which are replaced; anything else that is there stays.
        inside: A folder that is made in it.

    Returns:
        The folder, with nothing else in it.

    Raises:
        RequestError: Something else is there, or the place cannot be written to.
    """
    folder = out
    if folder is None:
        taken = {int(p.name.rpartition("-")[2]) for p in Path("runs").glob(f"{name}-[0-9]*") if _is_numbered(p)}
        folder = Path("runs") / f"{name}-{max(taken, default=0) + 1}"
    where, valid = str(folder), f"a folder that is new, empty or a former {what}, in a place that can be written to"
    if folder.is_file():
        raise refuse(where, "a file", valid, "Choose another folder with --out.")
    try:
        if folder.is_dir() and any(folder.iterdir()):
            if not is_former(folder):
                raise refuse(where, "a folder with other things in it", valid, "Choose another folder with --out.")
            shutil.rmtree(folder)
        (folder / inside).mkdir(parents=True, exist_ok=True)
        (folder / ".writable").touch()
        (folder / ".writable").unlink()
    except OSError as error:
        raise refuse(
            where, f"a folder that cannot be written to ({error.strerror})", valid, "Choose another one."
        ) from error
    return folder


def is_run(folder: Path) -> bool:
    """Whether a folder holds a run, whole or cut short."""
    return (folder / SYSTEM).is_file()


def write_system(scenario: Scenario, folder: Path) -> None:
    """Write the system and the experiment of a run before its first step, so that even a run that dies can be repeated.

    Args:
        scenario: What is run.
        folder: The run folder.
    """
    from orchestrator.ssp import writer as ssp_writer  # noqa: PLC0415 - reading runs does not need it

    ssp_writer.write(scenario, folder / SYSTEM)


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
        """The content of `summary.json`; empty for a run that was cut short, and for a file that is something else."""
        try:
            content = json.loads(((self.folder or Path()) / SUMMARY).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return cast(dict[str, Any], content) if isinstance(content, dict) and content.keys() >= _KEYS else {}

    @property
    def has_rows(self) -> bool:
        """Whether `signals.parquet` is there."""
        return self.folder is not None and (self.folder / SIGNALS).is_file()


def find(request: Path) -> KeptRun | Problem:
    """The run at a path.

    Args:
        request: A run folder, or a recording.

    Returns:
        The run, or what is wrong with the path.
    """
    where = str(request)
    if request.is_dir():
        return _in_folder(request)
    if not request.exists():
        return Problem(where, "no such file or folder", VALID_RUN, _REMEDY)
    if not _begins_as_recording(request):
        return Problem(where, "a file that is no recording", VALID_RUN, _REMEDY)
    return KeptRun(where, request.parent if is_run(request.parent) else None, request)


def _in_folder(folder: Path) -> KeptRun | Problem:
    path = folder / RECORDING
    recording = path if path.is_file() else None
    run = KeptRun(str(folder), folder if is_run(folder) else None, recording)
    if recording is None and not run.has_rows:
        what = f"a run without {RECORDING} and {SIGNALS}" if run.folder else f"a folder without {RECORDING}"
        return Problem(run.where, what, VALID_RUN, "Run it again." if run.folder else _REMEDY)
    return run


def _is_numbered(path: Path) -> bool:
    return path.name.rpartition("-")[2].isdigit()


def _begins_as_recording(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(3) == b"RRF"
