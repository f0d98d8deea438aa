"""The command `macrostep`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from orchestrator.drawing import FigureProcess

# The commands import what they need themselves: a person waits for every library that is imported here, and while
# `run` imports its own, the process for the figures does the same on another core.

FAULT, WRONG = 1, 2
"""Exit codes: the run ended in a fault; the request was wrong."""

app = typer.Typer(
    help="Co-simulate an automated vehicle: plant, traffic and controller as FMI components, inspected in Rerun.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
out = Console(soft_wrap=True, highlight=False)
err = Console(stderr=True, soft_wrap=True, highlight=False)


class Fmi(StrEnum):
    """Versions of FMI."""

    TWO = "2"
    THREE = "3"


@contextmanager
def _working() -> Generator[Callable[[str], None]]:
    """A line that says what is going on, on terminals; plain lines elsewhere only for what takes long."""
    with err.status("starting") as status:

        def tell(text: str) -> None:
            status.update(text)
            if text.startswith("built "):
                err.print(text)

        yield tell


@app.command()
def run(  # noqa: PLR0913 - one parameter per option of the command
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A scenario by name, a .toml file, an .ssp file or a run folder.")
    ],
    plant: Annotated[str | None, typer.Option(help="Another plant: a block or FILE.fmu.")] = None,
    traffic: Annotated[str | None, typer.Option(help="Other traffic: a block or FILE.fmu.")] = None,
    controller: Annotated[str | None, typer.Option(help="Another controller: a block or FILE.fmu.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="Change a parameter: `controller.b_3=1e-2`. Repeatable.")
    ] = None,
    fmi: Annotated[Fmi, typer.Option(help="Version of FMI that blocks run as.")] = Fmi.THREE,
    blocks: Annotated[bool, typer.Option("--blocks", help="Run blocks in this process, without a compiler.")] = False,  # noqa: FBT002
    stop_time: Annotated[float | None, typer.Option(help="End of the run [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Macro step [s].")] = None,
    folder: Annotated[
        Path | None, typer.Option("--out", help="Run folder; the next free runs/NAME-N if not given.")
    ] = None,
) -> None:
    """Run a scenario and write its run folder.

    The FMUs it needs are built on the way. Exit code 0: all well; 1: the run ended in a fault, everything up to it is
    in the folder; 2: the request was wrong, nothing was written.
    """
    chosen = {"plant": plant, "traffic": traffic, "controller": controller}
    with _working() as progress, FigureProcess() as drawing:
        from fmus.version import Version  # noqa: PLC0415
        from orchestrator.run import execute, load  # noqa: PLC0415
        from orchestrator.scenario import Options  # noqa: PLC0415

        options = Options(
            mode="blocks" if blocks else Version(int(fmi)),
            replacements={socket: name for socket, name in chosen.items() if name is not None},
            settings=setting or [],
            step=step,
            stop_time=stop_time,
        )
        loaded = load(scenario, options, progress)
        finished = execute(loaded, folder, progress, drawing)
    for remark in loaded.remarks:
        err.print(f"note: {remark}")
    _report(finished.summary, finished.folder)
    if finished.fault is not None:
        err.print(f"macrostep: the run ended in a fault at {finished.fault}", style="red")
        raise typer.Exit(FAULT)


def _report(told: dict[str, Any], folder: Path) -> None:
    """The run in a few lines."""
    experiment, timing = told["experiment"], told["timing"]
    title = f"{told['scenario']}: {experiment['ticks']} ticks of {experiment['step']:g} s"
    if timing:
        title += f", {timing['step_median_us']:.0f} us per step (median)"
    out.print(f"[bold]{title}[/bold]")
    for name, holds in told["verdicts"].items():
        mark = "[green]yes[/green]" if holds else "[red]no[/red]"
        out.print(f"  {name.replace('_', ' '):24}{mark}")
    shown = ("gap_obstacle", "gap_edge", "path_error_rms", "path_error_max", "r_peak", "mu_f_max", "mu_r_max")
    for name in shown:
        if name in told["metrics"]:
            out.print(f"  {name:24}{told['metrics'][name]:.3f}")
    out.print(f"{folder}/  signals.parquet  recording.rrd  summary.json  system.ssp  figures/")
    out.print(f"Look at it with: macrostep show {folder}")


@app.command()
def build(
    models: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FILE.mo]...", help="Modelica files to build instead; FILE.mo:MODEL for one of several."),
    ] = None,
    fmi: Annotated[Fmi | None, typer.Option(help="Only this version of FMI; both if not given.")] = None,
    folder: Annotated[Path | None, typer.Option("--out", help="Where to write fmi2/ and fmi3/.")] = None,
) -> None:
    """Build the FMUs of all blocks, or those of Modelica files (into fmi2/ and fmi3/ here); what is up to date stays."""
    from components import BLOCKS  # noqa: PLC0415
    from fmus.version import Version  # noqa: PLC0415
    from orchestrator import scenario as scenarios  # noqa: PLC0415

    versions = [Version(int(fmi))] if fmi else list(Version)
    target = folder or scenarios.built_folder()
    with _working() as progress:
        if models:
            for path in scenarios.build_models(models, versions, folder or Path(), progress):
                out.print(str(path))
            return
        files = scenarios.ensure_built([b for b in BLOCKS.values() if b.native], versions, target, progress)
    out.print(f"{len(files)} FMUs in {target}/")


@app.command()
def reproduce(
    folder: Annotated[
        Path | None, typer.Option("--out", help="Folder of the report; the next free runs/reproduce-N if not given.")
    ] = None,
    varied: Annotated[int, typer.Option(metavar="N", help="Also drive N variations of the scenarios.")] = 0,
    seed: Annotated[int, typer.Option(metavar="S", help="Which variations are drawn.")] = 1,
) -> None:
    """Run every experiment of the paper, and say which of its claims hold."""
    with _working() as progress:
        progress("getting ready")
        from orchestrator.reproduction import experiments, variations  # noqa: PLC0415
        from orchestrator.reproduction import reproduce as reproduction  # noqa: PLC0415

        wanted = experiments.load()
        request = variations.request(varied, seed) if varied != 0 else None
        target = reproduction.new_folder(folder)
    driven = _drive(request) if request is not None else None
    with _working() as progress:
        made = reproduction.reproduce(wanted, target, progress, driven)
    for verdict in made.verdicts:
        out.print(f"[bold]{verdict.claim}[/bold] {verdict.words}: [bold]{verdict.status}[/bold] {verdict.condition}")
    out.print(f"{made.folder}/  report.html  report.md  report.json  runs/  figures/")


def _drive(request: Any) -> Any:
    """Drive the variations, with a bar that says how far."""
    from rich.progress import Progress  # noqa: PLC0415

    from orchestrator.reproduction import varied  # noqa: PLC0415

    with _working() as progress:
        varied.build(request, progress)
    with Progress(console=err) as bar:
        cases = bar.add_task("driving variations", total=len(request.cases))
        return varied.run(request, lambda: bar.advance(cases))


@app.command("list")
def list_() -> None:
    """Show all scenarios and blocks."""
    from components import BLOCKS  # noqa: PLC0415
    from orchestrator import scenario as scenarios  # noqa: PLC0415

    table = Table("scenario", "", box=None, title="Scenarios", title_justify="left")
    for name in scenarios.names():
        table.add_row(name, scenarios.read(name)[1].title)
    out.print(table)
    table = Table("block", "socket", "", box=None, title="Blocks", title_justify="left")
    for block in BLOCKS.values():
        table.add_row(block.name, block.socket.name, block.summary)
    out.print(table)


@app.command()
def show(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders, or an .rrd file.")],
    difference: Annotated[
        list[str] | None,
        typer.Option(help="Signal to draw as its difference from the first run, `plant.state.y`. Repeatable."),
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="In the browser, served on this machine only.")] = False,  # noqa: FBT002
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Write a picture instead; no display is needed.")
    ] = None,
    at: Annotated[list[float] | None, typer.Option(help="Time of the picture [s]. Repeatable.")] = None,
) -> None:
    """Open a run in the Rerun viewer, or several in one picture, a colour each.

    A run that was cut short is opened from a repaired copy.
    """
    from orchestrator import viewer  # noqa: PLC0415

    viewer.show(runs, difference or [], lambda text: err.print(text, markup=False), web=web)


def main() -> None:
    """Run the command; a wrong request is a message, never a traceback."""
    try:
        app()
    except Exception as error:  # noqa: BLE001 - what is not told is raised again
        sys.exit(_told(error))


def _told(error: Exception) -> int:
    """Say what was wrong, and give the exit code; anything but a wrong request or a failed build is raised again."""
    from components.interfaces.problem import RequestError  # noqa: PLC0415
    from fmus.compiler import BuildError  # noqa: PLC0415

    if isinstance(error, RequestError):
        for problem in error.problems:
            err.print("macrostep: ", end="", style="red")
            err.print(str(problem), markup=False)
        return WRONG
    if isinstance(error, BuildError):
        err.print(f"macrostep: {error}", markup=False, style="red")
        return FAULT
    raise error


if __name__ == "__main__":
    main()
