"""The processes beside the one that steps a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from orchestrator.command.supervisor import Lifeline

if TYPE_CHECKING:  # the start of the command does not wait for it
    from orchestrator.execution import Execution
    from orchestrator.recording.process import RecordingProcess
    from orchestrator.viewing.live import LiveStream


@dataclass(frozen=True)
class Companions:
    """What a run has beside it."""

    recorder: RecordingProcess | None
    """Records the run; None for commands that have nothing to record."""
    lifeline: Lifeline
    """Leads to the process that outlives the run."""

    def execution(self, live: LiveStream | None, realtime: float | None) -> Execution:
        """How a run is executed beside them."""
        from orchestrator.execution import Execution  # noqa: PLC0415
        from orchestrator.recording.recording import Afterwards  # noqa: PLC0415 - slow to import

        recorder, told = self.recorder or Afterwards(), self.lifeline
        return Execution(recorder, live, realtime, begun=told.began, ending=told.ends)
