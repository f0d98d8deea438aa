"""The command `macrostep check`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from components.interfaces.problem import refuse
from orchestrator.command import shell_completion
from orchestrator.command.console import FAULT, err, out, print_message, print_problems, working

_CheckedFile: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="An .fmu, .ssp or .mo, or a mapping file (.toml).",
        autocompletion=shell_completion.checkable,
    ),
]


def check(  # noqa: PLR0913 - each is an option of the command
    file: _CheckedFile,
    socket: Annotated[str | None, typer.Option(help="The socket that an FMU is meant for.")] = None,
    target: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Where the mapping template goes, FILE.SOCKET.toml if not given; or the folder of the passport.",
        ),
    ] = None,
    static: Annotated[  # noqa: FBT002
        bool, typer.Option("--static", help="Only read an FMU; without it, an FMU also makes its first step.")
    ] = False,
    lenient: Annotated[  # noqa: FBT002
        bool,
        typer.Option("--lenient", help="Tell broken rules that `run --lenient` overlooks as notes."),
    ] = False,
    passport: Annotated[  # noqa: FBT002
        bool,
        typer.Option("--passport", help="Measure an FMU: FILE.passport.html and FILE.passport.json are written."),
    ] = False,
    against: Annotated[
        Path | None, typer.Option(metavar="JSON", help="Another passport, to say what got better or worse.")
    ] = None,
) -> None:
    """Say what a file is, which rules it breaks, which socket it fits and what is missing.

    An FMU is also run up to the end of its first step, in a process of its own, which shows what is wrong with it. A
    Modelica model whose names are not those of a socket is built first, and described as its FMU.
    With `--socket` a mapping template is written too, if one is of use; a file that is there is never overwritten.
    With `--passport` an FMU is run, in processes of its own, and everything about it is measured on one page.
    Exit code 0: all well, and it fits the socket that was named, perhaps by conversions that are listed; 1: it breaks
    rules (and there is no `--lenient`), cannot be used, does not fit the socket, or a line of its passport fails (with
    `--against`: one that did not fail before); 2: the request was wrong.
    """
    if passport:
        _passport(file, target, against, {"--socket": socket is not None, "--static": static, "--lenient": lenient})
        return
    if against is not None:
        raise refuse("--against", "a passport to compare with, but none to compare", "--passport --against FILE.json")
    from orchestrator.exchange import check as checking  # noqa: PLC0415

    with working() as progress:
        progress.now(f"reading {file}")
        result = checking.check(file, socket, target, static=static, lenient=lenient, progress=progress)
    for line in result.lines:
        out.print(line)
    print_problems(result.problems)
    if not result.good:
        raise typer.Exit(FAULT)


def _passport(file: Path, folder: Path | None, against: Path | None, others: Mapping[str, bool]) -> None:
    """Measure an FMU, print the lines that fail, and write its passport.

    Args:
        file: The FMU.
        folder: Where the passport goes.
        against: Another passport.
        others: Options that a passport has no use for, and whether they were given.
    """
    from orchestrator.exchange.passport.passport import passport  # noqa: PLC0415
    from orchestrator.exchange.passport.passport_comparison import compared_with, read_passport  # noqa: PLC0415
    from orchestrator.exchange.passport.passport_line import Mark  # noqa: PLC0415
    from orchestrator.exchange.passport.passport_page import write_passport  # noqa: PLC0415

    if given := [name for name, is_given in others.items() if is_given]:
        raise refuse(
            "--passport", f"{given[0]} beside it", "--out, --against", "A passport tries all sockets, and runs."
        )
    before = None if against is None else read_passport(against)
    with working() as progress:
        made = passport(file, progress)
        comparison = None if before is None else compared_with(before, made.data())
        progress.now("writing the passport")
        files = write_passport(made, folder or Path(), file.stem, comparison)
    for line in made.lines:
        if line.mark is Mark.FAILS:
            err.print("fails: ", end="", style="red")
            print_message(f"{line.title} ({line.key}): {line.evidence}")
    if comparison is not None:
        for line in comparison.lines:
            out.print(f"{line.change}: {line.title} ({line.key}): {line.before}, now {line.after}")
    passed, failed, other = (made.count(mark) for mark in Mark)
    out.print(f"{made.identity['file']}: {passed} pass, {failed} fail, {other} do not apply")
    out.print(f"written: {' and '.join(map(str, files))}")
    if not (made.good if comparison is None else comparison.good):
        raise typer.Exit(FAULT)
