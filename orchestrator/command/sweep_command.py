"""The command `macrostep sweep`."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

from components.interfaces.problem import Problem, raise_if_any
from orchestrator.command import shell_completion
from orchestrator.command.console import INTERRUPTED, err, out, print_notes, working
from orchestrator.command.run_command import RUN_OPTIONS
from orchestrator.scenario.options import UNCHANGED, Options

if TYPE_CHECKING:  # slow to import, and only the names are needed
    from orchestrator.sweeping.sweep import Swept
    from orchestrator.sweeping.sweep_request import SweepRequest

SWEEP_OPTIONS: Final = tuple(name for name in RUN_OPTIONS if name != "record")
"""The shared options that the subcommand takes."""


_Request: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="What `macrostep run` takes; or the folder of a sweep that was stopped, to go on with it.",
        autocompletion=shell_completion.runnable,
    ),
]
_Vary: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PATH=VALUES",
        help="What varies: `plant.m=1500:2500`, `controller.b_3=log:1e-3:1e-1`, `plant.mu=0.3,0.6`,"
        " `plant.mu=normal:0.8,0.1`, `plant=bicycle,MyVehicle.fmu`. Repeatable.",
    ),
]
_Samples: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="KIND:N",
        help="How it is sampled: `sobol:512`, `lhs:100`, `random:100`, `saltelli:64` (for Sobol indices),"
        " or a table FILE.csv with a column for each path.",
    ),
]
_Grid: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="N", help="Every combination of N values of each; `20,5`: one number for each."),
]
_Find: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="WHAT",
        help="Look for failures in place of samples: `gap_edge < 0`, `mu_r_max > 1`, `not inside_road`, `fault`.",
    ),
]
_Budget: TypeAlias = Annotated[
    str | None, typer.Option(metavar="TIME", help="How long failures are looked for: `60s`, `10min`, or N variants.")
]
_Seed: TypeAlias = Annotated[int | None, typer.Option(metavar="S", help="Which values are drawn.")]
_On: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="WHERE",
        help="Who works: `processes` (the usual), `threads`, a Dask cluster tcp://..., or a file that says which"
        " cluster is started, such as slurm.toml.",
    ),
]
_Jobs: TypeAlias = Annotated[
    int | None, typer.Option(metavar="N", help="How many work at once; one per core if not given.")
]
_Keep: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="WHICH", help="Runs that are kept: `worst:10`, or numbers. The three worst if not given."),
]
_Signals: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PATH",
        help="A signal whose mean and range over all variants are shown, such as `plant.tyre.mu_r`; repeatable."
        " `y` and `v_x` of the plant if not given.",
    ),
]
_Folder: TypeAlias = Annotated[
    Path | None, typer.Option("--out", help="Folder of the sweep; the next free runs/NAME-sweep-N if not given.")
]


def sweep(  # noqa: PLR0913 - one parameter per option of the command
    request: _Request,
    options: Options,
    vary: _Vary = None,
    samples: _Samples = None,
    grid: _Grid = None,
    find: _Find = None,
    budget: _Budget = None,
    seed: _Seed = None,
    on: _On = None,
    jobs: _Jobs = None,
    keep: _Keep = None,
    signals: _Signals = None,
    folder: _Folder = None,
) -> None:
    """Run many variants of a scenario, on all cores or on a cluster, and say what decides how they end.

    Exit code 0: all variants were run, also where some ended in a fault, which the report tells; 2: the request was
    wrong, nothing was run; 130: Ctrl-C, and the same command with the folder goes on.
    """
    with working() as progress:
        progress.now("starting")
        from orchestrator.sweeping import sweep as sweeping  # noqa: PLC0415
        from orchestrator.sweeping.engine import workforce  # noqa: PLC0415
        from orchestrator.sweeping.sweep_folder import is_sweep  # noqa: PLC0415
        from orchestrator.sweeping.sweep_request import SweepRequest  # noqa: PLC0415

        force, watched = partial(workforce, on, jobs, progress), tuple(signals or ())
        asked = (request, tuple(vary or ()), samples, grid, seed or 0, find, budget or "60s", options, watched)
        if is_sweep(Path(request)):
            _refuse(SweepRequest(*asked), {"--seed": seed, "--budget": budget, "--out": folder})
            done = sweeping.go_on(Path(request), force, keep, progress)
        else:
            done = sweeping.run_sweep(SweepRequest(*asked), force, folder, keep, progress)
    print_notes(dict.fromkeys((*done.remarks, *done.planned.scenario.remarks)))
    if not done.is_whole:
        _print_interrupted(done)
        raise typer.Exit(INTERRUPTED)
    _print(done)


def _print_interrupted(done: Swept) -> None:
    """Print how far a sweep came, and how to go on with it."""
    count = f" of {len(done.planned)}" if done.planned.request.find is None else ""
    err.print(f"macrostep: interrupted after {len(done.results)}{count} variants", style="red")
    if done.planned.request.find is None:
        err.print(f"Go on with it: macrostep sweep {shlex.quote(str(done.folder))}")
    elif done.results:
        _print_found(done)


def _refuse(request: SweepRequest, others: Mapping[str, object]) -> None:
    """Refuse what cannot be asked of a sweep that has begun. Raises `RequestError`."""
    asked = {
        "--vary": request.vary or None,
        "--samples": request.samples,
        "--grid": request.grid,
        "--find": request.find,
        "--signals": request.signals or None,
        "other options": None if request.options == UNCHANGED else request.options,
        **others,
    }
    valid = "only --on, --jobs and --keep"
    raise_if_any(
        Problem(name, "it for a sweep that has begun", valid) for name, value in asked.items() if value is not None
    )


def _print(done: Swept) -> None:
    """Print what came of a sweep in a few lines."""
    from orchestrator.sweeping import findings  # noqa: PLC0415
    from orchestrator.sweeping.ranking import badness, in_words  # noqa: PLC0415
    from orchestrator.sweeping.results_table import results_table  # noqa: PLC0415

    if done.planned.request.find is not None:
        _print_found(done)
        return
    table = results_table(done.planned, done.results)
    out.print(f"{done.planned.scenario.name}: {len(table)} variants, {done.planned.sampling}", style="bold")
    for share in (share for share in findings.shares(table) if share.known):
        interval = f"{100 * share.low:.1f} to {100 * share.high:.1f} %"
        out.print(f"  {share.name:24}{100 * share.value:.1f} %  ({share.holds} of {share.known}; 95 %: {interval})")
    worst = min(done.results.values(), key=badness)
    out.print(f"  {'worst':24}variant {worst.variant}: {in_words(worst)}")
    _print_folder(done)


def _print_found(done: Swept) -> None:
    """Print which failures a search has found."""
    from orchestrator.sweeping.ranking import in_words  # noqa: PLC0415

    kinds = f"{len(done.found)} kinds of failure" if len(done.found) != 1 else "one kind of failure"
    out.print(f"{done.planned.request.find}: {kinds}, in {len(done.results)} variants", style="bold")
    told = [(number, "") for number in done.found]
    told += [(done.mildest, ", the mildest")] if done.mildest is not None else []
    for number, what in told:
        values = ", ".join(f"{path}={values[number]}" for path, values in done.planned.columns.items())
        out.print(f"  variant {number}{what} ({values}): {in_words(done.results[number])}")
    _print_folder(done)


def _print_folder(done: Swept) -> None:
    runs = f"  runs/ ({len(done.kept)})" if done.kept else ""
    bands = "  bands.parquet" if done.planned.watched.columns else ""
    out.print(f"{done.folder}/  report.html  metrics.parquet{bands}  samples.parquet  sweep.json{runs}")
