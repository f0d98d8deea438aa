"""The components of an SSP as units: opened, named, and compared with the connectors that the SSP lists for them."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Final

from components.interfaces.conversion import IDENTITY, unit_conversion
from components.interfaces.problem import RequestError, choices, did_you_mean, refuse
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.socket import describe
from components.interfaces.sockets import SOCKETS
from fmus.reading.archive import InterfaceType
from fmus.toolchain.door import reading
from fmus.toolchain.limits import LONGEST_UNIT_NAME
from fmus.unit_interface import Interface
from orchestrator.mapping.mapped import mapped
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.scenario.catalogue import block_named
from orchestrator.scenario.interface_choice import NO_CHOICE, InterfaceChoice
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connections import Connector
from orchestrator.ssp.system_elements import Component, SspSystem
from orchestrator.ssp.types import DeclaredType, items_of
from orchestrator.ssp.vocabulary import ANY_IMPLEMENTATION, BLOCK_SOURCE, MAPPING_SUFFIX, ConnectorKind
from orchestrator.system.named_variables import UnitVariable, variables_of_role
from orchestrator.system.source import Fmu, InProcess, UnitSource

_KINDS: Final = {
    "inputs": (ConnectorKind.INPUT,),
    "outputs": (ConnectorKind.OUTPUT, ConnectorKind.LOCAL, ConnectorKind.CONSTANT),
    "parameters": (ConnectorKind.PARAMETER, ConnectorKind.STRUCTURAL_PARAMETER),
    "clocks": (ConnectorKind.INPUT, ConnectorKind.OUTPUT),
}
"""The kinds that a connector may have, by the role of its variable; a message names the first."""
_NOT_EXCHANGED: Final = (ConnectorKind.LOCAL, ConnectorKind.CALCULATED_PARAMETER, ConnectorKind.CONSTANT)
_OURS: Final = re.compile(rf"[\w-]{{1,{LONGEST_UNIT_NAME}}}")
"""The names of units in a file of this program, which become those of files."""
_MOST_CHOICES: Final = 30
"""The most names that a message lists as valid."""


@dataclass(frozen=True)
class SspUnit:
    """One component as a unit of the system.

    Attributes:
        name: The name of the unit.
        component: The component in the SSP.
        source: What the unit is made from.
        variables: Inputs, outputs, parameters and clocks by name, also by the names of elements and by aliases.
        initials: Outputs and local variables whose start value may be set.
    """

    name: str
    component: Component
    source: UnitSource
    variables: Mapping[str, UnitVariable]
    initials: Mapping[str, UnitVariable]

    @staticmethod
    def of(name: str, component: Component, source: UnitSource) -> SspUnit:
        """The unit with all variables of its source."""
        return SspUnit(name, component, source, _variables(source), dict(variables_of_role(source, "initials")))

    def declared(self, variable: Variable) -> DeclaredType:
        """The type of a variable; its connector may give the unit of measurement that the source leaves open."""
        q = variable.quantity
        connector = self.component.connectors.get(variable.name)
        unit, base = (q.unit, q.base) if q.type.is_float else (None, None)
        if q.type.is_float and not q.unit:
            unit, base = (None, None) if connector is None else (connector.declared.unit, connector.declared.base)
        return DeclaredType(str(q.type), unit, base, items_of(q.enumeration) or None, variable.shape)

    def opened_with(self, source: UnitSource, findings: Findings) -> SspUnit:
        """The unit with a source of other lengths of arrays; unchanged where the findings say that they do not fit."""
        if opened(source, self.component, findings) is None:
            return self
        return SspUnit.of(self.name, self.component, source)

    def settable(self, name: str) -> UnitVariable | None:
        """The parameter, the input, or another variable with a start value that a parameter set may give."""
        variable = self.variables.get(name)
        is_given = variable is not None and variable.role in ("inputs", "parameters")
        return variable if is_given else self.initials.get(name)

    @property
    def structural(self) -> tuple[str, ...]:
        """The parameters that the lengths of arrays depend on."""
        return self.source.structural

    def has(self, name: str) -> bool:
        """Whether there is a variable of a name, also one of a kind that no master exchanges."""
        return name in self.variables or self.source.declares(name)


def open_units(
    root: SspSystem, findings: Findings, choice: InterfaceChoice = NO_CHOICE, *, ours: bool
) -> dict[tuple[str, ...], SspUnit]:
    """All components as units, by the path of the component; without those that the findings refuse.

    A unit has the name of its component. In a system of another maker, `inner` in the system `outer` is the unit
    `outer_inner`, and each character that is no letter, digit or underscore becomes an underscore: a dot would end the
    unit's name in the path of a signal.

    Args:
        root: The outermost system.
        findings: Where problems and remarks are gathered.
        choice: The interface types that a person chooses.
        ours: Whether this program wrote the SSP.
    """
    units: dict[tuple[str, ...], SspUnit] = {}
    taken: set[str] = set()
    lenient = findings.lenient or ours

    places = {e.file: e.file_where for e in root.walk() if isinstance(e, Component) and e.file is not None}

    @cache
    def fmu(file: Path, kind: InterfaceType | None) -> Fmu:
        """A file is read once, however many components are made from it."""
        return Fmu(file, {}, lenient, interface_type=kind, where=places[file])

    for component in (e for e in root.walk() if isinstance(e, Component)):
        name = component.name
        if not (ours and _OURS.fullmatch(name)):
            name = _unused("_".join(re.sub(r"\W", "_", n) for n in component.path)[:LONGEST_UNIT_NAME], taken)
        taken.add(name)
        kind = choice.of(name, _implementation(component, findings))
        source = _source(component, findings, partial(fmu, kind=kind), kind, lenient=lenient)
        if source is not None:
            units[component.path] = SspUnit.of(name, component, source)
    findings.problems += choice.problems(unit.name for unit in units.values() if unit.component.file is not None)
    renamed = [f"`{unit.name}` is `{'.'.join(path)}`" for path, unit in units.items() if ".".join(path) != unit.name]
    if renamed:
        findings.remarks.append(f"units: {', '.join(renamed)}")
    return units


def _unused(name: str, taken: set[str]) -> str:
    """The name, with a number where it is taken."""
    unused, n = name or "unit", 1
    while unused in taken:
        n += 1
        unused = f"{name}_{n}"
    return unused


def _source(
    component: Component,
    findings: Findings,
    fmu: Callable[[Path], Fmu],
    kind: InterfaceType | None,
    *,
    lenient: bool,
) -> UnitSource | None:
    if component.block:
        return findings.attempt(
            lambda: InProcess(block_named(component.block.removeprefix(BLOCK_SOURCE), component.where), {})
        )
    if component.file is None:
        return None  # the structure has a problem for it already
    if component.file.suffix == MAPPING_SUFFIX:
        return findings.attempt(partial(_mapped, component, component.file, kind, lenient=lenient))
    source = fmu(component.file)
    if opened(source, component, findings) is None:
        return None
    findings.remarks += [f"{component.file.name}: {remark}" for remark in source.archive.remarks]
    return source


def _implementation(component: Component, findings: Findings) -> InterfaceType | None:
    """The interface type that the SSP asks for; None where it leaves that open."""
    if component.implementation in (*InterfaceType,):
        return InterfaceType(component.implementation)
    if component.implementation != ANY_IMPLEMENTATION:
        valid = choices([*InterfaceType, ANY_IMPLEMENTATION])
        findings.add_problem(component.where, f"the implementation `{component.implementation}`", valid)
    return None


def opened(source: UnitSource, component: Component, findings: Findings) -> Interface | None:
    """The interface of a component; None where the findings say, with its place in the SSP, why it has none."""
    file = component.file or Path()
    where = f"{component.where}, {file.name}"

    def read() -> Interface:
        with reading(where, "an FMU"), placed(component.file_where, where):
            return source.interface

    return findings.attempt(read)


def _mapped(component: Component, file: Path, kind: InterfaceType | None, *, lenient: bool) -> UnitSource:
    """The FMU that a mapping file names, behind the socket that it names. Raises `RequestError`."""
    where = f"{component.where}, {file.name}"
    with reading(where, "a mapping file and its FMU"), placed(str(file), where):
        mapping = read_mapping(file)
        if mapping.fmu is None or mapping.socket is None or mapping.fmu.resolve().parent != file.parent.resolve():
            raise refuse(f"{file.name}: fmu", f"`{mapping.fmu or ''}`", "the name of an FMU beside it in the archive")
        name = f"{component.where}, {mapping.fmu.name}"
        fmu = Fmu(mapping.fmu, {}, lenient, interface_type=kind, where=name)
        return mapped(component.name, SOCKETS[mapping.socket], fmu, mapping)


@contextmanager
def placed(file: str, where: str) -> Generator[None]:
    """Let refusals of a file name the component that it is used for."""
    try:
        yield
    except RequestError as error:
        problems = [replace(p, where=p.where.replace(file, where)) if file else p for p in error.problems]
        raise RequestError(problems) from error


def _variables(source: UnitSource) -> dict[str, UnitVariable]:
    """Inputs, outputs and parameters by name, by element and by alias, and the clocks."""
    named = {n: v for role in ("inputs", "outputs", "parameters") for n, v in variables_of_role(source, role)}
    aliases = source.interface.aliases.items()
    aliased = {alias: named[name] for alias, name in aliases if name in named and alias not in named}
    clocks = {
        clock.name: UnitVariable("clocks", Variable(clock.name, Quantity("", "a clock", Type.BOOLEAN)))
        for clock in source.interface.clocks
    }
    return named | aliased | clocks


def compare(unit: SspUnit, findings: Findings) -> None:
    """Find what of a unit's connectors does not agree with its variables.

    Args:
        unit: The unit, whose arrays have the lengths that the SSP gives them.
        findings: Where problems and remarks are gathered.
    """
    for connector in unit.component.connectors.values():
        _compare(unit, connector, findings)


def _compare(unit: SspUnit, connector: Connector, findings: Findings) -> None:
    """Find what of a connector does not agree with the variable of its name."""
    target, model = unit.variables.get(connector.name), unit.source.interface.kind
    if target is None:
        if unit.has(connector.name) and connector.kind in _NOT_EXCHANGED:
            return
        names = [n for n, v in unit.variables.items() if not v.index]
        valid = choices(names) if len(names) <= _MOST_CHOICES else f"one of its {len(names)} variables"
        found = f"the connector `{connector.name}`, of which `{model}` has no variable"
        findings.add_breach(connector.where, found, valid, did_you_mean(connector.name, names))
        return
    if connector.kind not in _KINDS[target.role]:
        found = f"the kind `{connector.kind}` of `{connector.name}`"
        findings.add_breach(connector.where, found, f"`{_KINDS[target.role][0]}`, as `{model}` says")
    q, declared = target.variable.quantity, connector.declared
    if not declared.fits(q.type) or (declared.shape and declared.shape != target.shape):
        shape = declared.shape or ()
        found = f"`{connector.name}` of type {describe(Quantity('1', '', declared.type or q.type, shape))}"
        findings.add_breach(connector.where, found, f"{describe(q)}, as `{model}` says")
    elif (
        declared.quantity is not None
        and q.unit
        and q.type.is_float
        and unit_conversion(declared.quantity, q) != IDENTITY
    ):
        found = f"`{connector.name}` in `{declared.unit}`"
        findings.add_breach(connector.where, found, f"`{q.unit}`, as `{model}` says")
