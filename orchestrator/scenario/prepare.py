"""Scenarios: from a readable file and a person's options to a checked system and its experiment."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from components.interfaces.block import Block
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from fmus.modelica.build_modelica import build_modelica, is_modelica
from fmus.toolchain.version import Version
from orchestrator.scenario.catalogue import block_named, built_folder, ensure_built
from orchestrator.scenario.fillings import FOREIGN, Gathered, chosen_fmu, foreign_part, located, sources_of, wiring_of
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Mode, Options
from orchestrator.scenario.parameters import (
    SCENARIOS,
    Given,
    Part,
    ScenarioFile,
    Setting,
    checked,
    parameter_set,
    values_of,
)
from orchestrator.scenario.settings import parse_record, parse_settings
from orchestrator.system.experiment import EVERYTHING, Scenario, algorithm_named, macro_step
from orchestrator.system.files import read_toml
from orchestrator.system.scene import Scene
from orchestrator.system.source import Fmu, InProcess, UnitSource
from orchestrator.system.system import System


def names() -> list[str]:
    """The scenarios that come with macrostep."""
    return sorted(path.stem for path in SCENARIOS.glob("*.toml"))


def read(request: str) -> tuple[str, ScenarioFile]:
    """The name and content of a scenario, given by name or as a file. Raises `RequestError`."""
    path = Path(request)
    if path.suffix != ".toml":
        if request not in names():
            remedy = did_you_mean(request, names()) or "`macrostep list` shows them all."
            raise refuse(f"scenario `{request}`", "no such scenario", f"{choices(names())}, or a .toml file", remedy)
        path = SCENARIOS / f"{request}.toml"
    return path.stem, checked(ScenarioFile, read_toml(path), str(path) if path.suffix == request[-5:] else path.name)


def prepare(request: str, options: Options, progress: Callable[[str], None] = lambda _: None) -> Scenario:
    """Read a scenario, apply the options, build the FMUs it needs, and check everything. Raises `RequestError`."""
    name, content = read(request)
    settings = parse_settings(options.settings)
    parts, gathered = _parts(request, content, options, progress)
    kinds = {s: block_named(p.block, f"{name}: {s}.block", s) for s, p in parts.items() if p.block is not None}
    for socket, part in parts.items():
        if socket in kinds:
            gathered.of_block(socket, part, kinds[socket], settings[socket])
        else:
            gathered.of_fmu(socket, part, settings[socket], lenient=options.lenient)
    scene, scene_sources, found = _scene(content.scene.parameters, settings["scene"])
    h, until, given = _experiment(content, options)
    raise_if_any([*gathered.problems, *found])

    units = isolated(_units(kinds, gathered, options.mode, progress), options.isolate)
    remarks = gathered.remarks
    if options.mode != "blocks":
        inside = {socket: kind.name for socket, kind in kinds.items() if not kind.native}
        remarks += [f"{socket}: `{name}` runs in this process; it does not become C" for socket, name in inside.items()]
    system = System(units=units, wiring=wiring_of(units), sockets=SOCKETS, steps=_own_steps(parts, h))
    return Scenario(
        name=name,
        title=content.title,
        system=system,
        scene=scene(),
        h=h,
        until=until,
        sources={**gathered.sources, **scene_sources, **given},
        record=parse_record(options.record) or content.record or EVERYTHING,
        algorithm=algorithm_named(options.algorithm or content.experiment.algorithm),
        solve_loops=options.solve_loops or content.experiment.solve_loops,
        remarks=tuple(remarks),
    )


def _parts(
    request: str, content: ScenarioFile, options: Options, progress: Callable[[str], None]
) -> tuple[dict[str, Part], Gathered]:
    """What fills each socket, as the scenario says and a person's options change it."""
    parts: dict[str, Part] = {}
    gathered = Gathered()
    for socket in SOCKETS:
        part, wanted = located(getattr(content, socket), request), options.replacements.get(socket)
        if wanted is not None:
            wanted = _as_fmu(wanted, socket, options.mode, progress)
        elif part.fmu is not None:
            part = part.model_copy(update={"fmu": _as_fmu(part.fmu, socket, options.mode, progress)})
        part = _replaced(socket, part, wanted, gathered.remarks, lenient=options.lenient)
        parts[socket], gathered.mappings[socket] = foreign_part(part, socket)
    return parts, gathered


def _own_steps(parts: Mapping[str, Part], h: float) -> dict[str, Fraction]:
    """The steps of units that have their own, as multiples of the macro step `h`. Raises `RequestError`."""
    found: dict[str, Fraction] = {}
    for socket, part in parts.items():
        if part.step is not None:
            step = _seconds(f"{socket}.step", part.step, "a positive number in `s`", above=0.0)
            found[socket] = Fraction(step / h).limit_denominator(1_000_000)
    return found


def _seconds(where: str, given: Given, valid: str, above: float = -math.inf) -> float:
    if given.unit == "s" and isinstance(given.value, int | float) and above < given.value <= sys.float_info.max:
        return float(given.value)
    raise refuse(where, f"`{given.value}` in `{given.unit}`", valid)


def _as_fmu(request: str, socket: str, mode: Mode, progress: Callable[[str], None]) -> str:
    """The FMU of a Modelica file, built now; any other request as it is."""
    if not is_modelica(request):
        return request
    progress(f"building {request}")
    version = Version.FMI3 if mode == "blocks" else mode
    return str(build_modelica(request, version, built_folder() / "modelica", socket).path)


def _replaced(socket: str, part: Part, replacement: str | None, remarks: list[str], *, lenient: bool) -> Part:
    """The part a person chose instead; parameters of the scenario go along where the new one has them."""
    given = part.given(socket)
    if replacement is None:
        return part.model_copy(update={"parameters": given})
    if replacement.endswith(FOREIGN):
        part = part.model_copy(update={"parameters": given})
        return chosen_fmu(socket, part, replacement, remarks, lenient=lenient)
    declared = {v.name for v in block_named(replacement, f"--{socket}", socket).parameters()}
    kept = {n: g for n, g in given.items() if n in declared}
    dropped = sorted(given.keys() - kept.keys())
    if dropped:
        remarks.append(f"{socket}: `{replacement}` has no parameters {', '.join(dropped)}; the scenario's are not used")
    return Part(block=replacement, parameters=kept, step=part.step)


def _units(
    kinds: Mapping[str, type[Block[Any, Any, Any]]],
    gathered: Gathered,
    mode: Mode,
    progress: Callable[[str], None],
) -> dict[str, UnitSource]:
    files: dict[tuple[str, Version], Path] = {}
    if mode != "blocks":
        native = [kind for kind in kinds.values() if kind.native]
        files = ensure_built(native, [mode], built_folder(), progress)
    units: dict[str, UnitSource] = {}
    for socket in SOCKETS:
        if socket in gathered.foreign:
            units[socket] = gathered.foreign[socket]
        elif mode == "blocks" or not kinds[socket].native:
            units[socket] = InProcess(kinds[socket], gathered.values[socket])
        else:
            units[socket] = Fmu(files[kinds[socket].name, mode], gathered.values[socket])
    return units


def _scene(
    own: Mapping[str, Given], settings: Sequence[Setting]
) -> tuple[Callable[[], Scene], dict[str, Mapping[str, Any]], list[Problem]]:
    defaults, declared = parameter_set("scene"), variables(Scene)
    values, problems = values_of("scene", declared, defaults, own, settings)
    return lambda: Scene(**values), sources_of("scene", declared, values, {**defaults, **own}, settings), problems


def _experiment(content: ScenarioFile, options: Options) -> tuple[float, float, dict[str, Mapping[str, Any]]]:
    chosen: dict[str, float] = {}
    told: dict[str, Mapping[str, Any]] = {}
    for name, override in (("step", options.step), ("stop_time", options.stop_time)):
        given: Given = getattr(content.experiment, name)
        if override is not None:
            given = Given(value=override, unit="s", source=f"--{name.replace('_', '-')}")
        chosen[name] = _seconds(f"experiment.{name}", given, "a number in `s`")
        told[f"experiment.{name}"] = given.model_dump()
    return macro_step(chosen["step"]), chosen["stop_time"], told
