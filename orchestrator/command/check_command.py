"""The command `macrostep check`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.command.console import FAULT, out, print_problems, working


def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An .fmu, an .ssp, or a mapping file (.toml).")],
    socket: Annotated[str | None, typer.Option(help="The socket that an FMU is meant for.")] = None,
    template: Annotated[
        Path | None, typer.Option("--out", help="Where the mapping template goes; FILE.SOCKET.toml if not given.")
    ] = None,
    static: Annotated[  # noqa: FBT002
        bool, typer.Option("--static", help="Only read an FMU; without it, an FMU also makes its first step.")
    ] = False,
) -> None:
    """Say what a file is, which rules it breaks, which socket it fits and what is missing.

    An FMU is also run up to the end of its first step, in a process of its own, which shows what is wrong with it.
    With `--socket` a mapping template is written too, if one is of use; a file that is there is never overwritten.
    Exit code 0: all well, and it fits the socket that was named, perhaps by conversions that are listed; 1: it breaks
    rules, cannot be used, or does not fit the socket; 2: the request was wrong.
    """
    from orchestrator.exchange import check as checking  # noqa: PLC0415

    with working() as progress:
        progress.now(f"reading {file}")
        result = checking.check(file, socket, template, static=static)
    for line in result.lines:
        out.print(line, markup=False)
    print_problems(result.problems)
    if not result.good:
        raise typer.Exit(FAULT)
