"""Pictures of a recording as the real viewer shows it, without a screen.

Needs a Vulkan driver, also one in software (Debian: mesa-vulkan-drivers, libvulkan1).
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path

from components.interfaces.problem import refuse
from orchestrator.viewing.rerun_program import address, free_port, serve

_ENDS_WITHIN, _GREETS = 10.0, 6.0
"""[s]"""


PICTURE = "a file .png in a folder that exists"


def photograph(recording: Path, times: Sequence[float | None], *, settle: float = 0.0) -> list[bytes]:
    """One PNG for each of the `times` [s] on the timeline `sim_time`; None is where the viewer opens.

    The viewer greets with a notice in its upper right corner, which goes after a few seconds: `settle` [s].

    Raises `RequestError` where there is no viewer or no graphics driver, and for a recording without anything to show.
    """
    from orchestrator.recording.viewer_client import screenshots  # noqa: PLC0415 - Rerun is slow to import

    try:
        with headless_viewer() as url:
            return list(screenshots(url, recording, times, settle))
    except ValueError as error:
        raise refuse(recording.name, str(error), "a recording of a run", "Run it again.") from error
    except ConnectionError as error:
        remedy = "Debian: apt-get install mesa-vulkan-drivers libvulkan1"
        raise refuse(
            "Rerun viewer", f"no picture ({error})", "a graphics driver, if only in software", remedy
        ) from error


def write_pictures(recording: Path, picture: Path, times: Sequence[float]) -> list[Path]:
    """Write `picture`, or one file per time with the time in its name. Raises `RequestError`."""
    names = [picture if len(times) < 2 else picture.with_stem(f"{picture.stem}_{t:g}s") for t in times or [0]]  # noqa: PLR2004
    for path, content in zip(names, photograph(recording, list(times) or [None], settle=_GREETS), strict=True):
        try:
            path.write_bytes(content)
        except OSError as error:
            found = f"a file that cannot be written ({error.strerror})"
            raise refuse(f"--picture {path}", found, PICTURE, "Choose another place.") from error
    return names


@contextmanager
def headless_viewer() -> Generator[str]:
    """The viewer without a window, on this machine only; the URL to talk to it."""
    port = free_port(0)
    with tempfile.TemporaryDirectory(prefix="macrostep_viewer_", ignore_cleanup_errors=True) as scratch:
        # it leaves its files behind when it is ended
        how = ["--headless", "--hide-welcome-screen"]
        process = serve(port, how, environment={**os.environ, "TMPDIR": scratch})
        try:
            yield address(port)
        finally:
            process.terminate()
            try:
                process.wait(_ENDS_WITHIN)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
