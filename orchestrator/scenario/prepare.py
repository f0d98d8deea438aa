"""The preparation of a scenario: from its file and a person's options to a checked system and its experiment."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import Gathered, Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.progress import SILENT, Progress
from components.interfaces.quantity import Quantity
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from fmus.toolchain.version import Version
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.scenario.catalogue import block_named, built_folder, ensure_built
from orchestrator.scenario.fillings import (
    Filled,
    chosen_fmu,
    filled_by_block,
    filled_by_fmu,
    is_foreign,
    located,
    wiring_of,
    with_mapping,
)
from orchestrator.scenario.interface_choice import NO_CHOICE, interface_choice
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Mode, Options
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.requested_fmus import RequestedFmus
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.scenario.scenario_file import ScenarioFile, SocketFilling, read
from orchestrator.scenario.settings import parse_record, parse_settings
from orchestrator.system.experiment import (
    EVERYTHING,
    Algorithm,
    Scenario,
    algorithm_named,
    macro_step,
    relative_tolerance,
)
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene
from orchestrator.system.source import Fmu, InProcess, UnitSource
from orchestrator.system.system import System
from orchestrator.system.value_texts import in_unit_of


def prepare(request: str, options: Options, progress: Progress = SILENT) -> Scenario:
    """Read a scenario, apply the options, build the FMUs it needs, and check everything.

    Args:
        request: The name of a scenario that comes with macrostep, or the path of a `.toml` file.
        options: The changes that a person makes to it.
        progress: Receives reports on what is being built.

    Returns:
        The checked system with its experiment.

    Raises:
        RequestError: The scenario, the options or the files that they name are wrong.
        BuildError: The C compiler fails.
    """
    name, content = read(request)
    wrong = Gathered()
    no_settings: dict[str, list[Setting]] = {unit: [] for unit in (*SOCKETS, "scene")}
    settings = wrong.attempt(lambda: parse_settings(options.settings, wrong.problems), no_settings)
    fmus = RequestedFmus(options.mode, progress, options.lenient)
    fillings, mappings, remarks = _fillings(request, content, options, fmus, wrong)
    filled = _filled(name, fillings, mappings, settings, options, fmus, wrong)
    remarks += [remark for one in filled.values() for remark in one.remarks]
    given = wrong.attempt(content.scene.given, dict[str, Given]())
    scene = resolve("scene", variables(Scene), parameter_set("scene"), given, settings["scene"])
    times, experiment = _experiment(content, options, wrong)
    algorithm = wrong.attempt(
        lambda: algorithm_named(options.algorithm or content.experiment.algorithm), Algorithm.SEQUENTIAL
    )
    record = wrong.attempt(lambda: parse_record(options.record), dict[str, int]())
    raise_if_any([*wrong.problems, *scene.problems])

    units = isolated(_sources(filled, options.mode, progress), options.isolate, in_process=options.in_process)
    remarks += _kept_inside(filled, options.mode)
    sockets = {socket: SOCKETS[socket] for socket in units}
    steps = _own_steps(fillings, times["step"])
    sources = {path: source for one in filled.values() for path, source in one.resolution.sources.items()}
    return Scenario(
        name=name,
        title=content.title,
        system=System(units, wiring_of(units), sockets=sockets, steps=steps, allow_nonfinite=content.allow_nonfinite),
        scene=Scene(**scene.values),
        h=times["step"],
        until=times["stop_time"],
        start=times.get("start_time", 0.0),
        tolerance=times.get("tolerance"),
        sources={**sources, **scene.sources, **experiment},
        record=record or content.record or EVERYTHING,
        algorithm=algorithm,
        solve_loops=options.solve_loops or content.experiment.solve_loops,
        end_off_road=options.end_off_road or content.experiment.end_off_road,
        remarks=tuple(remarks),
    )


def _filled(  # noqa: PLR0913 - all that a person says of them
    name: str,
    fillings: Mapping[str, SocketFilling],
    mappings: Mapping[str, MappingFile | None],
    settings: Mapping[str, Sequence[Setting]],
    options: Options,
    fmus: RequestedFmus,
    wrong: Gathered,
) -> dict[str, Filled]:
    """What fills each socket, as far as nothing is wrong with it."""
    by_fmus = [socket for socket, filling in fillings.items() if filling.block is None]
    choice = wrong.attempt(lambda: interface_choice(options.interface, by_fmus), NO_CHOICE)

    def filled(socket: str, filling: SocketFilling) -> Filled:
        own = settings[socket]
        if filling.block is not None:
            return filled_by_block(socket, filling, block_named(filling.block, f"{name}: {socket}.block", socket), own)
        return filled_by_fmu(socket, filling, mappings[socket], own, fmus, choice)

    found = {socket: wrong.attempt(partial(filled, socket, filling), None) for socket, filling in fillings.items()}
    known = {socket: one for socket, one in found.items() if one is not None}
    wrong.problems += [problem for one in known.values() for problem in one.problems]
    return known


def _kept_inside(filled: Mapping[str, Filled], mode: Mode) -> list[str]:
    """Remarks on blocks that run in this process where others run as FMUs."""
    blocks = {socket: one.block for socket, one in filled.items() if one.block is not None}
    inside = {socket: block.name for socket, block in blocks.items() if mode != "blocks" and not block.native}
    return [f"{socket}: `{block}` runs in this process; it does not become C" for socket, block in inside.items()]


def _fillings(
    request: str, content: ScenarioFile, options: Options, fmus: RequestedFmus, wrong: Gathered
) -> tuple[dict[str, SocketFilling], dict[str, MappingFile | None], list[str]]:
    """The filling of each socket after a person's changes, the mapping of each, and remarks."""
    fillings: dict[str, SocketFilling] = {}
    mappings: dict[str, MappingFile | None] = {}
    remarks: list[str] = []
    chosen = {socket: located(filling, request) for socket, filling in content.units.items()}
    wrong.problems += [
        Problem("replacements", f"the unknown socket `{unknown}`", choices(SOCKETS), did_you_mean(unknown, SOCKETS))
        for unknown in options.replacements.keys() - SOCKETS.keys()
    ]

    def filled(socket: str, filling: SocketFilling) -> tuple[SocketFilling, MappingFile | None]:
        replacement = options.replacements.get(socket)
        filling = _replaced(socket, filling, None if replacement is None else str(replacement), fmus, remarks)
        return with_mapping(filling, socket)

    for socket in (s for s in SOCKETS if s in chosen or options.replacements.get(s) is not None):
        found = wrong.attempt(partial(filled, socket, chosen.get(socket) or SocketFilling()), None)
        if found is not None:
            fillings[socket], mappings[socket] = found
    return fillings, mappings, remarks


def _own_steps(fillings: Mapping[str, SocketFilling], h: float) -> dict[str, Fraction]:
    """The steps of units that have their own, as multiples of the macro step `h`. Raises `RequestError`."""
    steps: dict[str, Fraction] = {}
    for socket, filling in fillings.items():
        if filling.step is not None:
            step = _number_in("s", f"{socket}.step", filling.step, "a positive number in `s`", above=0.0)
            steps[socket] = Fraction(step / h).limit_denominator(1_000_000)
    return steps


def _number_in(unit: str, where: str, given: Given, valid: str, above: float = -math.inf) -> float:
    found = in_unit_of(given, Quantity(unit, ""))
    if found is not None and isinstance(found.value, int | float) and above < found.value <= sys.float_info.max:
        return float(found.value)
    raise refuse(where, f"`{given.value}` in `{given.unit}`", valid)


def _replaced(
    socket: str, filling: SocketFilling, replacement: str | None, fmus: RequestedFmus, remarks: list[str]
) -> SocketFilling:
    """The filling that a person chose instead, with the parameters of the scenario that the new one has too."""
    given = filling.given(socket)
    if replacement is None:
        return filling.model_copy(update={"parameters": given})
    if is_foreign(replacement):
        filling = filling.model_copy(update={"parameters": given})
        return chosen_fmu(socket, filling, replacement, fmus, remarks)
    declared = {v.name for v in block_named(replacement, f"--{socket}", socket).parameters()}
    kept = {n: g for n, g in given.items() if n in declared}
    dropped = sorted(given.keys() - kept.keys())
    if dropped:
        remarks.append(f"{socket}: `{replacement}` has no parameters {', '.join(dropped)}; the scenario's are not used")
    return SocketFilling(block=replacement, parameters=kept, step=filling.step)


def _sources(filled: Mapping[str, Filled], mode: Mode, progress: Progress) -> dict[str, UnitSource]:
    """The sources of all units; the FMUs of all blocks are built at once, so that compilers run in parallel."""
    files: dict[tuple[str, Version], Path] = {}
    if mode != "blocks":
        native = {one.block: one.resolution.values for one in filled.values() if one.block and one.block.native}
        values = {block.name: given for block, given in native.items()}
        files = ensure_built([*native], [mode], built_folder(), progress, values)
    units: dict[str, UnitSource] = {}
    for socket, one in filled.items():
        if one.fmu is not None:
            units[socket] = one.fmu
        elif one.block is not None:
            file = None if mode == "blocks" else files.get((one.block.name, mode))
            values = one.resolution.values
            units[socket] = InProcess(one.block, values) if file is None else Fmu(file, values)
    return units


_CHECKS: Final[Mapping[str, Callable[[float], float]]] = {"step": macro_step, "tolerance": relative_tolerance}
"""What the numbers of an experiment have to be besides numbers."""


def _experiment(
    content: ScenarioFile, options: Options, wrong: Gathered
) -> tuple[dict[str, float], dict[str, Mapping[str, Any]]]:
    """The numbers of the experiment, as far as they are given, and where each comes from."""
    numbers: dict[str, float] = {}
    sources: dict[str, Mapping[str, Any]] = {}
    for name, unit in (("step", "s"), ("stop_time", "s"), ("start_time", "s"), ("tolerance", "1")):
        given: Given | None = getattr(content.experiment, name)
        override = getattr(options, name)
        if override is not None:
            given = Given(value=override, unit=unit, source=f"--{name.replace('_', '-')}")
        if given is not None:
            number = partial(_number_in, unit, f"experiment.{name}", given, f"a number in `{unit}`")
            check = _CHECKS.get(name, float)
            numbers[name] = wrong.attempt(lambda number=number, check=check: check(number()), math.nan)
            sources[f"experiment.{name}"] = given.model_dump()
    return numbers, sources
