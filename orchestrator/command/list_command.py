"""The command `macrostep list`."""

from __future__ import annotations

from orchestrator.command.console import out


def list_() -> None:
    """Show all scenarios and blocks."""
    from rich.table import Table  # noqa: PLC0415

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
