"""The command `macrostep`."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.command import scenario_command, shell_completion, supervisor
from orchestrator.command.build_command import build
from orchestrator.command.check_command import check
from orchestrator.command.companions import Companions
from orchestrator.command.console import FAULT, WRONG, err, out, print_problems
from orchestrator.command.export_command import EXPORT_OPTIONS, export
from orchestrator.command.list_command import list_
from orchestrator.command.reproduce_command import reproduce
from orchestrator.command.run_command import RUN_OPTIONS, run
from orchestrator.command.shared_options import with_options
from orchestrator.command.show_command import show
from orchestrator.command.supervisor import Lifeline
from orchestrator.command.sweep_command import SWEEP_OPTIONS, sweep

if TYPE_CHECKING:
    from components.interfaces.socket import Socket
    from orchestrator.recording.process import RecordingProcess

# The subcommands import what they need when they are called: a person waits for every library that is imported here.


def application(sockets: Iterable[Socket]) -> typer.Typer:
    """Make the command with all its subcommands.

    Args:
        sockets: The sockets that `run` and `export` take another unit for, by an option of the same name.

    Returns:
        The application; when it is called, its object is what a run has beside it.
    """
    app = typer.Typer(
        help="Co-simulate an automated vehicle: plant, traffic and controller as FMI components, inspected in Rerun.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode="markdown",
    )
    known = tuple(sockets)
    app.callback()(_common)
    app.command()(with_options(run, RUN_OPTIONS, known))
    app.command()(with_options(sweep, SWEEP_OPTIONS, known))
    app.command()(with_options(export, EXPORT_OPTIONS, known))
    app.command()(build)
    app.command()(reproduce)
    app.command()(check)
    app.command("list")(list_)
    app.command()(show)
    app.add_typer(scenario_command.application, name="scenario")
    return app


def _versions(wanted: bool) -> None:  # noqa: FBT001 - typer calls it like this
    if wanted:
        from orchestrator.results.provenance import versions  # noqa: PLC0415

        for name, version in versions().items():
            out.print(f"{name} {version}")
        raise typer.Exit


def _common(
    *,
    _version: Annotated[
        bool,
        typer.Option("--version", callback=_versions, is_eager=True, help="Show versions, and those of libraries."),
    ] = False,
) -> None:
    """Take the options that come before a subcommand; the help is that of the application."""


def main(lifeline: Lifeline | None = None) -> None:
    """Run the command; a wrong request becomes a message, never a traceback.

    Args:
        lifeline: Leads to a process that outlives this one, if there is any.
    """
    subcommand, *arguments = sys.argv[1:] or shell_completion.words() or [""]
    try:
        with _recorder(subcommand, arguments) as recorder:
            application(_sockets(subcommand))(obj=Companions(recorder, lifeline or Lifeline()))
    except Exception as error:  # noqa: BLE001 - what is not reported is raised again
        sys.exit(_report(error))


def _recorder(subcommand: str, arguments: list[str]) -> AbstractContextManager[RecordingProcess | None]:
    """For a run the process that records it: on another core it imports its libraries while this one does the same."""
    if subcommand != run.__name__ or "--help" in arguments or shell_completion.words():
        return nullcontext()
    from orchestrator.recording.process import RecordingProcess  # noqa: PLC0415

    return RecordingProcess()


def _sockets(subcommand: str) -> Iterable[Socket]:
    """The sockets where the subcommand has options for them; importing them is slow."""
    if subcommand not in {run.__name__, sweep.__name__, export.__name__}:
        return ()
    from components.interfaces.sockets import SOCKETS  # noqa: PLC0415

    return SOCKETS.values()


def _report(error: Exception) -> int:
    """Print what was wrong and return the exit code; a mistake of our own is raised again."""
    from components.interfaces.problem import RequestError  # noqa: PLC0415
    from fmus.toolchain.compiler import BuildError  # noqa: PLC0415

    if isinstance(error, RequestError):
        print_problems(error.problems)
        return WRONG
    if isinstance(error, BuildError):
        err.print(f"macrostep: {error}", style="red")
        return FAULT
    if isinstance(error, OSError) and error.strerror:  # a disk, a folder or a limit of this machine
        where = f"{error.filename}: " if error.filename is not None else ""
        err.print(f"macrostep: {where}{error.strerror}", style="red")
        return FAULT
    raise error


if __name__ == "__main__":
    supervisor.main()
