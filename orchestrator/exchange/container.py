"""A whole system as one FMU, with its FMUs inside: a container, made by the FMU manipulation toolbox.

The container steps the FMUs itself, in C and without Python. `sequential` steps one FMU after another, each with the
latest outputs of those before it; in the order of our schedule this equals our schedule, without hidden delay. Outputs
keep their values until their unit steps again: at t_k the container's outputs of plant and traffic are those at t_k,
while those of a controller are the ones that it computed at t_{k-1}. `jacobi` sets all inputs and then steps all FMUs,
which delays every connection by a step.

Outputs and parameters have our names (`plant.state.x`, `plant.m`); held inputs become inputs with their value as start
value. Enumerations become integers in a container, and it gives no access to its state.
"""

from __future__ import annotations

import hashlib
import logging
import re
import shutil
import uuid
import zipfile
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, Final

import numpy as np
from fmu_manipulation_toolbox.container import (  # pyright: ignore[reportMissingTypeStubs]
    FMUContainer,
    FMUContainerError,
)
from fmu_manipulation_toolbox.container.rules import ContainerPort  # pyright: ignore[reportMissingTypeStubs]
from lxml import etree

from components.interfaces.conversion import IDENTITY
from components.interfaces.problem import Problem, raise_if_any, refuse
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from fmus.toolchain.archives import write_archive
from fmus.toolchain.scratch import scratch_folder
from fmus.toolchain.version import Version
from orchestrator.exchange.container_texts import configure, describe_texts, start_texts, text_problems
from orchestrator.ssp.element_names import connected_names, element_names, is_fmi2
from orchestrator.ssp.xml import has_unit, literal, unit_definitions
from orchestrator.stepping.schedule import follows_inputs, schedule
from orchestrator.system.connection import Connection
from orchestrator.system.experiment import Algorithm, Scenario
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

_JACOBI: Final = "Export it with --algorithm jacobi."


def write(scenario: Scenario, path: Path) -> None:
    """Write a scenario's system as one FMU that steps as its algorithm does; equal systems give equal bytes.

    Args:
        scenario: The system, all units of which are FMUs of one version.
        path: The file, which is replaced if it exists.

    Raises:
        RequestError: A container cannot do what the system asks for.
    """
    system, algorithm = scenario.system, scenario.algorithm
    raise_if_any(_problems(system, algorithm))
    names = order(system, algorithm)
    with scratch_folder("container") as folder, logged_errors() as errors:
        try:
            container = _container(scenario, Path(folder), names)
            container.make_fmu("made.fmu", step_size=scenario.h, sequential=algorithm is Algorithm.SEQUENTIAL)
        except FMUContainerError as error:
            errors.append(str(error.reason))
        if errors:
            raise refuse(scenario.name, "; ".join(errors), "a system that the FMU manipulation toolbox puts together")
        _repack(Path(folder) / "made.fmu", path, scenario)


def order(system: System, algorithm: Algorithm) -> list[str]:
    """Order the units as a container initialises and steps them.

    A unit that steps late reads its sources as they were before the step: it precedes those that are late too.

    Args:
        system: The system.
        algorithm: How the units exchange data.

    Returns:
        The names of the units.

    Raises:
        RequestError: Late units read each other, which no order of single steps can do.
    """
    planned = schedule(system, algorithm)
    if algorithm is Algorithm.JACOBI:
        return list(planned.order)
    late = [name for name in planned.order if name not in planned.early]
    readers = {n: [c.unit for c in system.connections_from(n) if c.unit not in {*planned.early, n}] for n in late}
    try:
        return [*(n for n in planned.order if n in planned.early), *TopologicalSorter(readers).static_order()]
    except CycleError as error:
        units = ", ".join(dict.fromkeys(error.args[1]))
        raise refuse(
            units, "units that read each other at the same instant", "a container steps one after another", _JACOBI
        ) from error


def _problems(system: System, algorithm: Algorithm) -> Iterator[Problem]:
    if algorithm is Algorithm.CLOCKED:
        yield Problem("algorithm", "`clocked`, for which a container has no Event Mode", "sequential, jacobi")
    for name, source in system.units.items():
        if (problem := source.foreign_problem(name)) is not None:
            yield problem
    versions = {n: s.describe().version for n, s in system.units.items() if s.foreign_problem(n) is None}
    for name in [n for n, version in versions.items() if version is Version.FMI1]:
        yield Problem(f"unit `{name}`", "an FMU of FMI 1.0", "FMI 2.0 or 3.0, which a container holds")
    if len(set(versions.values())) > 1:
        found = ", ".join(f"{name} FMI {version}.0" for name, version in versions.items())
        yield Problem("FMI versions", found, "one version for all units", "Export it with --fmi 2 or --fmi 3.")
    for name, ratio in system.steps.items():
        if ratio != 1:
            yield Problem(f"step of `{name}`", f"{ratio} macro steps", "1: a container steps all units alike")
    yield from text_problems(system)
    following = {name: follows_inputs(source.interface) for name, source in system.units.items()}
    for wire in system.connections:
        yield from _wire_problems(system, wire)
        if algorithm is Algorithm.SEQUENTIAL and wire.output in following[wire.source]:
            found = "an output that follows its unit's inputs at the same instant"
            yield Problem(str(wire), found, "outputs that show by stepping, or that no unit reads", _JACOBI)


def _wire_problems(system: System, wire: Connection) -> Iterator[Problem]:
    if wire.conversion != IDENTITY:
        yield Problem(str(wire), "a conversion", "equal units: a container passes values on as they are")
    if not is_fmi2(system) and (wire.output_element or wire.input_element):
        yield Problem(str(wire), "a single element of an array", "whole arrays in FMI 3.0", "Export it with --fmi 2.")


@contextmanager
def logged_errors(level: int = logging.ERROR) -> Generator[list[str]]:
    """Gather the errors that the toolbox logs, or all messages from a level on, and suppress the rest of its log."""
    log = logging.getLogger("fmu_manipulation_toolbox")
    errors: list[str] = []
    handler = logging.Handler(level)
    handler.emit = lambda record: errors.append(record.getMessage())
    before, log.propagate = log.propagate, False
    log.addHandler(handler)
    try:
        yield errors
    finally:
        log.removeHandler(handler)
        log.propagate = before


def _container(scenario: Scenario, folder: Path, names: list[str]) -> Any:
    """Describe the system to the toolbox: FMUs, links, outputs, parameters and held inputs."""
    system, old = scenario.system, is_fmi2(scenario.system)
    identifier = re.sub(r"\W", "_", f"_{scenario.name}" if scenario.name[:1].isdigit() else scenario.name)
    container: Any = FMUContainer(identifier, folder, fmi_version=2 if old else 3)
    container.start_time, container.stop_time = scenario.start, scenario.until
    for name in names:
        _copy(system.units[name], folder / f"{name}.fmu")
        container.get_fmu(f"{name}.fmu")
    for wire in system.connections:
        for start, end in connected_names(system, wire, flat=old):
            container.add_link(f"{wire.source}.fmu", start, f"{wire.unit}.fmu", end)
    for name, source in system.units.items():
        for variable in source.interface.outputs:
            for element in element_names(source, variable.name, "outputs", flat=old):
                container.add_output(f"{name}.fmu", element, f"{name}.{element}")
        _expose(container, system, name, "parameters", source.parameters)
        _expose(container, system, name, "inputs", system.held_by(name))
    configure(container, ContainerPort, system)
    return container


def _copy(source: UnitSource, path: Path) -> None:
    """Copy an FMU for the toolbox, without its clocks: they tick in Event Mode only, and a container has none."""
    file = source.describe().file
    assert file is not None  # noqa: S101 - a unit without a file has been refused
    if not source.interface.clocks:
        shutil.copy(file, path)
        return
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.infolist():
            content = old.read(entry)
            if entry.filename == "modelDescription.xml":
                content = _without_clocks(content)
            new.writestr(entry, content)


def _without_clocks(content: bytes) -> bytes:
    """The model description without clocks, and without Event Mode."""
    root: Any = etree.fromstring(content)
    for clock in root.findall("ModelVariables/Clock"):
        clock.getparent().remove(clock)
    for variable in root.xpath("ModelVariables/*[@clocks]"):
        del variable.attrib["clocks"]
    root.find("CoSimulation").attrib.pop("hasEventMode", None)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8")


def _expose(container: Any, system: System, name: str, role: str, values: Mapping[str, Any]) -> None:
    """Make parameters or held inputs of a unit inputs of the container, each with its value as start value."""
    source, old = system.units[name], is_fmi2(system)
    structural = set(source.structural)
    variables: list[Variable] = [v for v in getattr(source.interface, role) if role == "parameters" or v.name in values]
    for variable in variables:
        if variable.name in structural:
            continue
        given = np.ravel(values[variable.name]).tolist() if variable.name in values else []
        text = variable.quantity.type is Type.STRING
        texts = ["_" if text else _text(x, variable.quantity) for x in given]  # `configure` puts in the texts
        elements = element_names(source, variable.name, role, flat=old)
        for i, element in enumerate(elements):
            if role == "inputs" and old and system.driver(name, variable.name, i) is not None:
                continue  # only other elements of the array hold a value
            container.add_input(f"{name}.{element}", f"{name}.fmu", element)
            if texts:
                container.add_start_value(f"{name}.fmu", element, texts[i] if old else " ".join(texts))


def _text(value: Any, q: Quantity) -> str:
    return str(int(value)) if q.type is Type.ENUMERATION else literal(value, q)


def _repack(source: Path, path: Path, scenario: Scenario) -> None:
    """Write the container with a complete description that does not depend on when it is made."""
    with zipfile.ZipFile(source) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    configuration = files["resources/container.txt"].decode()
    files["resources/container.txt"] = _with_all_starts(configuration, scenario.system).encode()
    files["modelDescription.xml"] = _description(files, scenario)
    write_archive(path, files)


def _with_all_starts(configuration: str, system: System) -> str:
    """The toolbox's configuration with all start values of Boolean arrays, of which it writes only the first."""
    lines, unit = configuration.split("\n"), ""
    for i, line in enumerate(lines):
        if line.startswith("#"):
            heading = re.match(r"# Start values of (.+)\.fmu - boolean", line)
            unit = heading[1] if heading else ""
        elif unit and len(words := line.split()) == len(("reference", "size", "reset", "value")) and int(words[1]) > 1:
            source = system.units[unit]
            name = next(n for n, references in source.references.items() if references == [int(words[0])])
            values = {**source.parameters, **system.held_by(unit)}[name]
            lines[i] = " ".join([*words[:3], *(str(int(v)) for v in np.ravel(values))])
    return "\n".join(lines)


def _description(files: Mapping[str, bytes], scenario: Scenario) -> bytes:
    """The toolbox's model description with units and a fixed token, without its author and its duplicate variables."""
    root: Any = etree.fromstring(files["modelDescription.xml"])
    variables = root.find("ModelVariables")
    for local in variables.xpath("*[@causality='local']"):  # a duplicate of each link
        variables.remove(local)
    positions = {v.get("name"): str(i) for i, v in enumerate(variables, start=1)}
    outputs = [v.get("name") for v in variables if v.get("causality") == "output"]
    for section in root.xpath("ModelStructure/Outputs | ModelStructure/InitialUnknowns"):
        for unknown, name in zip(section, outputs, strict=True):
            unknown.set("index", positions[name])
    _complete(root, variables, _quantities(scenario.system))
    describe_texts(variables, start_texts(scenario.system))
    for attribute in ("author", "copyright", "license", "generationDateAndTime"):
        root.attrib.pop(attribute, None)
    root.set("modelName", scenario.name)
    root.set("description", scenario.title or f"the system `{scenario.name}` in one FMU")
    content = b"".join(files[name] for name in sorted(files) if name != "modelDescription.xml")
    token = "guid" if is_fmi2(scenario.system) else "instantiationToken"
    root.set(token, str(uuid.uuid5(uuid.NAMESPACE_OID, f"{scenario.name} {hashlib.sha256(content).hexdigest()}")))
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _complete(root: Any, variables: Any, quantities: Mapping[str, Quantity]) -> None:
    """Add the units of measurement, and write start values of arrays in the form that FMI requires."""
    for variable in variables:
        quantity = quantities.get(str(variable.get("name")))
        if quantity is not None and has_unit(quantity):
            (variable[0] if variable.tag == "ScalarVariable" else variable).set("unit", quantity.unit)
        start = None if variable.tag in {"String", "Binary"} else variable.find("Start")
        if start is not None:
            variable.set("start", start.get("value"))
            variable.remove(start)
    definitions = etree.Element("UnitDefinitions")
    for name, base in unit_definitions(list(quantities.values())).items():
        etree.SubElement(etree.SubElement(definitions, "Unit", name=name), "BaseUnit", base)
    if len(definitions):
        root.find("CoSimulation").addnext(definitions)


def _quantities(system: System) -> dict[str, Quantity]:
    """The quantity of every variable of the container, by its name."""
    old = is_fmi2(system)
    return {
        f"{name}.{element}": variable.quantity
        for name, source in system.units.items()
        for role in ("inputs", "outputs", "parameters")
        for variable in getattr(source.interface, role)
        for element in element_names(source, variable.name, role, flat=old)
    }
