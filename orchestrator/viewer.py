"""Opening a run in the Rerun viewer that comes with rerun-sdk."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from components.interfaces.problem import refuse


def open_viewer(run: Path) -> None:
    """Open a run folder's recording, or an `.rrd` file, and come back when the viewer is closed."""
    recording = run / "recording.rrd" if run.is_dir() else run
    if not recording.is_file():
        raise refuse(str(run), "no recording.rrd", "a run folder, or an .rrd file", "Make one: macrostep run static")
    code = subprocess.call([sys.executable, "-m", "rerun", str(recording)])  # noqa: S603 - our own interpreter
    if code != 0:
        raise refuse("Rerun viewer", f"exit code {code}", "a machine with a display and a graphics driver")
