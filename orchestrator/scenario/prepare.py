"""The preparation of a scenario: from its file and a person's options to a checked system and its experiment."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from components.interfaces.block import Block
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
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
from orchestrator.scenario.interface_choice import interface_choice
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Mode, Options
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.requested_fmus import RequestedFmus
from orchestrator.scenario.resolution import resolve
from orchestrator.scenario.scenario_file import ScenarioFile, SocketFilling, read
from orchestrator.scenario.settings import parse_record, parse_settings
from orchestrator.system.experiment import EVERYTHING, Scenario, algorithm_named, macro_step, relative_tolerance
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
    settings = parse_settings(options.settings)
    fmus = RequestedFmus(options.mode, progress, options.lenient)
    fillings, mappings, remarks = _fillings(request, content, options, fmus)
    choice = interface_choice(options.interface, [socket for socket, f in fillings.items() if f.block is None])
    blocks = {s: block_named(f.block, f"{name}: {s}.block", s) for s, f in fillings.items() if f.block is not None}
    filled = {
        socket: filled_by_block(socket, filling, blocks[socket], settings[socket])
        if socket in blocks
        else filled_by_fmu(socket, filling, mappings[socket], settings[socket], fmus, choice)
        for socket, filling in fillings.items()
    }
    remarks += [remark for one in filled.values() for remark in one.remarks]
    scene = resolve("scene", variables(Scene), parameter_set("scene"), content.scene.given(), settings["scene"])
    times, experiment = _experiment(content, options)
    raise_if_any([*(problem for one in filled.values() for problem in one.problems), *scene.problems])

    units = isolated(_sources(filled, options.mode, progress), options.isolate, in_process=options.in_process)
    remarks += _kept_inside(blocks, options.mode)
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
        record=parse_record(options.record) or content.record or EVERYTHING,
        algorithm=algorithm_named(options.algorithm or content.experiment.algorithm),
        solve_loops=options.solve_loops or content.experiment.solve_loops,
        end_off_road=options.end_off_road or content.experiment.end_off_road,
        remarks=tuple(remarks),
    )


def _kept_inside(blocks: Mapping[str, type[Block[Any, Any, Any]]], mode: Mode) -> list[str]:
    """Remarks on blocks that run in this process where others run as FMUs."""
    inside = {socket: block.name for socket, block in blocks.items() if mode != "blocks" and not block.native}
    return [f"{socket}: `{block}` runs in this process; it does not become C" for socket, block in inside.items()]


def _fillings(
    request: str, content: ScenarioFile, options: Options, fmus: RequestedFmus
) -> tuple[dict[str, SocketFilling], dict[str, MappingFile | None], list[str]]:
    """The filling of each socket after a person's changes, the mapping of each, and remarks."""
    fillings: dict[str, SocketFilling] = {}
    mappings: dict[str, MappingFile | None] = {}
    remarks: list[str] = []
    chosen = {socket: located(filling, request) for socket, filling in content.units.items()}
    raise_if_any(
        Problem("replacements", f"the unknown socket `{unknown}`", choices(SOCKETS), did_you_mean(unknown, SOCKETS))
        for unknown in options.replacements.keys() - SOCKETS.keys()
    )
    for socket in SOCKETS:
        filling, replacement = chosen.get(socket), options.replacements.get(socket)
        if filling is None and replacement is None:
            continue
        filling = filling or SocketFilling()
        filling = _replaced(socket, filling, None if replacement is None else str(replacement), fmus, remarks)
        fillings[socket], mappings[socket] = with_mapping(filling, socket)
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


def _experiment(content: ScenarioFile, options: Options) -> tuple[dict[str, float], dict[str, Mapping[str, Any]]]:
    """The numbers of the experiment, as far as they are given, and where each comes from."""
    numbers: dict[str, float] = {}
    sources: dict[str, Mapping[str, Any]] = {}
    for name, unit in (("step", "s"), ("stop_time", "s"), ("start_time", "s"), ("tolerance", "1")):
        given: Given | None = getattr(content.experiment, name)
        override = getattr(options, name)
        if override is not None:
            given = Given(value=override, unit=unit, source=f"--{name.replace('_', '-')}")
        if given is not None:
            numbers[name] = _number_in(unit, f"experiment.{name}", given, f"a number in `{unit}`")
            sources[f"experiment.{name}"] = given.model_dump()
    macro_step(numbers["step"])
    if "tolerance" in numbers:
        relative_tolerance(numbers["tolerance"])
    return numbers, sources
