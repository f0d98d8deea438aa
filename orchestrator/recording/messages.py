"""The messages from the process that steps to the process that records, and the interface of a recorder.

Messages are pickled, one after the other: what to record, then batches of rows, the last of them with the provenance of
the run as it is known at the end.
"""

from __future__ import annotations

import pickle
import re
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Protocol

if TYPE_CHECKING:  # the process that records starts faster without these imports
    from orchestrator.stepping.master import Simulation
    from orchestrator.stepping.row_batch import RowBatch
    from orchestrator.stepping.signal_table import RecordedElement


def new_identifier(name: str | None) -> str:
    """An identifier that no other recording has; with a name in front of it, because a catalog shows nothing else."""
    unique = uuid.uuid4().hex
    return unique if name is None else f"{re.sub('[^a-zA-Z0-9]+', '-', name)}-{unique[:8]}"


@dataclass(frozen=True)
class RecordingRequest:
    """What to record, and where."""

    folder: Path
    """The run folder, which holds `system.ssp`."""
    sink: Path | str
    """A file, or the URL of a viewer."""
    elements: list[list[RecordedElement]]
    """The signal elements in each group of rows."""
    about: dict[str, str]
    """The run's provenance as it is known at the start."""
    recording_id: str = field(default_factory=lambda: new_identifier(None))
    """The identifier of the recording; the streams of one run to a file and to a viewer share it."""
    followed: bool = False
    """Whether somebody watches while it is recorded."""
    name: str | None = None
    """What it is called in the viewer; as the scenario, if not given."""


@dataclass(frozen=True)
class NewRows:
    """Rows that were completed since the last message."""

    batches: list[RowBatch]
    about: dict[str, str] | None = None
    """In the last message, the run's provenance as it is known at the end."""


class Recorder(Protocol):
    """Writes the rows of a run to a file or a viewer."""

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Record a simulation from now on, until `end`.

        Args:
            request: What to record, and where.
            simulation: The simulation, which may step while it is recorded.
        """

    def end(self, about: Mapping[str, str]) -> None:
        """Tell the recorder that there are no more rows; returns at once.

        Args:
            about: The run's provenance as it is known at the end.
        """

    def wait_until_open(self) -> None:
        """Wait until rows are written as they come."""

    def wait(self) -> str:
        """Wait until everything is written.

        Returns:
            What went wrong, in a line; empty if nothing did.
        """
        ...


def send(stream: IO[bytes], message: object) -> None:
    """Send a message.

    Args:
        stream: A pipe to the other process.
        message: Any object. It is pickled to bytes, which are pickled again, so that a thread can receive it without
            importing what it consists of.
    """
    pickle.dump(pickle.dumps(message, pickle.HIGHEST_PROTOCOL), stream, pickle.HIGHEST_PROTOCOL)
    stream.flush()
