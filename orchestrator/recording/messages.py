"""What the process that steps and the one that records say to each other, and who records a run.

Messages are pickled, one after the other: what to record, then batches of rows, then what is known in the end.
"""

from __future__ import annotations

import pickle
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Protocol

if TYPE_CHECKING:  # who starts the process does not wait for what it imports
    from orchestrator.stepping.master import Simulation
    from orchestrator.stepping.rows import Batch, Element


@dataclass(frozen=True)
class RecordingRequest:
    """What to record, and where to: a file, or the viewer at a URL."""

    folder: Path
    """The run folder with its `system.ssp`"""
    sink: Path | str
    elements: list[list[Element]]
    """What each group of rows holds"""
    about: dict[str, str]
    """The run's provenance"""
    recording_id: str = field(default_factory=lambda: uuid.uuid4().hex)


@dataclass(frozen=True)
class NewRows:
    """Rows that are new; the last ones come with what is known of the run in the end."""

    batches: list[Batch]
    about: dict[str, str] | None = None


class Recorder(Protocol):
    """Who writes the rows of a run to a file or a viewer."""

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Record `simulation` from now on, until `end`."""

    def end(self, about: Mapping[str, str]) -> None:
        """There will be no more rows; comes back at once."""

    def wait_until_open(self) -> None:
        """Wait until rows are written as they come."""

    def wait(self) -> str:
        """Wait until everything is written; what went wrong, in a line, or nothing."""
        ...


def send(stream: IO[bytes], message: object) -> None:
    """A message is bytes within a pickle, so that who receives it need not understand it."""
    pickle.dump(pickle.dumps(message, pickle.HIGHEST_PROTOCOL), stream, pickle.HIGHEST_PROTOCOL)
    stream.flush()
