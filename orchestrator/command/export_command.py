"""The command `macrostep export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.command import options
from orchestrator.command.console import err, out, working
from orchestrator.command.options import Fmi


def export(  # noqa: PLR0913 - one parameter per option of the command
    scenario: options.Request,
    ssp: Annotated[Path | None, typer.Option(metavar="FILE.ssp", help="Write the system as an SSP file.")] = None,
    container: Annotated[Path | None, typer.Option(metavar="FILE.fmu", help="Write the system as one FMU.")] = None,
    plant: options.Plant = None,
    traffic: options.Traffic = None,
    controller: options.Controller = None,
    setting: options.Settings = None,
    fmi: Annotated[Fmi | None, typer.Option(help="Version of FMI; 2 if not given, which every tool reads.")] = None,
    stop_time: options.StopTime = None,
    step: options.Step = None,
    algorithm: options.MasterAlgorithm = None,
    lenient: options.Lenient = False,  # noqa: FBT002
) -> None:
    """Write a scenario's system for other tools, without running it.

    The container steps in the order of the algorithm: sequential (no hidden delay) or jacobi.
    """
    chosen = {"plant": plant, "traffic": traffic, "controller": controller}
    with working() as progress:
        progress("getting ready")
        from fmus.toolchain.version import Version  # noqa: PLC0415
        from orchestrator.exchange.export import Targets, default_mode, write  # noqa: PLC0415
        from orchestrator.scenario.options import Options  # noqa: PLC0415

        options = Options(
            mode=default_mode(scenario) if fmi is None else Version(int(fmi)),
            replacements={socket: name for socket, name in chosen.items() if name is not None},
            settings=setting or [],
            step=step,
            stop_time=stop_time,
            algorithm=algorithm,
            lenient=lenient,
        )
        written = write(scenario, options, Targets(ssp, container), progress)
    for remark in written.remarks:
        err.print(f"note: {remark}", markup=False)
    for line in written.lines:
        out.print(line, markup=False)
