"""The command `macrostep run`."""

from __future__ import annotations

import shlex
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from orchestrator.command.companions import Companions
from orchestrator.command.console import FAULT, INTERRUPTED, err, out, print_message, print_notes, working
from orchestrator.command.shared_options import WATCHING, ScenarioRequest
from orchestrator.scenario.options import Options

if TYPE_CHECKING:
    from orchestrator.execution import Finished

RUN_OPTIONS: Final = (
    "settings",
    "fmi",
    "blocks",
    "stop_time",
    "start_time",
    "step",
    "tolerance",
    "algorithm",
    "solve_loops",
    "end_off_road",
    "lenient",
    "allow_nonfinite",
    "input",
    "input_hold",
    "isolate",
    "interface",
    "in_process",
    "record",
)
"""The shared options that the subcommand takes."""


def _watching(*names: str, **facts: Any) -> Any:
    """An option of the panel on watching and recording."""
    return typer.Option(*names, rich_help_panel=WATCHING, **facts)


def run(  # noqa: PLR0913 - one parameter per option of the command
    context: typer.Context,
    scenario: ScenarioRequest,
    options: Options,
    folder: Annotated[
        Path | None, typer.Option("--out", help="Run folder; the next free runs/NAME-N if not given.")
    ] = None,
    live: Annotated[bool, _watching("--live", help="Open the viewer and follow the run in it.")] = False,  # noqa: FBT002
    no_viewer: Annotated[  # noqa: FBT002
        bool, _watching("--no-viewer", help="Live without a window: only say the address of a page.")
    ] = False,
    web: Annotated[bool, _watching("--web", help="Live in the browser, served to this machine only.")] = False,  # noqa: FBT002
    connect: Annotated[str | None, _watching(metavar="URL", help="Live in a viewer that is already open.")] = None,
    wait: Annotated[bool, _watching("--wait", help="Live: begin when somebody watches.")] = False,  # noqa: FBT002
    realtime: Annotated[
        float | None, _watching(metavar="FACTOR", help="Keep pace with the clock: 1 is real time, 2 is faster.")
    ] = None,
) -> None:
    """Run a scenario and write its run folder.

    The FMUs it needs are built on the way. Exit code 0: all well; 1: the run ended in a fault, everything up to it is
    in the folder; 2: the request was wrong, nothing was written; 130: Ctrl-C, everything up to it is in the folder.
    """
    with ExitStack() as watching:
        with working() as progress:
            from orchestrator.execution import execute  # noqa: PLC0415
            from orchestrator.loading import load  # noqa: PLC0415
            from orchestrator.viewing.live import LiveStream, live_options  # noqa: PLC0415

            beside: Companions = context.obj
            stream_options = live_options(live=live, viewer=not no_viewer, web=web, url=connect, wait=wait)
            loaded = load(scenario, options, progress)
            stream = (
                None if stream_options is None else watching.enter_context(LiveStream(stream_options, print_message))
            )
            finished = execute(loaded, folder, progress, beside.execution(stream, realtime))
        print_notes(loaded.remarks + finished.notes)
        _print_summary(finished)
        code = _conclude(finished)
        if stream is not None and err.is_terminal:
            stream.stay()
    raise typer.Exit(code)


def _conclude(finished: Finished) -> int:
    """Print what ended the run before its time, and return the exit code."""
    if isinstance(finished.ended, KeyboardInterrupt):
        err.print(f"macrostep: interrupted after {finished.summary['experiment']['ticks']} ticks", style="red")
        return INTERRUPTED
    if finished.ended is not None:
        err.print(f"macrostep: the run ended in a fault at {finished.ended}", style="red")
        return FAULT
    return 0


def _print_summary(finished: Finished) -> None:
    """Print the run in a few lines."""
    summary, folder = finished.summary, finished.folder
    experiment, timing = summary["experiment"], summary["timing"]
    title = f"{summary['scenario']}: {experiment['ticks']} ticks of {experiment['step']:g} s"
    if timing:
        title += f", {timing['step_median_us']:.0f} us per step (median)"
    if "realtime" in summary:
        title += f", {_pace(summary['realtime'])}"
    out.print(title, style="bold")
    for name, holds in summary["verdicts"].items():
        out.print(f"  {name.replace('_', ' '):24}", end="")
        out.print("yes" if holds else "no", style="green" if holds else "red")
    from orchestrator.results.provenance import SHOWN_METRICS  # noqa: PLC0415
    from orchestrator.results.run_folder import FIGURES  # noqa: PLC0415

    for name, unit in SHOWN_METRICS.items():
        if name in summary["metrics"]:
            out.print(f"  {name:24}{summary['metrics'][name]:.3f} {unit}".rstrip())
    for name in ("solver_limits", "solver_fallbacks"):
        if failed := summary["metrics"].get(name):
            out.print(f"  {name:24}{failed:.0f} of {experiment['ticks']} samples")
    figures = f"  {FIGURES}/" if (folder / FIGURES).is_dir() else ""
    out.print(f"{folder}/  signals.parquet  recording.rrd  summary.json  system.ssp{figures}")
    out.print(f"Look at it with: macrostep show {shlex.quote(str(folder))}")


def _pace(realtime: dict[str, Any]) -> str:
    """How well a run kept pace with the clock."""
    late = "no tick late"
    if realtime["late_ticks"]:
        late = f"{realtime['late_ticks']} ticks late, the worst by {realtime['worst_s'] * 1e3:.1f} ms"
    return f"at {realtime['factor']:g} x real time ({late})"
