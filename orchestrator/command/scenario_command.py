"""The command `macrostep scenario`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.command.console import out, print_message

application = typer.Typer(
    help="Begin a scenario of your own, or print the form of scenario files for an editor.", invoke_without_command=True
)


@application.callback()
def scenario(
    context: typer.Context,
    *,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON schema of scenario files.")] = False,
) -> None:
    """Begin a scenario of your own, or print the form of scenario files for an editor."""
    if context.invoked_subcommand is not None:
        return
    if not schema:
        out.print(context.get_help())
        return
    import json  # noqa: PLC0415

    from orchestrator.scenario.scenario_schema import scenario_schema  # noqa: PLC0415

    typer.echo(json.dumps(scenario_schema(), indent=2))


@application.command()
def new(
    path: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file, which must not exist.")],
    base: Annotated[str, typer.Option("--from", metavar="SCENARIO", help="Whose values it has.")] = "static",
) -> None:
    """Write a scenario file to begin with: it runs as it is, and shows all that may stand in it."""
    from components.interfaces.problem import refuse  # noqa: PLC0415
    from orchestrator.mapping.template import write_template  # noqa: PLC0415
    from orchestrator.scenario.scenario_template import scenario_template  # noqa: PLC0415

    if path.suffix != ".toml":
        raise refuse(str(path), "a name of another form", "FILE.toml")
    if path.exists():
        raise refuse(str(path), "a file", "a new file", "Choose another name, or remove it.")
    write_template(scenario_template(base, path), path)
    print_message(f"written: {path}")
