"""Opening runs in the Rerun viewer that comes with rerun-sdk; its server listens on this machine only."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path

from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.results import run_folder
from orchestrator.results.run_folder import KeptRun
from orchestrator.viewing import repair
from orchestrator.viewing.photograph import PICTURE, write_pictures
from orchestrator.viewing.rerun_program import LOOPBACK, end_with_parent, executable, has_display


def show(  # noqa: PLR0913 - one parameter per option of the command
    requests: Sequence[Path],
    differences: Sequence[str],
    tell: Callable[[str], None],
    *,
    web: bool = False,
    picture: Path | None = None,
    times: Sequence[float] = (),
) -> None:
    """Open one run, or several in one picture, and come back when the viewer is closed.

    With `picture` write PNG files of it instead, at the `times` [s] of the run. Raises `RequestError`.
    """
    runs = _found(requests, differences)
    if times and picture is None:
        raise refuse("--at", "no picture to be taken", "--at together with --picture FILE.png")
    problems = [Problem("--at", f"{time:g}", "a finite number of seconds") for time in times if not isfinite(time)]
    if picture is not None and picture.suffix != ".png":
        problems.append(Problem(f"--picture {picture}", f"`{picture.name}`", PICTURE))
    elif picture is not None and not picture.parent.is_dir():
        problems.append(Problem(f"--picture {picture}", f"no folder `{picture.parent}`", PICTURE))
    raise_if_any(problems)
    if not web and picture is None and not has_display():
        raise refuse("Rerun viewer", "no display", "a machine with a display", _REMEDY)
    with tempfile.TemporaryDirectory(prefix="macrostep_show_") as scratch:
        path = recording(runs, differences, Path(scratch), tell)
        if picture is None:
            open_viewer(path, tell, web=web)
            return
        for made in write_pictures(path, picture, times):
            tell(str(made))


def _found(requests: Sequence[Path], differences: Sequence[str]) -> list[KeptRun]:
    found = [run_folder.find(request) for request in requests]
    problems = [item for item in found if isinstance(item, Problem)]
    places = [request.resolve() for request in requests]
    if len(set(places)) < len(places):
        problems.append(Problem("show", "the same run twice", "different runs"))
    if differences and len(requests) == 1:
        problems.append(Problem("--difference", "a single run", "two runs or more", "macrostep show RUN OTHER"))
    runs = [item for item in found if isinstance(item, KeptRun)]
    if len(requests) > 1:
        valid, remedy = "run folders to compare", "Their system.ssp says what was recorded."
        problems += [Problem(r.where, "a recording on its own", valid, remedy) for r in runs if r.folder is None]
    raise_if_any(problems)
    return runs


def recording(runs: Sequence[KeptRun], differences: Sequence[str], scratch: Path, tell: Callable[[str], None]) -> Path:
    """The file to open: a run's own recording where it is whole, else one in `scratch`. Raises `RequestError`."""
    if len(runs) == 1:
        return repair.whole_recording(runs[0], scratch, tell)
    from orchestrator.viewing.comparison import compare  # noqa: PLC0415 - Rerun is slow to import

    tables = [repair.rows(run, scratch, tell) for run in runs]
    path = scratch / "comparison.rrd"
    compare(runs, tables, differences, path)
    return path


def arguments(path: Path, *, web: bool) -> list[str]:
    """The options the viewer's program is started with."""
    chosen = ["--web-viewer", "--web-viewer-port", "0"] if web else ["--hide-welcome-screen"]
    return ["--bind", LOOPBACK, "--port", "auto", *chosen, str(path)]


def open_viewer(path: Path, tell: Callable[[str], None], *, web: bool) -> None:
    """Open a recording in the viewer, or (`web`) in the browser, until it is closed. Raises `RequestError`."""
    said: list[str] = []
    # a server without a window would be there for ever after its end was missed
    prepared = end_with_parent() if web else None
    command = [executable(), *arguments(path, web=web)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=prepared) as process:  # noqa: S603, PLW1509 - our own program; one call into libc
        try:
            for line in process.stderr or ():
                said.append(line.strip())
                if web and (page := _PAGE.search(line)):
                    tell(f"in the browser at {page[0]}, until Ctrl-C")
            code = process.wait()
        except KeyboardInterrupt:
            process.terminate()
            return
    if code != 0:
        reason = next((line.removeprefix("Error: ") for line in reversed(said) if line.startswith("Error")), "")
        found = f"exit code {code}" + (f" ({reason})" if reason else "")
        raise refuse("Rerun viewer", found, "a machine with a display and a graphics driver", _REMEDY)


_PAGE = re.compile(r"http://[\w.:]+/?\?url=\S+")
_REMEDY = "In a browser: macrostep show --web RUN. As a file: macrostep show --picture FILE.png RUN"
