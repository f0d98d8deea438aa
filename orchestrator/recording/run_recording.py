"""The recording of a run: written while it lasts, once more where that went wrong, and given up for the rows."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from orchestrator.recording.messages import Recorder, RecordingRequest
from orchestrator.recording.process import LEAST_ROOM, RecordingProcess, recorded_by_process
from orchestrator.results.live_folder import LiveFolder
from orchestrator.results.run_folder import RECORDING

if TYPE_CHECKING:  # slow to import, and only the name is needed
    from orchestrator.stepping.master import Simulation


class RunRecording:
    """The recording of a run, at its end.

    Args:
        recorder: Has recorded the run so far.
        request: What it was told.
        simulation: The simulation.
        folder: The run folder, which may have been moved.
    """

    def __init__(
        self, recorder: Recorder, request: RecordingRequest, simulation: Simulation, folder: LiveFolder
    ) -> None:
        self._recorder, self._request, self._simulation, self._folder = recorder, request, simulation, folder
        self._about: Mapping[str, str] = {}
        self._given_up = ""

    def end(self, about: Mapping[str, str]) -> None:
        """Tell the recorder that there are no more rows; returns at once."""
        self._about = {**self._request.about, **about}
        self._recorder.end(self._about)

    def give_up(self, reason: str) -> None:
        """Remove the recording, because the rows need the room, from which another one can be made."""
        self._recorder.end({})
        self._recorder.wait()
        self._folder.make_room()
        self._given_up = reason

    def wait(self) -> list[str]:
        """Wait until the recording is written; return notes on what went wrong."""
        problem = self._given_up or self._recorder.wait()
        file = self._folder.path / RECORDING
        removed = not problem and not file.is_file()
        if removed or (not self._given_up and problem and isinstance(self._recorder, RecordingProcess)):
            # That process has died, or somebody has removed or moved what it wrote, but this one still has all rows.
            self._folder.make_room()
            problem = self._again(file)
        if problem:
            self._folder.make_room()
            return [f"{RECORDING} is left out: {problem}; macrostep show makes one from the rows"]
        return [f"{RECORDING} was removed during the run, and has been written again"] if removed else []

    def _again(self, file: Path) -> str:
        """Record the run once more; return what went wrong, in a line, or nothing."""
        if shutil.disk_usage(file.parent).free < LEAST_ROOM:
            return "there is no room on the disk"
        again = replace(self._request, folder=file.parent, sink=file)
        if not (problem := recorded_by_process(again, self._simulation, self._about)):
            return ""
        from orchestrator.recording.recording import Afterwards  # noqa: PLC0415 - slow to import

        # Another process does not know what was added to this one, such as another socket.
        here = Afterwards()
        here.begin(again, self._simulation)
        here.end(self._about)
        return problem if here.wait() else ""
