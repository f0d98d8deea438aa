"""Reading a system from an SSP file of any maker, SSP 1.0 or 2.0, also from those that `writer` wrote.

Systems in systems become one: `inner` in the system `outer` is the unit `outer_inner`, and connections through
connectors of systems lead from unit to unit. Parameter values of bindings further out replace those further in, later
ones earlier ones. Inputs that nothing drives keep their start values. What cannot be run as it stands is refused with
its file and line, all of it at once; `lenient` turns breaches of the standard whose meaning is clear into remarks.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, Final, TypeAlias

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, listed, refuse
from components.interfaces.record import variables
from components.interfaces.socket import Socket
from components.interfaces.sockets import SOCKETS
from fmus.toolchain.door import reading
from fmus.toolchain.file_names import is_file_name
from fmus.toolchain.limits import LONGEST_UNIT_NAME
from orchestrator.scenario.driven_inputs import with_table
from orchestrator.scenario.interface_choice import interface_choice
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import UNCHANGED, Options
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.scenario.table_file import read_table
from orchestrator.ssp.annotation import NO_ANNOTATION, ScenarioAnnotation, acting_through_step, read_annotation
from orchestrator.ssp.archive import (
    VALID_SSP,
    Document,
    Findings,
    alternatives,
    open_package,
    read_document,
    resolve_uri,
)
from orchestrator.ssp.assembly import Assembly
from orchestrator.ssp.connection_graph import ConnectionGraph
from orchestrator.ssp.default_experiment import read_experiment
from orchestrator.ssp.parameter_values import gather_values
from orchestrator.ssp.set_values import ValueSources, held_values, with_own_lengths, with_values
from orchestrator.ssp.ssp_units import SspUnit, open_units
from orchestrator.ssp.structure import read_structure
from orchestrator.ssp.system_elements import SspSystem
from orchestrator.ssp.vocabulary import DESCRIPTION_FILE, SSD, Attribute, Tag
from orchestrator.ssp.xml import qualified
from orchestrator.stepping.observation import observed
from orchestrator.stepping.schedule import open_dependencies_close_a_loop
from orchestrator.system.experiment import Algorithm, Scenario, algorithm_named
from orchestrator.system.files import Given
from orchestrator.system.remarks import enumeration_remarks
from orchestrator.system.scene import Scene
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

_LISTED_INPUTS: Final = 12
"""The inputs that a remark lists."""

OPEN_LOOP: Final = (
    "units that feed each other leave open what their outputs depend on: values are exchanged one step late, as"
    " with --algorithm jacobi; --algorithm and --solve-loops change it"
)

SettingsByUnit: TypeAlias = Mapping[str, Sequence[Setting]]
"""What a person sets, by unit; `scene` stands for the scene."""


def read(path: Path, settings: SettingsByUnit | None = None, options: Options = UNCHANGED) -> Scenario:
    """Read the system and the experiment in an `.ssp` file, with a person's changes.

    Args:
        path: The file.
        settings: Parameter values that replace those of the file.
        options: The changes to the experiment, and how the units run: their processes besides those that the file has.

    Raises:
        RequestError: The system cannot be run as it stands; all its problems.
    """
    with reading(str(path), VALID_SSP):
        return _read(path, settings or {}, options)


def _read(path: Path, settings: SettingsByUnit, options: Options) -> Scenario:
    findings = Findings(lenient=options.lenient)
    document, root = _opened(path, findings)
    annotation = read_annotation(document)
    known = annotation or NO_ANNOTATION
    ssp_units = open_units(root, findings, interface_choice(options.interface), ours=annotation is not None)
    suggested = {unit.name: unit.source.suggested for unit in ssp_units.values()}
    experiment = read_experiment(document, annotation, options, suggested)
    units, assembly, sources = _units(root, ssp_units, findings, settings)
    units = acting_through_step(units, known, findings)
    units = findings.attempt(lambda: _in_processes(units, known, options)) or units
    of_annotation: dict[str, Any] = findings.attempt(lambda: known.held_values(units)) or {}
    held, of_inputs = held_values(ssp_units.values(), settings, assembly, of_annotation)
    scene, scene_sources = _scene(known, settings.get("scene", ()), findings)
    system = _system(units, assembly, held, annotation, _steps(annotation, ssp_units, experiment.step))
    if system is None or findings.problems:
        raise findings.refusal()
    system = _following_table(system, document, known, options)
    given = {*known.held, *(system.table.paths if system.table else ())}
    findings.remarks += [*_undriven(assembly, given), *enumeration_remarks(system)]
    late = annotation is None and open_dependencies_close_a_loop(system)
    if late:
        findings.remarks.append(OPEN_LOOP)
    name, title = _name_and_title(document, path, ours=annotation is not None)
    return Scenario(
        name=name,
        title=title,
        system=observed(system, known.record),
        scene=scene,
        h=experiment.step,
        until=experiment.until,
        start=experiment.start,
        tolerance=known.tolerance,
        sources={**sources, **of_inputs, **known.sources, **scene_sources},
        record=known.record,
        algorithm=Algorithm.JACOBI if late else algorithm_named(known.algorithm),
        solve_loops=known.solve_loops,
        end_off_road=known.end_off_road,
        remarks=(*dict.fromkeys(findings.remarks), *experiment.remarks),
    )


def _in_processes(
    units: Mapping[str, UnitSource], known: ScenarioAnnotation, options: Options
) -> dict[str, UnitSource]:
    """The units in the processes that a person requests for them, or else has requested for the run in the file."""
    if options.in_process is True:
        return isolated(units, options.isolate, in_process=True)
    here = options.in_process or ()
    requests = [f"{name}:{seconds}" for name, seconds in known.isolated.items() if name not in here]
    return isolated(units, [*requests, *options.isolate], in_process=[*known.in_process, *here])


def _system(
    units: Mapping[str, UnitSource],
    assembly: Assembly,
    held: Mapping[str, Any],
    annotation: ScenarioAnnotation | None,
    steps: Mapping[str, Fraction],
) -> System | None:
    """The system; None where the findings say, with the places in the SSP, what is wrong with it."""
    try:
        return System(
            units=units,
            wiring=assembly.wiring,
            unset=assembly.unset,
            held=held,
            sockets=_sockets(annotation, units),
            transformations=assembly.transformations,
            unconverted=frozenset(assembly.unconverted),
            steps=steps,
            allow_nonfinite=(annotation or NO_ANNOTATION).allow_nonfinite,
        )
    except RequestError as error:
        assembly.findings.problems += [assembly.placed(p) for p in error.problems]
        return None


def _following_table(system: System, document: Document, annotation: ScenarioAnnotation, options: Options) -> System:
    """The system whose inputs follow the table of a person or of our annotation, if there is one."""
    if options.input is not None:
        table, hold = read_table(Path(options.input)), options.input_hold
    else:
        where = f"{document.package.where}, {annotation.table}"
        path = None if annotation.table is None else resolve_uri(document, annotation.table, where)
        if path is None:
            return system
        table, hold = read_table(path, where), annotation.table_holds
    following, remarks = with_table(system, table, hold=hold)
    document.findings.remarks.extend(remarks)
    return following


def _undriven(assembly: Assembly, given: Container[str]) -> Iterator[str]:
    """One remark on the inputs that nothing drives or sets, but for those that are `given`."""
    undriven = [str(one) for one in assembly.undriven if one.path not in given]
    if undriven:
        yield f"inputs that nothing drives keep their start values: {listed(undriven, _LISTED_INPUTS, 'others')}"


def _opened(path: Path, findings: Findings) -> tuple[Document, SspSystem]:
    """The main description of an SSP, and its outermost system. Raises `RequestError`."""
    package = open_package(path, str(path), findings)
    file = package.folder / DESCRIPTION_FILE
    if not file.is_file():
        is_fmu = (package.folder / "modelDescription.xml").is_file()
        options = alternatives(f"--{socket}" for socket in SOCKETS)
        remedy = f"It is an FMU: give it with {options}." if is_fmu else ""
        raise refuse(str(path), f"an archive without {DESCRIPTION_FILE}", VALID_SSP, remedy)
    document = read_document(package, file)
    root = None if document is None else read_structure(document)
    if document is None or root is None:
        raise findings.refusal()
    return document, root


def _name_and_title(document: Document, path: Path, *, ours: bool) -> tuple[str, str]:
    """The name of the scenario, which becomes that of a folder, and its title."""
    name = document.root.get(Attribute.NAME, "")
    title = document.root.find(qualified(SSD, Tag.SYSTEM)).get(Attribute.DESCRIPTION) or ("" if ours else name)
    return name if ours and is_file_name(name, LONGEST_UNIT_NAME) else _plain_name(name or path.stem), title


def _plain_name(name: str) -> str:
    plain = re.sub(r"[^\w-]+", "_", name).strip("_").encode()[:LONGEST_UNIT_NAME]
    return plain.decode(errors="ignore") or "system"


def _units(
    root: SspSystem, ssp_units: dict[tuple[str, ...], SspUnit], findings: Findings, settings: SettingsByUnit
) -> tuple[dict[str, UnitSource], Assembly, ValueSources]:
    """All units with their parameter values, how they are connected, and where the values come from."""
    values = gather_values(
        root, lambda component, name: component.path in ssp_units and ssp_units[component.path].has(name)
    )
    assembly = Assembly(findings, values, ConnectionGraph(root, ssp_units, findings))
    for path, unit in ssp_units.items():
        ssp_units[path] = with_own_lengths(unit, settings.get(unit.name, ()), assembly)
    units: dict[str, UnitSource] = {}
    sources: ValueSources = {}
    for unit in ssp_units.values():
        units[unit.name], of_unit = with_values(unit, settings.get(unit.name, ()), assembly)
        sources |= of_unit
        _refuse_other_values(unit, assembly)
    for unit in ssp_units.values():
        assembly.connect(unit)
    for name in settings.keys() - units.keys() - {"scene"}:
        if settings[name]:
            where = f"--set {name}.{settings[name][0].name}"
            findings.add_problem(where, f"the unknown unit `{name}`", choices(units), did_you_mean(name, units))
    return units, assembly, sources


def _refuse_other_values(unit: SspUnit, assembly: Assembly) -> None:
    """Refuse values of variables that cannot be set."""
    for name, value in assembly.values.variables.get(unit.component.path, {}).items():
        if unit.settable(name) is None:
            found = f"a value of `{unit.name}.{name}`, which the unit says is not to be set"
            valid = "values of parameters, inputs and start values"
            assembly.findings.add_problem(value.step.where, found, valid)


def _steps(
    annotation: ScenarioAnnotation | None, ssp_units: Mapping[tuple[str, ...], SspUnit], macro_step: float
) -> dict[str, Fraction]:
    """The steps of units as multiples of the macro step [s], by our annotation or by that of OSP for a component."""
    if annotation is not None:
        return annotation.steps
    hints = {unit.name: unit.component.step_size for unit in ssp_units.values() if unit.component.step_size}
    ratios = {n: Fraction(hint / macro_step).limit_denominator(10_000) for n, hint in hints.items()}
    return {n: ratio for n, ratio in ratios.items() if ratio != 1}


def _sockets(annotation: ScenarioAnnotation | None, units: Mapping[str, UnitSource]) -> dict[str, Socket]:
    """The sockets that units fill, by our annotation; without it, each unit fills the first free one that it fits."""
    if annotation is not None:
        return {name: SOCKETS[socket] for name, socket in annotation.sockets.items()}
    filled: dict[str, Socket] = {}
    for name, source in units.items():
        interface = source.interface
        fitting = (s for s in SOCKETS.values() if not s.problems(name, interface.inputs, interface.outputs))
        if (free := next((s for s in fitting if s not in filled.values()), None)) is not None:
            filled[name] = free
    return filled


def _scene(
    annotation: ScenarioAnnotation, settings: Sequence[Setting], findings: Findings
) -> tuple[Scene | None, ValueSources]:
    """The scene of our annotation with a person's settings, and where these come from."""
    if not annotation.scene:
        for setting in settings:
            valid = "a parameter of a unit: the SSP has no scene"
            findings.add_problem(f"--set scene.{setting.name}", "a scene", valid)
        return None, {}
    declared = variables(Scene)
    units = {v.name: v.quantity.unit for v in declared}
    given = {n: Given(value=value, unit=units.get(n, ""), source="") for n, value in annotation.scene.items()}
    none = {"y_third": parameter_set("scene")["y_third"]}  # files of before know of no third lane
    resolved = resolve("scene", declared, none, given, settings)
    problems = [*resolved.problems]
    problems += [Problem(resolved.path(n), "no value", "a number") for n in units if n not in resolved.values]
    if problems:
        findings.problems += problems
        return None, {}
    set_here = {resolved.path(s.name) for s in settings}  # the annotation tells where the others come from
    sources = {path: source for path, source in resolved.sources.items() if path in set_here}
    return Scene(**resolved.values), sources
