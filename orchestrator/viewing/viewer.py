"""Opens runs in the Rerun viewer that comes with rerun-sdk; its server listens on this machine only."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import Final

from components.interfaces.problem import Problem, raise_if_any, refuse
from fmus.toolchain.asked_library import readers_kept
from fmus.toolchain.scratch import scratch_folder
from orchestrator.results import run_folder
from orchestrator.results.run_folder import KeptRun
from orchestrator.viewing import repair
from orchestrator.viewing.photograph import PICTURE, Look, write_pictures
from orchestrator.viewing.rerun_program import LOOPBACK, end_with_parent, executable, has_display, tell_of_usage_data

_PAGE: Final = re.compile(r"http://[\w.:]+/?\?url=\S+")
"""The address of the page in the browser, which the viewer prints."""
_REMEDY: Final = "In a browser: macrostep show --web RUN. As a file: macrostep show --picture FILE.png RUN"


def show(  # noqa: PLR0913 - one parameter per option of the command
    requests: Sequence[Path],
    differences: Sequence[str],
    tell: Callable[[str], None],
    *,
    web: bool = False,
    picture: Path | None = None,
    times: Sequence[float] = (),
    look: Look | None = None,
) -> None:
    """Open one run, or several in the same views, and come back when the viewer is closed.

    Args:
        requests: Run folders or recordings.
        differences: Of several runs, the signal elements whose differences from the first are shown.
        tell: Called with each line of text for the user.
        web: Whether to open a browser instead of a window.
        picture: A PNG file that is written instead of opening the viewer.
        times: Times [s] of the run at which pictures are taken; one file for each.
        look: The size of the window in the pictures, and the tab that is open.

    Raises:
        RequestError: A request cannot be met; the error has the problems of all requests.
    """
    runs = _found(requests, differences)
    check(picture, times, look, web=web)
    with scratch_folder("show") as scratch:
        path = recording(runs, differences, Path(scratch), tell)
        present(path, tell, web=web, picture=picture, times=times, look=look)


def check(picture: Path | None, times: Sequence[float], look: Look | None, *, web: bool) -> None:
    """Check how something is to be shown, before it is read.

    Args:
        picture: As `show` takes it.
        times: As above.
        look: As above.
        web: As above.

    Raises:
        RequestError: It cannot be shown so, or not on this machine.
    """
    if times and picture is None:
        raise refuse("--at", "no picture to be taken", "--at together with --picture FILE.png")
    if look is not None and picture is None:
        raise refuse("--size, --tab", "no picture to be taken", "together with --picture FILE.png")
    problems = [Problem("--at", f"{time:g}", "a finite number of seconds") for time in times if not isfinite(time)]
    if picture is not None and picture.suffix != ".png":
        problems.append(Problem(f"--picture {picture}", f"`{picture.name}`", PICTURE))
    elif picture is not None and not picture.parent.is_dir():
        problems.append(Problem(f"--picture {picture}", f"no folder `{picture.parent}`", PICTURE))
    raise_if_any(problems)
    if not web and picture is None and not has_display():
        raise refuse("Rerun viewer", "no display", "a machine with a display", _REMEDY)


def present(  # noqa: PLR0913 - as `show`
    source: Path | str,
    tell: Callable[[str], None],
    *,
    web: bool = False,
    picture: Path | None = None,
    times: Sequence[float] = (),
    look: Look | None = None,
) -> None:
    """Show a recording, or a page of a catalog at a URL, and come back when the viewer is closed.

    Args:
        source: The file, or the URL.
        tell: As `show` takes it.
        web: As above.
        picture: As above.
        times: As above.
        look: As above.

    Raises:
        RequestError: The viewer ends with an error, or no picture can be taken.
    """
    tell_of_usage_data(tell)
    if picture is None:
        open_viewer(source, tell, web=web)
        return
    for written in write_pictures(source, picture, times, look):
        tell(str(written))


def _found(requests: Sequence[Path], differences: Sequence[str]) -> list[KeptRun]:
    results = [run_folder.find(request) for request in requests]
    problems = [item for item in results if isinstance(item, Problem)]
    places = [request.resolve() for request in requests]
    if len(set(places)) < len(places):
        problems.append(Problem("show", "the same run twice", "different runs"))
    if differences and len(requests) == 1:
        problems.append(Problem("--difference", "a single run", "two runs or more", "macrostep show RUN OTHER"))
    runs = [item for item in results if isinstance(item, KeptRun)]
    if len(requests) > 1:
        valid, remedy = "run folders to compare", "Their system.ssp says what was recorded."
        problems += [Problem(r.where, "a recording on its own", valid, remedy) for r in runs if r.folder is None]
    raise_if_any(problems)
    return runs


def recording(runs: Sequence[KeptRun], differences: Sequence[str], scratch: Path, tell: Callable[[str], None]) -> Path:
    """The file to open.

    Args:
        runs: One run, whose own recording is opened where it is whole, or several to compare.
        differences: Of several runs, the signal elements whose differences from the first are shown.
        scratch: A folder for a recording that is not a run's own.
        tell: Called with a line that says where such a recording comes from.

    Raises:
        RequestError: A run cannot be read, or a signal was not recorded.
    """
    if len(runs) == 1:
        return repair.whole_recording(runs[0], scratch, tell)
    from orchestrator.viewing.comparison import compare  # noqa: PLC0415 - Rerun is slow to import

    with readers_kept():
        tables = [repair.rows(run, scratch, tell) for run in runs]
    for run in runs:
        repair.tell_of_summary(run, tell)
    path = scratch / "comparison.rrd"
    compare(runs, tables, differences, path)
    return path


def arguments(source: Path | str, *, web: bool) -> list[str]:
    """The options that the viewer's program is started with, to open a window or (`web`) a page in the browser."""
    chosen = ["--web-viewer", "--web-viewer-port", "0"] if web else ["--hide-welcome-screen"]
    return ["--bind", LOOPBACK, "--port", "auto", *chosen, str(source)]


def open_viewer(source: Path | str, tell: Callable[[str], None], *, web: bool) -> None:
    """Open the viewer and wait until it is closed.

    Args:
        source: A recording, or the URL of a page of a catalog.
        tell: Called with the address of the page in the browser.
        web: Whether to open a browser instead of a window.

    Raises:
        RequestError: The viewer ends with an error.
    """
    lines: list[str] = []
    # A server without a window would run for ever if this process was killed without stopping it.
    prepared = end_with_parent() if web else None
    command = [executable(), *arguments(source, web=web)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=prepared) as process:  # noqa: S603, PLW1509 - our own program; one call into libc
        try:
            for line in process.stderr or ():
                lines.append(line.strip())
                if web and (page := _PAGE.search(line)):
                    tell(f"in the browser at {page[0]}, until Ctrl-C")
            code = process.wait()
        except KeyboardInterrupt:
            process.terminate()
            return
    if code != 0:
        reason = next((line.removeprefix("Error: ") for line in reversed(lines) if line.startswith("Error")), "")
        found = f"exit code {code}" + (f" ({reason})" if reason else "")
        raise refuse("Rerun viewer", found, "a machine with a display and a graphics driver", _REMEDY)
