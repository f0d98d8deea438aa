"""A system that was made in Python is run as a scenario is: with a scene, and with units that its folder can hold."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from components import BLOCKS, add_block, remove_block
from components.interfaces.arguments import checked_arguments
from components.interfaces.buses import VehicleState
from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.progress import SILENT, Progress
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from fmus.export.build import build
from fmus.export.own_builds import built_folder
from fmus.toolchain.compiler import find_compiler
from fmus.toolchain.file_names import FILE_NAME, is_file_name
from fmus.toolchain.version import Version
from orchestrator.execution import Execution, Finished, execute
from orchestrator.loading import completed
from orchestrator.scenario.options import UNCHANGED
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.resolution import resolve
from orchestrator.system.experiment import STEP, Choice, Scenario, algorithm_named
from orchestrator.system.scene import Scene
from orchestrator.system.shown import shown
from orchestrator.system.source import Fmu, InProcess
from orchestrator.system.system import System
from orchestrator.system.value_texts import plain

_OWN = "own"
"""The folder, among those of built FMUs, of the blocks that are not in the catalogue."""


@checked_arguments
def run(  # noqa: PLR0913 - what makes an experiment
    system: System | Scenario,
    *,
    until: float | None = None,
    h: float | None = None,
    start: float | None = None,
    name: str | None = None,
    scene: Scene | None = None,
    record: Choice | None = None,
    algorithm: str | None = None,
    solve_loops: bool | None = None,
    end_off_road: bool | None = None,
    out: Path | str | None = None,
    figures: bool = True,
    progress: Progress = SILENT,
) -> Finished:
    """Run a system and write its run folder: rows, recording, metrics, verdicts, figures, and the system itself.

    A unit that has the name of a socket and fits it fills it, where the system names no sockets. Native blocks that are
    not in the catalogue run as FMUs that are built from them, so that the folder alone repeats the run.

    Args:
        system: The system, or a scenario as `load` gives it.
        until: The stop time [s], a whole number of macro steps after the start time; a scenario has its own.
        h: The macro step [s]; 0.1, or the scenario's.
        start: The start time [s]; 0, or the scenario's.
        name: The name of the run, from which that of its folder is made; `system`, or the scenario's.
        scene: The road and the size of the vehicle, for metrics and pictures; that of the scenario `static`.
        record: Which signals are kept at every how many ticks, by pattern; all at every tick.
        algorithm: How the units exchange data: `sequential` (no hidden delay), `jacobi` or `clocked`.
        solve_loops: Whether algebraic loops are solved by iteration instead of being refused.
        end_off_road: Whether the run ends where the vehicle leaves the surroundings of the road.
        out: The run folder, which is new or holds a former run; the next free `runs/NAME-N` if not given.
        figures: Whether figures are drawn.
        progress: Receives reports on what is going on.

    Returns:
        The folder, the content of its summary, notes, and what ended the run early, if anything did.

    Raises:
        RequestError: The system cannot be run like this, or the folder cannot be used; nothing is written.
        BuildError: The C compiler failed.
    """
    given = {
        "until": until,
        "h": h,
        "start": start,
        "name": name,
        "scene": scene,
        "record": record,
        "algorithm": None if algorithm is None else algorithm_named(algorithm),
        "solve_loops": solve_loops,
        "end_off_road": end_off_road,
    }
    scenario = as_scenario(system, {key: value for key, value in given.items() if value is not None}, progress)
    with known_blocks(scenario.system):
        finished = execute(scenario, None if out is None else Path(out), progress, Execution(figures=figures))
    return replace(finished, notes=(*scenario.remarks, *finished.notes))


def as_scenario(system: System | Scenario, changes: Mapping[str, Any], progress: Progress) -> Scenario:
    """Make a scenario of a system.

    A unit with the name of a socket that it fits fills it, where the system names no sockets; where a vehicle is shown,
    the scene is the one of the paper, if none is given.

    Args:
        system: The system; a scenario is only changed.
        changes: What is given of the experiment, by the name of the field of `Scenario`.
        progress: Receives reports on blocks that become FMUs.

    Raises:
        RequestError: It is no system, there is no stop time, or what is given cannot be.
        BuildError: The C compiler fails.
    """
    if isinstance(system, Scenario):
        return replace(system, **changes)
    if "until" not in changes:
        raise refuse("run: until", "no stop time", "a number of seconds", "Write run(system, until=10.0).")
    if not is_file_name(name := changes.get("name", "system")):
        raise refuse("run: name", f"`{name}`", FILE_NAME)
    sources = dict(_sources(system))
    system, remarks = _portable(_in_sockets(system), progress)
    given: dict[str, Any] = {"name": "system", "title": "", "scene": None, "h": STEP, **changes}
    if "scene" not in changes and VehicleState in shown(system):
        road = resolve("scene", variables(Scene), parameter_set("scene"))
        raise_if_any(road.problems)
        given["scene"] = Scene(**road.values)
        sources |= road.sources
        remarks.append("no scene is given: the road and the size of the vehicle are those of the scenario `static`")
    return completed(Scenario(system=system, sources=sources, remarks=tuple(remarks), **given), UNCHANGED, progress)


def _in_sockets(system: System) -> System:
    """The system with the sockets that its units fill by their names, where it names none."""
    if system.sockets:
        return system
    fitting = {
        name: SOCKETS[name]
        for name, source in system.units.items()
        if name in SOCKETS and not [*SOCKETS[name].problems(name, source.interface.inputs, source.interface.outputs)]
    }
    return replace(system, sockets=fitting)


def _sources(system: System) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Value, unit of measurement and source of each parameter that the system gives, by full path."""
    for unit, source in system.units.items():
        known = {v.name: v.quantity.unit for v in (*source.interface.parameters, *source.interface.initials)}
        for name, value in source.parameters.items():
            yield f"{unit}.{name}", {"value": plain(value), "unit": known.get(name, ""), "source": "Python"}


def _portable(system: System, progress: Progress) -> tuple[System, list[str]]:
    """The system with blocks of a person's own as FMUs, which its folder can hold, and remarks on those that stay."""
    units, remarks = dict(system.units), list[str]()
    compiler = find_compiler() is not None
    for name, source in _of_own_blocks(system):
        if source.block.native and compiler:
            built = build(source.block, Version.FMI3, source.parameters, built_folder() / _OWN)
            units[name] = Fmu(built.path, source.parameters)
            if built.rebuilt:
                progress.done(f"built {source.block.name} for FMI {Version.FMI3}.0")
        else:
            why = "there is no C compiler" if source.block.native else "it does not become C"
            remark = (
                f"{name}: `{source.block.name}` runs in this process, because {why}; its folder alone repeats no run"
            )
            remarks.append(remark)
    return replace(system, units=units), remarks


def _of_own_blocks(system: System) -> Iterator[tuple[str, InProcess]]:
    """The units of blocks that are not in the catalogue."""
    for name, source in system.units.items():
        if isinstance(source, InProcess) and BLOCKS.get(source.block.name) is not source.block:
            yield name, source


@contextmanager
def known_blocks(system: System) -> Generator[None]:
    """See to it that the run folder of a system can be read in this process, whatever blocks it has.

    Raises:
        RequestError: A block has the name of another one.
    """
    with ExitStack() as added:
        for _, source in _of_own_blocks(system):
            add_block(source.block)
            added.callback(remove_block, source.block.name)
        yield
