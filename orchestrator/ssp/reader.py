"""Reading a system from an SSP file of any maker, SSP 1.0 or 2.0, and those that `writer` wrote.

Systems in systems become one: `inner` in the system `outer` is the unit `outer_inner`, and connections through
connectors of systems lead from unit to unit. Parameter values of bindings further out replace those further in, later
ones earlier ones. Inputs that nothing drives keep their start values. What cannot be run as it stands is refused with
its file and line, all of it at once; `lenient` turns breaches of the standard whose meaning is clear into remarks.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, refuse
from components.interfaces.quantity import Type
from components.interfaces.record import variables
from components.interfaces.socket import Socket
from components.interfaces.sockets import SOCKETS
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.ssp.annotation import NOTHING, Notes, read_notes
from orchestrator.ssp.archive import VALID, Document, Findings, open_package, read_document
from orchestrator.ssp.assembly import Assembly
from orchestrator.ssp.connection_graph import Wiring
from orchestrator.ssp.parameter_values import Value, gather
from orchestrator.ssp.rules import NS
from orchestrator.ssp.ssp_units import Part, open_parts, opened, problem_at
from orchestrator.ssp.structure import Group, read_structure
from orchestrator.ssp.types import number
from orchestrator.stepping.schedule import open_dependencies_close_a_loop
from orchestrator.system.experiment import STEP, Algorithm, Scenario, algorithm_named, macro_step
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

_MANY: Final = 12
"""Inputs that a remark names"""

OPEN_LOOP: Final = (
    "units that feed each other leave open what their outputs depend on: values are exchanged one step late, as"
    " with --algorithm jacobi; --algorithm and --solve-loops change it"
)

Settings = Mapping[str, Sequence[Setting]]


def read(  # noqa: PLR0913 - what a person can change
    path: Path,
    settings: Settings | None = None,
    step: float | None = None,
    stop_time: float | None = None,
    *,
    lenient: bool = False,
    isolate: Sequence[str] = (),
) -> Scenario:
    """The system and experiment in an `.ssp` file, with a person's changes. Raises `RequestError`.

    `isolate` are units in processes of their own, besides those that were when the file was written.
    """
    findings = Findings(lenient=lenient)
    document = _description(path, findings)
    root = None if document is None else read_structure(document)
    if document is None or root is None:
        raise RequestError(findings.problems)
    notes = read_notes(document)
    known = notes or NOTHING
    parts = open_parts(root, findings, ours=notes is not None)
    experiment = _experiment(document, notes, step, stop_time)
    units, assembly, sources = _units(root, parts, findings, settings or {})
    requests = [f"{name}:{seconds}" for name, seconds in known.isolated.items()]
    units = findings.attempt(lambda: isolated(units, [*requests, *isolate])) or units
    scene, scene_sources = _scene(known, (settings or {}).get("scene", ()), findings)
    system = _system(units, assembly, notes, _steps(notes, parts, experiment))
    if system is None or findings.problems:
        raise RequestError(dict.fromkeys(findings.problems))
    _tell_left(assembly, known)
    late = notes is None and open_dependencies_close_a_loop(system)
    if late:
        findings.remarks.append(OPEN_LOOP)
    top = document.root.find("ssd:System", NS)
    name = document.root.get("name", "")
    return Scenario(
        name=name if notes is not None and _is_file_name(name) else _plain_name(name or path.stem),
        title=top.get("description") or (name if notes is None else ""),
        system=system,
        scene=scene,
        h=experiment.step,
        until=experiment.until,
        sources={**sources, **known.sources, **scene_sources},
        record=known.record,
        algorithm=Algorithm.JACOBI if late else algorithm_named(known.algorithm),
        solve_loops=known.solve_loops,
        remarks=(*findings.remarks, *experiment.remarks),
    )


def _system(
    units: Mapping[str, UnitSource], assembly: Assembly, notes: Notes | None, steps: Mapping[str, Fraction]
) -> System | None:
    """The system; None where it is wrong: the findings say why, with the places in the SSP."""
    try:
        return System(
            units=units,
            wiring=assembly.wiring,
            held=assembly.held | _noted_inputs(notes or NOTHING, units),
            sockets=_sockets(notes, units),
            transformations=assembly.transformations,
            unconverted=frozenset(assembly.unconverted),
            steps=steps,
        )
    except RequestError as error:
        assembly.findings.problems += [problem_at(p, assembly.lines) for p in error.problems]
        return None


def _tell_left(assembly: Assembly, notes: Notes) -> None:
    """One remark on the inputs that nothing drives or sets."""
    left = [told for told in assembly.left if told.partition(" = ")[0] not in notes.held]
    if left:
        more = f" and {len(left) - _MANY} others" if len(left) > _MANY else ""
        told = f"inputs that nothing drives keep their start values: {', '.join(left[:_MANY])}{more}"
        assembly.findings.remarks.append(told)


def _description(path: Path, findings: Findings) -> Document | None:
    """The main description of an SSP. Raises `RequestError`."""
    package = open_package(path, str(path), findings)
    file = package.folder / "SystemStructure.ssd"
    if not file.is_file():
        is_fmu = (package.folder / "modelDescription.xml").is_file()
        remedy = "It is an FMU: give it with --plant, --traffic or --controller." if is_fmu else ""
        raise refuse(str(path), "an archive without SystemStructure.ssd", VALID, remedy)
    return read_document(package, file)


def _is_file_name(name: str) -> bool:
    return name not in {"", ".."} and Path(name).name == name


def _plain_name(name: str) -> str:
    return re.sub(r"[^\w-]+", "_", name).strip("_") or "system"


@dataclass(frozen=True)
class _Experiment:
    step: float
    until: float
    remarks: tuple[str, ...]


def _experiment(document: Document, notes: Notes | None, step: float | None, stop_time: float | None) -> _Experiment:
    findings, remarks = document.findings, ()
    node = document.root.find("ssd:DefaultExperiment", NS)
    start = until = None
    if node is not None:
        start, until = (number(document, node, name) for name in ("startTime", "stopTime"))
        if start:
            findings.breach(document.at(node), f"a start time of {start:g} s", "0 s, when every run begins")
    until = until if stop_time is None else stop_time
    if until is None:
        where = document.at(document.root if node is None else node)
        findings.wrong(where, "no stop time", "a number of seconds", "Say how long with --stop-time.")
    if step is None:
        step = notes.step if notes else _hinted_step(document)
    if step is None:
        step, remarks = STEP, (f"the SSP says no macro step: {STEP:g} s is used; --step changes it",)
    return _Experiment(findings.attempt(lambda: macro_step(step)) or STEP, until or 0.0, remarks)


def _hinted_step(document: Document) -> float | None:
    """The macro step in an annotation of libcosim or OMSimulator."""
    for name, attribute in (("FixedStepAlgorithm", "baseStepSize"), ("FixedStepMaster", "stepSize")):
        for node in document.root.iterfind(f".//{{*}}{name}"):
            if (found := number(document, node, attribute)) is not None and found > 0:
                return found
    return None


def _units(
    root: Group, parts: dict[tuple[str, ...], Part], findings: Findings, settings: Settings
) -> tuple[dict[str, UnitSource], Assembly, dict[str, Mapping[str, Any]]]:
    """All units with their parameter values, how they are connected, and where the values come from."""
    values = gather(root, lambda component, name: component.path in parts and parts[component.path].has(name))
    assembly = Assembly(findings, values, Wiring(root, parts, findings))
    for path, part in parts.items():
        if part.structural:
            given = {n: v for n, (v, _) in assembly.parameters(part, part.structural).items()}
            given |= {
                s.name: s.value for s in settings.get(part.name, ()) if s.name in part.structural and s.index is None
            }
            parts[path] = part.opened_with(given, findings)
    units: dict[str, UnitSource] = {}
    sources: dict[str, Mapping[str, Any]] = {}
    for part in parts.values():
        units[part.name], told = _with_values(part, assembly.parameters(part), settings.get(part.name, ()), assembly)
        sources |= told
        _refuse_others(part, assembly)
    for part in parts.values():
        assembly.connect(part)
    for name in settings.keys() - units.keys() - {"scene"}:
        if settings[name]:
            close = did_you_mean(name, units)
            findings.wrong(
                f"--set {name}.{settings[name][0].name}", f"the unknown unit `{name}`", choices(units), close
            )
    return units, assembly, sources


def _with_values(
    part: Part, found: Mapping[str, tuple[Any, Value]], settings: Sequence[Setting], assembly: Assembly
) -> tuple[UnitSource, dict[str, Mapping[str, Any]]]:
    settable = (*part.source.interface.parameters, *part.source.interface.initials)
    declared = {v.name: v.quantity.unit for v in settable}
    given = {n: Given(value=v, unit=declared[n], source=value.origin) for n, (v, value) in found.items()}
    for setting in settings:
        assembly.lines.pop(f"{part.name}.{setting.name}", None)  # what is wrong with it does not stand in the file
        # one element changes; the others stay as the unit has them
        start = part.source.interface.starts.get(setting.name)
        if setting.index is not None and setting.name not in given and isinstance(start, np.ndarray):
            given[setting.name] = Given(value=start.tolist(), unit=declared[setting.name], source="start values")
    resolved = resolve(part.name, settable, given=given, settings=settings)
    assembly.findings.problems += [problem_at(p, assembly.lines) for p in resolved.problems]
    source = part.source.with_parameters(resolved.values)
    if part.structural and opened(source, part.component, assembly.findings) is None:
        source = part.source
    return source, resolved.sources


def _refuse_others(part: Part, assembly: Assembly) -> None:
    """Start values of variables that are neither parameters nor inputs."""
    for name, value in assembly.values.variables.get(part.component.path, {}).items():
        if part.settable(name) is None:
            told = f"a value of `{part.name}.{name}`, which the unit says is not to be set"
            assembly.findings.wrong(value.step.where, told, "values of parameters, inputs and start values")


def _steps(notes: Notes | None, parts: Mapping[tuple[str, ...], Part], experiment: _Experiment) -> dict[str, Fraction]:
    """Units with a step of their own: as our annotation says, or OSP's for a component."""
    if notes is not None:
        return notes.steps
    hints = {part.name: part.component.step_size for part in parts.values() if part.component.step_size}
    found = {n: Fraction(hint / experiment.step).limit_denominator(10_000) for n, hint in hints.items()}
    return {n: ratio for n, ratio in found.items() if ratio != 1}


def _noted_inputs(notes: Notes, units: Mapping[str, UnitSource]) -> dict[str, Any]:
    """Held inputs of our annotation, bytes being hexadecimal digits there."""
    kinds = {f"{n}.{v.name}": v.quantity.type for n, s in units.items() for v in s.interface.inputs}
    return {path: _bytes(value) if kinds.get(path) is Type.BINARY else value for path, value in notes.held.items()}


def _bytes(value: Any) -> Any:
    return bytes.fromhex(value) if isinstance(value, str) else [_bytes(item) for item in value]


def _sockets(notes: Notes | None, units: Mapping[str, UnitSource]) -> dict[str, Socket]:
    """The sockets that units fill: as our annotation says, or where a unit fits one that no other has taken."""
    if notes is not None:
        return {name: SOCKETS[socket] for name, socket in notes.sockets.items()}
    found: dict[str, Socket] = {}
    for name, source in units.items():
        fitting = (
            s for s in SOCKETS.values() if not s.problems(name, source.interface.inputs, source.interface.outputs)
        )
        for socket in fitting:
            if socket not in found.values():
                found[name] = socket
                break
    return found


def _scene(
    notes: Notes, settings: Sequence[Setting], findings: Findings
) -> tuple[Scene | None, dict[str, Mapping[str, Any]]]:
    if not notes.scene:
        for setting in settings:
            findings.wrong(f"--set scene.{setting.name}", "a scene", "a parameter of a unit: the SSP has no scene")
        return None, {}
    declared = variables(Scene)
    units = {v.name: v.quantity.unit for v in declared}
    given = {n: Given(value=value, unit=units.get(n, ""), source="") for n, value in notes.scene.items()}
    resolved = resolve("scene", declared, given=given, settings=settings)
    problems = [*resolved.problems]
    problems += [Problem(resolved.path(n), "no value", "a number") for n in units if n not in resolved.values]
    if problems:
        findings.problems += problems
        return None, {}
    set_here = {resolved.path(s.name) for s in settings}  # the notes tell where the others come from
    sources = {path: source for path, source in resolved.sources.items() if path in set_here}
    return Scene(**resolved.values), sources
