"""Does all faults, or those of some groups, and prints the score: `python -m tests.faults --help`."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from tests.faults.scoring import known_faults, outcome, table


def main(
    groups: Annotated[list[str] | None, typer.Argument(help="Only groups whose names begin so; all if none.")] = None,
    *,
    seed: Annotated[int, typer.Option(help="The times and places of the faults follow from it.")] = 0,
    short: Annotated[bool, typer.Option("--short", help="Only those that CI does.")] = False,
    named: Annotated[str, typer.Option(help="Only faults whose names contain this.")] = "",
) -> None:
    """Do faults to the product, one after the other, and print how many of each group it stands."""
    chosen = [
        fault
        for fault in known_faults()
        if (fault.short or not short) and named in fault.name and (not groups or fault.group.startswith(tuple(groups)))
    ]
    outcomes = []
    for fault in chosen:
        outcomes.append(outcome(fault, seed))
        verdict = "no" if outcomes[-1].reason else "ok"
        print(f"{verdict}  {outcomes[-1].took:5.1f} s  {fault.group}: {fault.name}", flush=True)  # noqa: T201
    print(table(outcomes))  # noqa: T201
    sys.exit(any(one.reason for one in outcomes))


if __name__ == "__main__":
    typer.run(main)
