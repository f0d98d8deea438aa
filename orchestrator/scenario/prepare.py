"""Scenarios: from a readable file and a person's options to a checked system and its experiment."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

import fmus
from components import BLOCKS, EXTRAS
from components.interfaces.block import Block
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from fmus.export.build import build_all
from fmus.modelica.build_modelica import build_modelica, is_modelica
from fmus.toolchain.version import Version
from orchestrator.scenario.fillings import FOREIGN, Gathered, chosen_fmu, foreign_part, located, sources_of, wiring_of
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.parameters import (
    SCENARIOS,
    Given,
    Part,
    ScenarioFile,
    Setting,
    checked,
    parameter_set,
    read_toml,
    values_of,
)
from orchestrator.scenario.settings import parse_record, parse_settings
from orchestrator.stepping.rows import EVERYTHING, Choice
from orchestrator.stepping.schedule import Algorithm, algorithm_named, macro_step
from orchestrator.system.scene import Scene
from orchestrator.system.system import Fmu, InProcess, Source, System

Mode = Literal["blocks"] | Version
"""How blocks run: in this process, or as FMUs of a version."""


@dataclass(frozen=True)
class Options:
    """What a person changes of a scenario for one run."""

    mode: Mode = Version.FMI3
    replacements: Mapping[str, str] = field(default_factory=dict[str, str])
    """Block name or FMU file by socket"""
    settings: Sequence[str] = ()
    """`controller.b_3=1e-2`"""
    step: float | None = None
    stop_time: float | None = None
    record: Sequence[str] = ()
    """`controller.plan.*:10`"""
    algorithm: str | None = None
    solve_loops: bool = False
    lenient: bool = False
    """Whether FMUs run though they break rules"""
    isolate: Sequence[str] = ()
    """`plant:5`: units in processes of their own, and for how long [s] a call may take"""


@dataclass(frozen=True)
class Scenario:
    """A system with an experiment, ready to run."""

    name: str
    title: str
    system: System
    scene: Scene | None
    h: float
    until: float
    sources: Mapping[str, Mapping[str, Any]]
    """Value, unit and source of every parameter, by full path"""
    record: Choice = field(default_factory=lambda: dict(EVERYTHING))
    """Which signals are recorded at every how many ticks"""
    algorithm: Algorithm = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    remarks: tuple[str, ...] = ()


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


def built_folder() -> Path:
    """Where built FMUs are: in the checkout, or in the user's cache when macrostep is installed."""
    package = Path(fmus.__file__).parent
    if (package.parent / "pyproject.toml").is_file():
        return package / "built"
    import platformdirs  # noqa: PLC0415 - only an installed macrostep needs it

    return platformdirs.user_cache_path("macrostep") / "built"


def block_named(name: str, where: str, socket: str | None = None) -> type[Block[Any, Any, Any]]:
    """A block of the catalogue, for a socket if one is named. Raises `RequestError`."""
    fitting = [n for n, block in BLOCKS.items() if socket in (None, block.socket.name)]
    if name in EXTRAS and name not in BLOCKS:
        raise refuse(where, f"`{name}` without its extra", choices(fitting), f"Install macrostep[{EXTRAS[name]}].")
    if name not in BLOCKS:
        remedy = did_you_mean(name, fitting) or "A file ends in .fmu or .mo."
        raise refuse(where, f"the unknown block `{name}`", choices(fitting), remedy)
    if name not in fitting:
        raise refuse(where, f"`{name}`, a block of the socket `{BLOCKS[name].socket.name}`", choices(fitting))
    return BLOCKS[name]


def default_values(block: type[Block[Any, Any, Any]]) -> dict[str, Any]:
    """The numbers of a block's own parameter set: the start values of its FMU."""
    values, problems = values_of(block.name, block.parameters(), parameter_set(block.name), {})
    raise_if_any(problems)
    return values


def ensure_built(
    blocks: Sequence[type[Block[Any, Any, Any]]],
    versions: Sequence[Version],
    folder: Path,
    progress: Callable[[str], None],
) -> dict[tuple[str, Version], Path]:
    """Build what is missing or out of date; the FMU file of each block and version."""
    requests = [(block, version, default_values(block)) for block in blocks for version in versions]
    built = build_all(requests, folder, progress)
    return {(block.name, version): b.path for (block, version, _), b in zip(requests, built, strict=True)}


def build_models(
    requests: Sequence[str], versions: Sequence[Version], folder: Path, progress: Callable[[str], None]
) -> list[Path]:
    """Build the FMUs of Modelica files: `FILE.mo`, or `FILE.mo:MODEL`. Raises `RequestError`."""
    valid = "a Modelica file: FILE.mo, or FILE.mo:MODEL"
    raise_if_any(Problem("macrostep build", f"`{r}`", valid) for r in requests if not is_modelica(r))
    found: list[Path] = []
    for request in requests:
        progress(f"building {request}")
        found += [build_modelica(request, version, folder).path for version in versions]
    return found


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
) -> dict[str, Source]:
    files: dict[tuple[str, Version], Path] = {}
    if mode != "blocks":
        native = [kind for kind in kinds.values() if kind.native]
        files = ensure_built(native, [mode], built_folder(), progress)
    units: dict[str, Source] = {}
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
