"""The command `macrostep list`."""

from __future__ import annotations

from typing import Annotated

import typer

from orchestrator.command import shell_completion
from orchestrator.command.console import out


def list_(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="A block or a scenario, to see all about it.", autocompletion=shell_completion.named
        ),
    ] = None,
) -> None:
    """Show all scenarios and blocks, or one of them with its parameters."""
    if name is not None:
        from orchestrator.exchange.catalogue_in_words import in_words  # noqa: PLC0415

        for line in in_words(name):
            out.print(line)
        return
    from rich.table import Table  # noqa: PLC0415

    from components import BLOCKS  # noqa: PLC0415
    from orchestrator.scenario import scenario_file  # noqa: PLC0415

    table = Table("scenario", "", box=None, title="Scenarios", title_justify="left")
    for scenario in scenario_file.names():
        table.add_row(scenario, scenario_file.read(scenario)[1].title)
    out.print(table)
    table = Table("block", "socket", "", box=None, title="Blocks", title_justify="left")
    for block in BLOCKS.values():
        table.add_row(block.name, block.socket.name, block.summary)
    out.print(table)
    out.print("All about one of them: macrostep list NAME")
