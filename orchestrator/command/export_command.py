"""The command `macrostep export`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

import typer

from orchestrator.command.console import out, print_notes, working
from orchestrator.command.shared_options import Fmi, ScenarioRequest
from orchestrator.scenario.options import Options

EXPORT_OPTIONS: Final = ("settings", "fmi", "stop_time", "step", "algorithm", "lenient", "interface")
"""The shared options that the subcommand takes."""


def export(
    scenario: ScenarioRequest,
    ssp: Annotated[Path | None, typer.Option(metavar="FILE.ssp", help="Write the system as an SSP file.")] = None,
    container: Annotated[Path | None, typer.Option(metavar="FILE.fmu", help="Write the system as one FMU.")] = None,
    *,
    fmi: Annotated[
        Fmi | None, typer.Option(help="Version of FMI; 2 if not given, which every tool reads, or that of a run.")
    ] = None,
    options: Options,
) -> None:
    """Write a scenario's system for other tools, without running it.

    The container steps in the order of the algorithm: sequential (no hidden delay) or jacobi.
    """
    with working() as progress:
        progress.now("getting ready")
        from orchestrator.exchange.export import Targets, default_mode, write  # noqa: PLC0415

        mode = default_mode(scenario) if fmi is None else fmi.version
        written = write(scenario, replace(options, mode=mode), Targets(ssp, container), progress)
    print_notes(written.remarks)
    for line in written.lines:
        out.print(line)
