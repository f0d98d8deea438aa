"""The figures of a run folder, drawn by a process of their own that gets ready while the run is prepared.

Importing matplotlib and drawing take a third of the time a person waits for a short run; the second core has nothing
else to do. The process is given the run folder on its standard input; without one it just ends.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Self


class FigureProcess:
    """A process that is ready to draw; use it in a `with` statement."""

    def __enter__(self) -> Self:
        command = [sys.executable, "-m", "orchestrator.drawing"]
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process.returncode is None:
            self._process.communicate()

    def start(self, folder: Path) -> None:
        """Begin to draw the figures of the run in `folder`."""
        if self._process.stdin is not None:
            self._process.stdin.write(f"{folder.resolve()}\n")
            self._process.stdin.flush()

    def wait(self) -> str:
        """Wait until they are drawn; what went wrong, as text, or nothing."""
        _, said = self._process.communicate()
        return said.strip() if self._process.returncode else ""


def draw_folder(folder: Path) -> None:
    """Draw the figures of the run in `folder`, from what it holds."""
    from orchestrator import figures, log, parquet, ssp_reader  # noqa: PLC0415 - who starts the process does not wait

    scenario = ssp_reader.read(folder / "system.ssp")
    whole = {"time", *log.without_gaps(scenario.system, scenario.record)}
    rows = {name: v for name, v in parquet.read_columns(folder / "signals.parquet").items() if name in whole}
    if scenario.scene is not None and len(rows["time"]):
        figures.draw(rows, scenario.system, scenario.scene, folder / "figures")


if __name__ == "__main__":
    importlib.import_module("orchestrator.figures")  # get ready before there is work
    importlib.import_module("orchestrator.parquet")
    importlib.import_module("orchestrator.ssp_reader")
    if request := sys.stdin.readline().strip():
        draw_folder(Path(request))
