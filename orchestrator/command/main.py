"""The command `macrostep`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from orchestrator.command import options
from orchestrator.command.console import err, out
from orchestrator.command.console import working as _working
from orchestrator.command.export_command import export
from orchestrator.command.options import Fmi
from orchestrator.recording.process import RecordingProcess

# The commands import what they need themselves: a person waits for every library that is imported here, and while
# `run` imports its own, the process that records does the same on another core.

FAULT, WRONG, INTERRUPTED = 1, 2, 130
"""Exit codes: the run ended in a fault; the request was wrong; Ctrl-C."""

app = typer.Typer(
    help="Co-simulate an automated vehicle: plant, traffic and controller as FMI components, inspected in Rerun.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


def _version(wanted: bool) -> None:  # noqa: FBT001 - typer hands it on like this
    if wanted:
        from orchestrator.results.provenance import versions  # noqa: PLC0415

        for name, version in versions().items():
            out.print(f"{name} {version}", markup=False, highlight=False)
        raise typer.Exit


@app.callback()
def common(
    *,
    _version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show versions, and those of libraries.")
    ] = False,
) -> None:
    """Options of no command; the help is the application's."""


@app.command()
def run(  # noqa: PLR0913 - one parameter per option of the command
    scenario: options.Request,
    plant: options.Plant = None,
    traffic: options.Traffic = None,
    controller: options.Controller = None,
    setting: options.Settings = None,
    fmi: options.FmiVersion = Fmi.THREE,
    blocks: options.Blocks = False,  # noqa: FBT002
    stop_time: options.StopTime = None,
    step: options.Step = None,
    algorithm: options.MasterAlgorithm = None,
    solve_loops: options.SolveLoops = False,  # noqa: FBT002
    lenient: options.Lenient = False,  # noqa: FBT002
    isolate: options.Isolate = None,
    folder: options.Out = None,
    record: options.Record = None,
    live: options.Live = False,  # noqa: FBT002
    no_viewer: options.NoViewer = False,  # noqa: FBT002
    web: options.Web = False,  # noqa: FBT002
    connect: options.Connect = None,
    realtime: options.Realtime = None,
) -> None:
    """Run a scenario and write its run folder.

    The FMUs it needs are built on the way. Exit code 0: all well; 1: the run ended in a fault, everything up to it is
    in the folder; 2: the request was wrong, nothing was written; 130: Ctrl-C, everything up to it is in the folder.
    """
    chosen = {"plant": plant, "traffic": traffic, "controller": controller}
    with ExitStack() as watching:
        with _working() as progress, RecordingProcess() as recording:
            from fmus.toolchain.version import Version  # noqa: PLC0415
            from orchestrator.load import load  # noqa: PLC0415
            from orchestrator.run import Beside, execute  # noqa: PLC0415
            from orchestrator.scenario.options import Options  # noqa: PLC0415
            from orchestrator.viewing.live import LiveStream, live_options  # noqa: PLC0415

            options = Options(
                mode="blocks" if blocks else Version(int(fmi)),
                replacements={socket: name for socket, name in chosen.items() if name is not None},
                settings=setting or [],
                step=step,
                stop_time=stop_time,
                record=record or [],
                algorithm=algorithm,
                solve_loops=solve_loops,
                lenient=lenient,
                isolate=isolate or [],
            )
            wanted = live_options(live=live, viewer=not no_viewer, web=web, url=connect)
            loaded = load(scenario, options, progress)
            stream = None if wanted is None else watching.enter_context(LiveStream(wanted, _tell))
            finished = execute(loaded, folder, progress, Beside(recording, stream, realtime))
        code = _conclude(finished, loaded.remarks)
        if stream is not None and err.is_terminal:
            stream.stay()
    raise typer.Exit(code)


def _conclude(finished: Any, remarks: tuple[str, ...]) -> int:
    """Tell how a run went, and give the exit code."""
    for remark in remarks + finished.notes:
        err.print(f"note: {remark}", markup=False)
    _report(finished.summary, finished.folder)
    if isinstance(finished.ended, KeyboardInterrupt):
        err.print(f"macrostep: interrupted after {finished.summary['experiment']['ticks']} ticks", style="red")
        return INTERRUPTED
    if finished.ended is not None:
        err.print(f"macrostep: the run ended in a fault at {finished.ended}", style="red")
        return FAULT
    return 0


def _tell(text: str) -> None:
    """Something a person may want to know while the run goes on."""
    err.print(text, markup=False)


def _report(told: dict[str, Any], folder: Path) -> None:
    """The run in a few lines."""
    experiment, timing = told["experiment"], told["timing"]
    title = f"{told['scenario']}: {experiment['ticks']} ticks of {experiment['step']:g} s"
    if timing:
        title += f", {timing['step_median_us']:.0f} us per step (median)"
    if "realtime" in told:
        title += f", {_pace(told['realtime'])}"
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


def _pace(told: dict[str, Any]) -> str:
    late = "no tick late"
    if told["late_ticks"]:
        late = f"{told['late_ticks']} ticks late, the worst by {told['worst_s'] * 1e3:.1f} ms"
    return f"at {told['factor']:g} x real time ({late})"


app.command()(export)


@app.command()
def build(
    models: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FILE.mo]...", help="Modelica files to build instead; FILE.mo:MODEL for one of several."
        ),
    ] = None,
    fmi: Annotated[Fmi | None, typer.Option(help="Only this version of FMI; both if not given.")] = None,
    folder: Annotated[Path | None, typer.Option("--out", help="Where to write fmi2/ and fmi3/.")] = None,
) -> None:
    """Build the FMUs of all blocks, or those of Modelica files (into fmi2/ and fmi3/ here), where out of date."""
    from components import BLOCKS  # noqa: PLC0415
    from fmus.toolchain.version import Version  # noqa: PLC0415
    from orchestrator.scenario import catalogue  # noqa: PLC0415

    versions = [Version(int(fmi))] if fmi else list(Version)
    target = folder or catalogue.built_folder()
    with _working() as progress:
        if models:
            for path in catalogue.build_models(models, versions, folder or Path(), progress):
                out.print(str(path))
            return
        files = catalogue.ensure_built([b for b in BLOCKS.values() if b.native], versions, target, progress)
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
        from orchestrator.reproduction import reproduce as reproduction  # noqa: PLC0415
        from orchestrator.reproduction.paper import experiments  # noqa: PLC0415
        from orchestrator.reproduction.varied import variations  # noqa: PLC0415

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

    from orchestrator.reproduction.varied import varied_set  # noqa: PLC0415

    with _working() as progress:
        varied_set.build(request, progress)
    with Progress(console=err) as bar:
        cases = bar.add_task("driving variations", total=len(request.cases))
        return varied_set.run(request, lambda: bar.advance(cases))


@app.command()
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An .fmu, an .ssp, or a mapping file (.toml).")],
    socket: Annotated[str | None, typer.Option(help="The socket that an FMU is meant for.")] = None,
    template: Annotated[
        Path | None, typer.Option("--out", help="Where the mapping template goes; FILE.SOCKET.toml if not given.")
    ] = None,
) -> None:
    """Say what a file is, which rules it breaks, which socket it fits and what is missing.

    An FMU is also instantiated, in a process of its own, which shows what is wrong with its library.
    With `--socket` a mapping template is written too, if one is of use; a file that is there is never overwritten.
    Exit code 0: all well, and it fits the socket that was named, perhaps by conversions that are listed; 1: it breaks
    rules, cannot be used, or does not fit the socket; 2: the request was wrong.
    """
    from orchestrator.exchange.check import check as checking  # noqa: PLC0415

    with _working() as progress:
        progress(f"reading {file}")
        found = checking(file, socket, template)
    for line in found.lines:
        out.print(line, markup=False)
    for problem in found.problems:
        err.print("macrostep: ", end="", style="red")
        err.print(str(problem), markup=False)
    if not found.good:
        raise typer.Exit(FAULT)


@app.command("list")
def list_() -> None:
    """Show all scenarios and blocks."""
    from components import BLOCKS  # noqa: PLC0415
    from orchestrator.scenario import scenario_file  # noqa: PLC0415

    table = Table("scenario", "", box=None, title="Scenarios", title_justify="left")
    for name in scenario_file.names():
        table.add_row(name, scenario_file.read(name)[1].title)
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
    from orchestrator.viewing import viewer  # noqa: PLC0415

    tell: Callable[[str], None] = lambda text: err.print(text, markup=False)  # noqa: E731
    viewer.show(runs, difference or [], tell, web=web, picture=picture, times=at or [])


def main() -> None:
    """Run the command; a wrong request is a message, never a traceback."""
    try:
        app()
    except Exception as error:  # noqa: BLE001 - what is not told is raised again
        sys.exit(_told(error))


def _told(error: Exception) -> int:
    """Say what was wrong, and give the exit code; anything but a wrong request or a failed build is raised again."""
    from components.interfaces.problem import RequestError  # noqa: PLC0415
    from fmus.toolchain.compiler import BuildError  # noqa: PLC0415

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
