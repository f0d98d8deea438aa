"""The components of an SSP as units: opened, named, and compared with the connectors that the SSP gives them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.conversion import IDENTITY, unit_conversion
from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, refuse
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.socket import describe
from components.interfaces.sockets import SOCKETS
from fmus.unit_interface import Interface
from orchestrator.mapping.mapped import mapped
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.scenario.catalogue import block_named
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connections import Connector, Index
from orchestrator.ssp.structure import Component, Group
from orchestrator.ssp.types import Declared, items_of
from orchestrator.ssp.writer import BLOCK_SOURCE, element_names
from orchestrator.system.source import Fmu, InProcess, UnitSource

_KINDS: Final = {
    "inputs": ("input",),
    "outputs": ("output", "local", "constant"),
    "parameters": ("parameter", "structuralParameter"),
    "clocks": ("input", "output"),
}
_HIDDEN: Final = ("local", "calculatedParameter", "constant")
_MOST: Final = 30
"""Names that a list of choices still helps with."""


@dataclass(frozen=True)
class Place:
    """What a connector's name means in a unit: a variable, or one element of it."""

    role: str
    """`inputs`, `outputs`, `parameters` or `clocks`"""
    variable: Variable
    at: Index = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the array; empty for a scalar or an element."""
        return () if self.at else self.variable.shape


@dataclass(frozen=True)
class Part:
    """One component as a unit of the system."""

    name: str
    component: Component
    source: UnitSource
    places: Mapping[str, Place]
    initials: Mapping[str, Place]
    """Outputs and local variables whose start value may be set"""

    def declared(self, variable: Variable) -> Declared:
        """Unit and items of a variable; where the unit itself declares no unit of measurement, its connector may."""
        q = variable.quantity
        connector = self.component.connectors.get(variable.name)
        unit, base = (q.unit, q.base) if q.type.is_float else (None, None)
        if q.type.is_float and not q.unit:
            unit, base = (None, None) if connector is None else (connector.declared.unit, connector.declared.base)
        return Declared(str(q.type), unit, base, items_of(q.enumeration) or None, variable.shape)

    def opened_with(self, values: Mapping[str, Any], findings: Findings) -> Part:
        """The same with parameter values that decide lengths of arrays; as it was where they cannot be."""
        source = self.source.with_parameters(values)
        if opened(source, self.component, findings) is None:
            return self
        return replace(self, source=source, places=dict(_places(source)), initials=dict(_initials(source)))

    def settable(self, name: str) -> Place | None:
        """What a value of a parameter set means: a parameter, an input, or another variable with a start value."""
        found = self.places.get(name)
        return found if found is not None and found.role in ("inputs", "parameters") else self.initials.get(name)

    @property
    def structural(self) -> tuple[str, ...]:
        """Parameters that lengths of arrays depend on."""
        return self.source.structural

    def has(self, name: str) -> bool:
        """Whether there is a variable of a name, also one of a kind that no master exchanges."""
        if name in self.places:
            return True
        return self.source.declares(name)


def open_parts(root: Group, findings: Findings, *, ours: bool) -> dict[tuple[str, ...], Part]:
    """All components by their path; those that cannot be used are missing, and the findings say why.

    A unit is called like its component. In a system of another maker, `inner` in the system `outer` is the unit
    `outer_inner`, and whatever is no letter, digit or underscore becomes an underscore: a dot would end the unit's name
    in the path of a signal.
    """
    found: dict[tuple[str, ...], Part] = {}
    taken: set[str] = set()
    for component in (e for e in root.walk() if isinstance(e, Component)):
        name = component.name if ours else _free("_".join(re.sub(r"\W", "_", n) for n in component.path), taken)
        taken.add(name)
        source = _source(component, findings, lenient=findings.lenient or ours)
        if source is not None:
            part = Part(name, component, source, dict(_places(source)), dict(_initials(source)))
            found[component.path] = part
            for connector in component.connectors.values():
                _compare(part, connector, findings)
    renamed = [f"`{part.name}` is `{'.'.join(path)}`" for path, part in found.items() if ".".join(path) != part.name]
    if renamed:
        findings.remarks.append(f"units: {', '.join(renamed)}")
    return found


def _free(name: str, taken: set[str]) -> str:
    made, n = name or "unit", 1
    while made in taken:
        n += 1
        made = f"{name}_{n}"
    return made


def _source(component: Component, findings: Findings, *, lenient: bool) -> UnitSource | None:
    if component.block:
        return findings.attempt(
            lambda: InProcess(block_named(component.block.removeprefix(BLOCK_SOURCE), component.where), {})
        )
    if component.file is None:
        return None  # told already
    if component.file.suffix == ".toml":
        return findings.attempt(partial(_mapped, component.name, component.file, lenient=lenient))
    file = component.file
    source = Fmu(file, {}, lenient)
    if opened(source, component, findings) is None:
        return None
    archive = source.archive
    told = [f"{file.name}: {remark}" for remark in archive.remarks]
    findings.remarks += [remark for remark in told if remark not in findings.remarks]
    wanted = component.implementation
    has = {
        "CoSimulation": archive.description.coSimulation is not None,
        "ModelExchange": archive.description.modelExchange is not None,
    }
    if not has.get(wanted, True):
        findings.wrong(component.where, f"no {wanted} in {file.name}", choices(k for k, there in has.items() if there))
        return None
    if wanted == "ModelExchange" and has["CoSimulation"]:
        told = f"{wanted} asked for of {file.name}, which has CoSimulation too"
        findings.breach(component.where, told, "CoSimulation, which is used where there is a choice, or any")
    return source


def opened(source: UnitSource, component: Component, findings: Findings) -> Interface | None:
    """The interface of a component; None where it cannot be used: the findings say why, with its place in the SSP."""
    try:
        return source.interface
    except RequestError as error:
        file = component.file or Path()
        for p in error.problems:
            findings.wrong(p.where.replace(str(file), f"{component.where}, {file.name}"), p.found, p.valid, p.remedy)
        return None


def _mapped(name: str, file: Path, *, lenient: bool) -> UnitSource:
    """The FMU that a mapping file names, behind the socket that it names."""
    mapping = read_mapping(file)
    if mapping.fmu is None or mapping.socket is None or mapping.fmu.resolve().parent != file.parent.resolve():
        raise refuse(f"{file.name}: fmu", f"`{mapping.fmu or ''}`", "the name of an FMU beside it in the archive")
    return mapped(name, SOCKETS[mapping.socket], Fmu(mapping.fmu, {}, lenient), mapping)


def _places(source: UnitSource) -> Iterator[tuple[str, Place]]:
    for role in ("inputs", "outputs", "parameters"):
        yield from _of(source, role)
    names = {name: place for role in ("inputs", "outputs", "parameters") for name, place in _of(source, role)}
    for alias, name in source.interface.aliases.items():
        if name in names and alias not in names:
            yield alias, names[name]
    for clock in source.interface.clocks:
        yield clock.name, Place("clocks", Variable(clock.name, Quantity("", "a clock", Type.BOOLEAN)))


def _initials(source: UnitSource) -> Iterator[tuple[str, Place]]:
    return _of(source, "initials")


def _of(source: UnitSource, role: str) -> Iterator[tuple[str, Place]]:
    """The variables of a role, and the elements of arrays as the file spells them."""
    for variable in getattr(source.interface, role):
        yield variable.name, Place(role, variable)
        if not variable.shape:
            continue
        spelled = element_names(source, variable.name, role, old=True)
        names = spelled if len(spelled) == variable.size else variable.elements
        for name, index in zip(names, np.ndindex(*variable.shape), strict=True):
            yield name, Place(role, variable, tuple(i + 1 for i in index))


def _compare(part: Part, connector: Connector, findings: Findings) -> None:
    """What of a connector does not agree with the unit's variable of its name."""
    place, unit = part.places.get(connector.name), part.source.interface.kind
    if place is None:
        if part.has(connector.name) and connector.kind in _HIDDEN:
            return
        names = [n for n, p in part.places.items() if not p.at]
        valid = choices(names) if len(names) <= _MOST else f"one of its {len(names)} variables"
        told = f"the connector `{connector.name}`, of which `{unit}` has no variable"
        findings.breach(connector.where, told, valid, did_you_mean(connector.name, names))
        return
    if connector.kind not in _KINDS[place.role]:
        told = f"the kind `{connector.kind}` of `{connector.name}`"
        findings.breach(connector.where, told, f"`{_KINDS[place.role][0]}`, as `{unit}` says")
    q, said = place.variable.quantity, connector.declared
    if not said.fits(q.type) or (said.shape and said.shape != place.shape):
        shape = said.shape or ()
        told = f"`{connector.name}` of type {describe(Quantity('1', '', said.type or q.type, shape))}"
        findings.breach(connector.where, told, f"{describe(q)}, as `{unit}` says")
    elif said.quantity is not None and q.unit and q.type.is_float and unit_conversion(said.quantity, q) != IDENTITY:
        told = f"`{connector.name}` in `{said.unit}`"
        findings.breach(connector.where, told, f"`{q.unit}`, as `{unit}` says")


def problem_at(problem: Problem, lines: Mapping[str, str]) -> Problem:
    """A problem of the system with the place in the SSP that it comes from, where that is known."""
    for path in (problem.where, problem.where.partition(", ")[0]):
        if path in lines:
            return Problem(lines[path], problem.found, problem.valid, problem.remedy)
    return problem
