"""Reads damaged inputs of all kinds, or of some: `python -m tests.fuzz --help`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from tests.fuzz import seeds
from tests.fuzz.campaign import Campaign, Tally
from tests.fuzz.kinds import KINDS


def main(
    kinds: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(KINDS)}; all if none.")] = None,
    *,
    seconds: Annotated[float | None, typer.Option(help="Time for all kinds together [s].")] = None,
    count: Annotated[int | None, typer.Option(help="Inputs of each kind, in place of a time.")] = None,
    seed: Annotated[int, typer.Option(help="The inputs follow from it, and from their numbers.")] = 1,
    jobs: Annotated[int, typer.Option(help="Processes at once.")] = 2,
    keep: Annotated[Path | None, typer.Option(help="Where what is found is kept; a new folder if not given.")] = None,
) -> None:
    """Read damaged inputs, and print what became of them; exit code 1 where one was not refused in words."""
    if unknown := set(kinds or ()) - KINDS.keys():
        raise typer.BadParameter(f"{min(unknown)}; known: {', '.join(KINDS)}")
    chosen = [KINDS[name] for name in kinds or KINDS]
    folder = keep or Path(tempfile.mkdtemp(prefix="fuzz_found_"))
    each = None if count is not None else (seconds or 120.0) / len(chosen)
    tallies: list[Tally] = []
    _print(f"{'kind':18}{'tried':>9}{'accepted':>10}{'refused':>9}{'unworded':>10}{'died':>6}{'hung':>6}")
    for kind in chosen:
        tallies.append(Campaign(kind, seed, folder).run(count=count or 10**9, jobs=jobs, seconds=each))
        _print(_row(tallies[-1]))
    for tally in tallies:
        for where, found in sorted(tally.found.items(), key=lambda item: -len(item[1].numbers)):
            _print(f"\n{tally.kind}, {len(found.numbers)} times: {where}: {found.what[:300]}")
            _print(f"  inputs {', '.join(map(str, found.numbers[:5]))}; the smallest is in {found.smallest}")
    tried, bad = sum(t.tried for t in tallies), sum(t.bad for t in tallies)
    _print(f"\n{bad} of {tried} were not refused in words (seed {seed})")
    seeds.clean()
    sys.exit(bad > 0)


def _row(tally: Tally) -> str:
    of = tally.outcomes
    read = f"{tally.kind:18}{tally.tried:9}{of['accepted']:10}{of['refused']:9}"
    return f"{read}{of['unworded']:10}{of['died']:6}{of['hung']:6}"


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - it is what the command says


if __name__ == "__main__":
    application = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    application.command()(main)
    application()
