"""Pictures of a recording as the real viewer shows it, taken without a screen.

This needs a Vulkan driver, for which a software driver is sufficient (Debian: mesa-vulkan-drivers, libvulkan1).
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from components.interfaces.problem import RequestError, refuse
from fmus.toolchain.scratch import scratch_folder
from orchestrator.viewing.rerun_program import address, free_port, serve

PICTURE: Final = "a file .png in a folder that exists"
"""What a request for a picture may name, as messages put it."""
_ENDS_WITHIN: Final = 10.0
"""[s] The time within which the viewer must end after a request, before it is killed."""
_SIZE: Final = re.compile(r"([2-9]\d\d|[1-9]\d{3})x([2-9]\d\d|[1-9]\d{3})")
_NOTICE: Final = 6.0
"""[s] The time until the viewer has removed the notice that it opens with."""


@dataclass(frozen=True)
class Look:
    """How the viewer looks in a picture.

    Raises:
        RequestError: The size has another form.
    """

    size: str | None = None
    """The size of the window, `WIDTHxHEIGHT` in pixels; the viewer's own if not given."""
    tab: str | None = None
    """The tab that is open, by the beginning of its name; the first if not given."""

    def __post_init__(self) -> None:
        if self.size is not None and not _SIZE.fullmatch(self.size):
            raise refuse(
                f"--size {self.size}", "text of another form", "WIDTHxHEIGHT, 200 to 9999 each", "Try 1280x800."
            )


def photograph(
    source: Path | str, times: Sequence[float | None], *, settle: float = 0.0, look: Look | None = None
) -> list[bytes]:
    """Take pictures of a recording, or of a page of a catalog.

    Args:
        source: The file, or the URL of the page.
        times: Times [s] on the timeline `sim_time`; None is where the viewer opens.
        settle: Pause [s] before the first picture; the viewer opens with a notice in its upper right corner, which it
            removes after a few seconds.
        look: The size of the window, and the tab that is open; the viewer's own if not given.

    Returns:
        The content of one PNG file for each of the `times`.

    Raises:
        RequestError: There is no viewer or no graphics driver, or the recording has nothing to show, or not at a time.
    """
    from orchestrator.recording.viewer_client import screenshots  # noqa: PLC0415 - Rerun is slow to import

    look = look or Look()
    try:
        with headless_viewer(look.size) as (url, lives):
            return list(screenshots(url, source, times, settle, lives, look.tab))
    except RequestError:
        raise
    except ValueError as error:
        raise refuse(
            Path(source).name, str(error), "a recording of a run", "" if look.tab else "Run it again."
        ) from error
    except ConnectionError as error:
        remedy = "Debian: apt-get install mesa-vulkan-drivers libvulkan1"
        raise refuse(
            "Rerun viewer", f"no picture ({error})", "a graphics driver, if only in software", remedy
        ) from error


def write_pictures(source: Path | str, picture: Path, times: Sequence[float], look: Look | None = None) -> list[Path]:
    """Write pictures of a recording, or of a page of a catalog.

    Args:
        source: The file, or the URL of the page.
        picture: The PNG file; of several pictures each has its time in its name.
        times: Times [s] on the timeline `sim_time`; one picture where the viewer opens if there are none.
        look: The size of the window, and the tab that is open; the viewer's own if not given.

    Returns:
        The files that were written.

    Raises:
        RequestError: No picture can be taken, or a file cannot be written.
    """
    names = [picture if len(times) < 2 else picture.with_stem(f"{picture.stem}_{t:g}s") for t in times or [0]]  # noqa: PLR2004
    for path, content in zip(names, photograph(source, list(times) or [None], settle=_NOTICE, look=look), strict=True):
        try:
            path.write_bytes(content)
        except OSError as error:
            found = f"a file that cannot be written ({error.strerror})"
            raise refuse(f"--picture {path}", found, PICTURE, "Choose another place.") from error
    return names


@contextmanager
def headless_viewer(size: str | None = None) -> Generator[tuple[str, Callable[[], bool]]]:
    """Run the viewer without a window, on this machine only.

    Args:
        size: The size of the window, `WIDTHxHEIGHT`; the viewer's own if not given.

    Yields:
        The URL at which it listens, and what says whether it still runs.
    """
    port = free_port(0)
    with scratch_folder("viewer") as scratch:
        # The viewer does not remove its temporary files when it is terminated; they stay in a folder of their own.
        how = ["--headless", "--hide-welcome-screen", *(["--window-size", size] if size else [])]
        process = serve(port, how, environment={**os.environ, "TMPDIR": scratch})
        try:
            yield address(port), lambda: process.poll() is None
        finally:
            process.terminate()
            try:
                process.wait(_ENDS_WITHIN)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
