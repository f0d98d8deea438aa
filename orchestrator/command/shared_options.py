"""The options that several subcommands share, and how they become the one object `Options`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import StrEnum
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import typer

from fmus.toolchain.version import Version
from orchestrator.command import shell_completion
from orchestrator.scenario.options import Options

if TYPE_CHECKING:  # it is slow to import, and most subcommands do not need it
    from components.interfaces.socket import Socket


class Fmi(StrEnum):
    """The versions of FMI, as they are typed."""

    TWO = "2"
    THREE = "3"

    @property
    def version(self) -> Version:
        """The version of FMI that is meant."""
        return Version(int(self))


ScenarioRequest: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario by name, a .toml file, an .ssp file, a run folder, or a single .fmu.",
        autocompletion=shell_completion.runnable,
    ),
]
WATCHING: Final = "Watching and recording"
"""The panel of the help in which the options for watching and recording stand."""


def _option(name: str, annotation: Any, default: Any = None) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


_SHARED: Final = (
    _option(
        "settings",
        Annotated[
            list[str] | None,
            typer.Option("--set", help="Change a parameter: `controller.b_3=1e-2`; `@FILE`: one a line. Repeatable."),
        ],
    ),
    _option("fmi", Annotated[Fmi, typer.Option(help="Version of FMI that blocks run as.")], Fmi.THREE),
    _option(
        "blocks",
        Annotated[bool, typer.Option("--blocks", help="Run blocks in this process, without a compiler.")],
        default=False,
    ),
    _option("stop_time", Annotated[float | None, typer.Option(help="End of the run [s].")]),
    _option("start_time", Annotated[float | None, typer.Option(help="Beginning of the run [s].")]),
    _option("step", Annotated[float | None, typer.Option(help="Macro step [s].")]),
    _option(
        "tolerance",
        Annotated[float | None, typer.Option(help="Relative tolerance that all FMUs are told; each its own if not.")],
    ),
    _option(
        "algorithm",
        Annotated[
            str | None,
            typer.Option(
                metavar="NAME",
                help="How units exchange data: sequential (no hidden delay), jacobi (as most other masters), clocked"
                " (FMI 3.0 Event Mode).",
            ),
        ],
    ),
    _option(
        "solve_loops",
        Annotated[
            bool, typer.Option("--solve-loops", help="Solve algebraic loops by iteration; refused if not given.")
        ],
        default=False,
    ),
    _option(
        "end_off_road",
        Annotated[
            bool, typer.Option("--end-off-road", help="End where the vehicle is more than 10 m beside the road.")
        ],
        default=False,
    ),
    _option(
        "lenient",
        Annotated[
            bool, typer.Option("--lenient", help="Run files though they break rules of FMI or SSP; notes say which.")
        ],
        default=False,
    ),
    _option(
        "allow_nonfinite",
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="PATTERN",
                help="Let signals that fit be infinite or NaN although a unit reads them: `radar.ttc`. Repeatable.",
            ),
        ],
    ),
    _option(
        "input",
        Annotated[
            str | None,
            typer.Option(
                metavar="FILE",
                help="Let inputs that nothing drives follow a table, .csv or .parquet: `time`, then `v [km/h]`, ...",
            ),
        ],
    ),
    _option(
        "input_hold",
        Annotated[bool, typer.Option("--input-hold", help="Hold the table's values until the next row.")],
        default=False,
    ),
    _option(
        "isolate",
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="UNIT[:SECONDS]",
                help="Run an FMU in a process of its own, as those of other makers do anyway: one that dies or hangs,"
                " or takes longer than SECONDS for a call (30), ends the run in order. Repeatable.",
            ),
        ],
    ),
    _option(
        "interface",
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="[UNIT=]cs|me",
                help="Run FMUs that have both as Co-Simulation (the default) or Model Exchange. Repeatable.",
            ),
        ],
    ),
    _option(
        "in_process",
        Annotated[
            bool,
            typer.Option(
                "--in-process",
                help="Run the FMUs of other makers in this process, too, but for those with --isolate: some"
                " microseconds faster, and what such an FMU does to its process is done to the run.",
            ),
        ],
        default=False,
    ),
    _option(
        "record",
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="PATTERN[:N]",
                help="Record only signals that fit: `plant.*`, `controller.plan.*:10` (every 10th tick); "
                "`plant.*:0` alone: all others. Repeatable.",
                rich_help_panel=WATCHING,
            ),
        ],
    ),
)
"""All options that change a scenario, in the order of the help; a socket gives one each, before these."""


def with_options(command: Callable[..., None], names: Sequence[str], sockets: Iterable[Socket]) -> Callable[..., None]:
    """Make a subcommand whose parameter `options` is filled from the command line.

    Args:
        command: The subcommand, with a parameter `options` of type `Options`. A parameter of its own that has the name
            of a shared option takes its place on the command line, and is not used for `options`.
        names: The shared options that the subcommand takes.
        sockets: The sockets that another unit can be chosen for.

    Returns:
        The subcommand with the options of the command line in the place of `options`, for `typer`.
    """
    own = dict(signature(command, eval_str=True).parameters)
    replacing = list(_replacing(sockets))
    shared = [p for p in _SHARED if p.name in names]

    def subcommand(**given: Any) -> None:
        replacements = {p.name: unit for p in replacing if (unit := given.pop(p.name)) is not None}
        changes = {p.name: given.pop(p.name) for p in shared if p.name not in own}
        command(**given, options=_options(replacements, **changes))

    offered = [own.get(p.name, p) for p in (*replacing, *shared)]
    parameters: list[Parameter] = []
    for parameter in own.values():
        if parameter.name == "options":
            parameters += offered
        elif parameter not in offered:
            parameters.append(parameter)
    subcommand.__name__, subcommand.__doc__ = command.__name__, command.__doc__
    keywords = [p.replace(kind=Parameter.KEYWORD_ONLY) for p in parameters]
    subcommand.__signature__ = Signature(keywords)  # pyright: ignore[reportFunctionMemberAccess] - `inspect` reads it
    return subcommand


def _replacing(sockets: Iterable[Socket]) -> Iterator[Parameter]:
    """An option per socket; the help of the first says what all of them take."""
    values = ": a block, FILE.fmu, the FILE.toml that maps one, or FILE.mo."
    for socket in sockets:
        text = (socket.substitute or f"Another {socket.name}") + values
        yield _option(socket.name, Annotated[str | None, typer.Option(help=text)])
        values = ", likewise."


def _options(replacements: Mapping[str, str], *, fmi: Fmi = Fmi.THREE, blocks: bool = False, **changes: Any) -> Options:
    """The options of a run; those that were not given keep their default."""
    given = {name: value for name, value in changes.items() if value is not None}
    return Options(mode="blocks" if blocks else fmi.version, replacements=replacements, **given)
