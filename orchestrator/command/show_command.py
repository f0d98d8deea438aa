"""The command `macrostep show`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from components.interfaces.problem import refuse
from orchestrator.command import shell_completion
from orchestrator.command.console import print_message


def show(  # noqa: PLR0913 - one parameter per option of the command
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN...",
            help="Run folders, the folder of a sweep, or an .rrd file.",
            autocompletion=shell_completion.runs,
        ),
    ],
    difference: Annotated[
        list[str] | None,
        typer.Option(help="Signal to draw as its difference from the first run, `plant.state.y`. Repeatable."),
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="In the browser, served on this machine only.")] = False,  # noqa: FBT002
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Write a picture instead; no display is needed.")
    ] = None,
    at: Annotated[list[float] | None, typer.Option(help="Time of the picture [s]. Repeatable.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Size of the picture, such as 1280x800.")] = None,
    tab: Annotated[
        str | None, typer.Option(help="Tab of the picture: run, all, about; of a sweep also metrics, bands.")
    ] = None,
) -> None:
    """Open a run in the Rerun viewer, or several in one picture, a colour each.

    A run that was cut short is opened from a repaired copy. Of a sweep the table of all variants is shown, with links
    to the runs that were kept, and its signals over all variants.
    """
    from orchestrator.results.manifest import MANIFEST_FILE  # noqa: PLC0415
    from orchestrator.viewing import viewer  # noqa: PLC0415
    from orchestrator.viewing.photograph import Look  # noqa: PLC0415

    look = Look(size, tab) if size or tab else None
    opened = partial(viewer.show, runs)
    if any((run / MANIFEST_FILE).is_file() for run in runs):
        from orchestrator.sweeping.sweep_folder import is_sweep  # noqa: PLC0415

        if sweeps := [run for run in runs if is_sweep(run)]:
            from orchestrator.sweeping.sweep_view import show_sweep  # noqa: PLC0415

            if len(runs) > 1:
                raise refuse(str(sweeps[0]), "a sweep beside something else", "runs, or one sweep")
            opened = partial(show_sweep, sweeps[0])
    opened(difference or [], print_message, web=web, picture=picture, times=at or [], look=look)
