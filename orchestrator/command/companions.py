"""The processes beside the one that steps a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from orchestrator.command.supervisor import Lifeline

if TYPE_CHECKING:  # the start of the command does not wait for it
    from orchestrator.recording.process import RecordingProcess


@dataclass(frozen=True)
class Companions:
    """What a run has beside it."""

    recorder: RecordingProcess | None
    """Records the run; None for commands that have nothing to record."""
    lifeline: Lifeline
    """Leads to the process that outlives the run."""
