"""The options of `macrostep run`, as typer reads them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeAlias

import typer


class Fmi(StrEnum):
    """Versions of FMI."""

    TWO = "2"
    THREE = "3"


Request: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO", help="A scenario by name, a .toml file, an .ssp file, a run folder, or a single .fmu."
    ),
]
Plant: TypeAlias = Annotated[
    str | None, typer.Option(help="Another plant: a block, FILE.fmu, the FILE.toml that maps one, or FILE.mo.")
]
Traffic: TypeAlias = Annotated[str | None, typer.Option(help="Other traffic, likewise.")]
Controller: TypeAlias = Annotated[str | None, typer.Option(help="Another controller, likewise.")]
Settings: TypeAlias = Annotated[
    list[str] | None, typer.Option("--set", help="Change a parameter: `controller.b_3=1e-2`. Repeatable.")
]
FmiVersion: TypeAlias = Annotated[Fmi, typer.Option(help="Version of FMI that blocks run as.")]
Blocks: TypeAlias = Annotated[bool, typer.Option("--blocks", help="Run blocks in this process, without a compiler.")]
StopTime: TypeAlias = Annotated[float | None, typer.Option(help="End of the run [s].")]
Step: TypeAlias = Annotated[float | None, typer.Option(help="Macro step [s].")]
MasterAlgorithm: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--algorithm",
        metavar="NAME",
        help="How units exchange data: sequential (no hidden delay), jacobi (as most other masters), clocked (FMI 3.0"
        " Event Mode).",
    ),
]
SolveLoops: TypeAlias = Annotated[
    bool, typer.Option("--solve-loops", help="Solve algebraic loops by iteration; refused if not given.")
]
Lenient: TypeAlias = Annotated[
    bool, typer.Option("--lenient", help="Run files though they break rules of FMI or SSP; notes say which.")
]
Isolate: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="UNIT[:SECONDS]",
        help="Run an FMU in a process of its own: one that dies or hangs ends the run in order. Repeatable.",
    ),
]
Out: TypeAlias = Annotated[
    Path | None, typer.Option("--out", help="Run folder; the next free runs/NAME-N if not given.")
]

_WATCH = "Watching and recording"
Live: TypeAlias = Annotated[
    bool, typer.Option("--live", help="Open the viewer and follow the run in it.", rich_help_panel=_WATCH)
]
NoViewer: TypeAlias = Annotated[
    bool,
    typer.Option("--no-viewer", help="Live without a window: only say where to connect.", rich_help_panel=_WATCH),
]
Connect: TypeAlias = Annotated[
    str | None,
    typer.Option(metavar="URL", help="Live in a viewer that is already open.", rich_help_panel=_WATCH),
]
Web: TypeAlias = Annotated[
    bool, typer.Option("--web", help="Live in the browser, served to this machine only.", rich_help_panel=_WATCH)
]
Realtime: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="FACTOR", help="Keep pace with the clock: 1 is real time, 2 is faster.", rich_help_panel=_WATCH
    ),
]
Record: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PATTERN[:N]",
        help="Record only signals that fit: `plant.*`, `controller.plan.*:10` (every 10th tick); "
        "`plant.*:0` alone: all others. Repeatable.",
        rich_help_panel=_WATCH,
    ),
]
