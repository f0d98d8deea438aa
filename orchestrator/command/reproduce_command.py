"""The command `macrostep reproduce`."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from orchestrator.command.console import err, out, print_notes, working


def reproduce(
    folder: Annotated[
        Path | None, typer.Option("--out", help="Folder of the report; the next free runs/reproduce-N if not given.")
    ] = None,
    varied: Annotated[int, typer.Option(metavar="N", help="Also drive N variations of the scenarios.")] = 0,
    seed: Annotated[int, typer.Option(metavar="S", help="Which variations are drawn.")] = 1,
) -> None:
    """Run every experiment of the paper, and say which of its claims hold."""
    with ExitStack() as writing:
        with working() as progress:
            progress.now("getting ready")
            from orchestrator.reproduction import reproduce as reproduction  # noqa: PLC0415
            from orchestrator.reproduction.paper import experiments  # noqa: PLC0415
            from orchestrator.reproduction.varied import variations  # noqa: PLC0415

            listed = experiments.load()
            request = variations.request(varied, seed) if varied != 0 else None
            claimed = writing.enter_context(reproduction.new_folder(folder, listed))
        print_notes(claimed.remarks)
        driven = _drive(request) if request is not None else None
        with working() as progress:
            report = reproduction.reproduce(listed, claimed.path, progress, driven)
        for verdict in report.verdicts:
            out.print(Text.assemble((verdict.claim, "bold"), f" {verdict.words}: ", (verdict.outcome, "bold")))
        out.print(f"{claimed.named}/  report.html  report.md  report.json  runs/  figures/")


def _drive(request: Any) -> Any:
    """Drive the variations, with a progress bar."""
    from rich.progress import Progress  # noqa: PLC0415

    from orchestrator.reproduction.varied import varied_set  # noqa: PLC0415

    with working() as progress:
        varied_set.build(request, progress)
    with Progress(console=err) as bar:
        cases = bar.add_task("driving variations", total=len(request.cases))
        return varied_set.run(request, lambda: bar.advance(cases))
