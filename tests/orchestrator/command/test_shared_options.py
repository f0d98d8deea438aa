"""Options that several subcommands share: an option per socket, and one object for all of them."""

from __future__ import annotations

import typer
from typer.testing import CliRunner

from components import SOCKETS, Socket
from fmus import Version
from orchestrator import Options
from orchestrator.command.main import application
from orchestrator.command.run_command import RUN_OPTIONS
from orchestrator.command.shared_options import Fmi, with_options

THREE = tuple(SOCKETS.values())
DRIVER = Socket(name="driver", inputs={}, outputs={})


def taken(*arguments: str, sockets=THREE) -> Options:
    """The options that a subcommand with all of them gets."""
    found: list[Options] = []

    def command(options: Options) -> None:
        found.append(options)

    app = typer.Typer()
    app.command()(with_options(command, RUN_OPTIONS, sockets))
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    return found[0]


def test_without_options_nothing_is_changed():
    assert taken() == Options()


def test_every_option_reaches_the_one_object():
    texts = "--set plant.m=2 --set plant.mu=1 --fmi 2 --stop-time 3 --step 0.05 --algorithm jacobi --solve-loops"
    more = "--lenient --isolate plant:5 --record plant.*:2 --plant mine.fmu --controller lqr"
    assert taken(*texts.split(), *more.split()) == Options(
        mode=Version.FMI2,
        replacements={"plant": "mine.fmu", "controller": "lqr"},
        settings=["plant.m=2", "plant.mu=1"],
        step=0.05,
        stop_time=3.0,
        record=["plant.*:2"],
        algorithm="jacobi",
        solve_loops=True,
        lenient=True,
        isolate=["plant:5"],
    )
    assert taken("--blocks", "--fmi", "2").mode == "blocks"


def test_a_fourth_socket_has_its_option_in_every_subcommand_that_takes_units():
    commands = typer.main.get_command(application([*THREE, DRIVER])).commands
    for name in ("run", "export"):
        helps = {p.opts[0]: p.help for p in commands[name].params if p.param_type_name == "option"}
        assert helps["--plant"] == "Another plant: a block, FILE.fmu, the FILE.toml that maps one, or FILE.mo."
        assert helps["--traffic"] == "Other traffic, likewise."
        assert helps["--driver"] == "Another driver, likewise."
    assert taken("--driver", "mine.fmu", sockets=[DRIVER]).replacements == {"driver": "mine.fmu"}


def test_a_subcommands_own_option_takes_the_place_of_a_shared_one():
    found = []

    def command(options: Options, fmi: Fmi = Fmi.TWO) -> None:
        found.append((options.mode, fmi))

    app = typer.Typer()
    app.command()(with_options(command, ("settings", "fmi", "step"), ()))
    names = [p.name for p in typer.main.get_command(app).params]
    assert names[:3] == ["settings", "fmi", "step"]
    assert CliRunner().invoke(app, ["--fmi", "3"]).exit_code == 0
    assert found == [(Options().mode, Fmi.THREE)]
