"""What an SSP gives to each unit: the sources of its inputs, the values that inputs hold, and parameter values."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY, Linear, Transformation, unit_conversion
from components.interfaces.problem import Problem
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connection_graph import ConnectionGraph, ResolvedConnection, is_inside
from orchestrator.ssp.conversion import composed, constant
from orchestrator.ssp.parameter_values import ParameterValue, ParameterValues
from orchestrator.ssp.ssp_units import SspUnit
from orchestrator.ssp.transformations import ConversionStep
from orchestrator.ssp.types import DeclaredType
from orchestrator.system.named_variables import ElementIndex, UnitVariable

_SHOWN_ELEMENTS: Final = 4
"""The elements of an array that a remark shows."""

_GivenValue: TypeAlias = tuple[ElementIndex, ParameterValue, tuple[ConversionStep, ...]]
"""An element, or None for the whole variable; its value; and the conversions of the value."""


@dataclass(frozen=True)
class UndrivenInput:
    """An input that nothing drives or sets, with the start value that it keeps; None for one that only it knows."""

    path: str
    start: Any

    def __str__(self) -> str:
        return self.path if self.start is None else f"{self.path} = {_short(self.start)}"


@dataclass(frozen=True)
class _UnitConnection:
    """A connection into a variable of a unit, or into one element of it."""

    index: ElementIndex
    unit: SspUnit
    output: UnitVariable
    transformation: Transformation
    where: str


@dataclass
class Assembly:
    """The system that an SSP makes of its units, as far as they are known.

    Attributes:
        findings: Where problems and remarks are gathered.
        values: The parameter values of the SSP.
        graph: The connections of the SSP.
        wiring: The outputs that drive inputs, by input, both with their unit.
        transformations: The transformations beyond unit conversions, by input.
        unconverted: The inputs without a unit conversion.
        held: The values of inputs that nothing drives, by input.
        unset: The inputs for which nobody has a value.
        undriven: The inputs that nothing drives or sets.
        outgrown: The variables whose values in the SSP are for other lengths of arrays than a person chose.
        places: The file and line of connections and values, by the path that a problem of the system has.
    """

    findings: Findings
    values: ParameterValues
    graph: ConnectionGraph
    wiring: dict[str, str] = field(default_factory=dict[str, str])
    transformations: dict[str, Transformation] = field(default_factory=dict[str, Transformation])
    unconverted: set[str] = field(default_factory=set[str])
    held: dict[str, Any] = field(default_factory=dict[str, Any])
    unset: set[str] = field(default_factory=set[str])
    undriven: list[UndrivenInput] = field(default_factory=list[UndrivenInput])
    outgrown: set[str] = field(default_factory=set[str])
    places: dict[str, str] = field(default_factory=dict[str, str])

    def connect(self, unit: SspUnit) -> None:
        """Connect all inputs of a unit; inputs and elements that nothing drives hold a value."""
        own = self._own_values(unit)
        for target in [v for v in unit.variables.values() if v.role == "inputs" and not v.index]:
            resolved = self.graph.connections_to(unit, target)
            between_units = [c for r in resolved if (c := self._unit_connection(r)) is not None]
            for connection in _merged(target.variable, between_units):
                self._add(unit, target.variable, connection)
            driven = {c.index for c in between_units}
            if None not in driven and len(driven) < math.prod(target.shape):
                given = [*own.get(target.variable.name, ()), *self._values_of_connectors(resolved)]
                self._hold(unit, target.variable, given, partly=bool(between_units))
        for name in [n for n, v in unit.variables.items() if v.role == "clocks"]:
            for clock in self.graph.connections_to(unit, unit.variables[name]):
                if clock.unit is not None and clock.output is not None:
                    self.wiring[f"{unit.name}.{name}"] = f"{clock.unit.name}.{clock.output.variable.name}"

    def parameters(self, unit: SspUnit, only: tuple[str, ...] | None = None) -> dict[str, tuple[Any, ParameterValue]]:
        """The values of a unit's parameters and start values, and their sources; connected values replace others.

        Args:
            unit: The unit.
            only: The parameters that are wanted; all of them, and all start values, if None.
        """
        given: dict[str, tuple[Any, ParameterValue]] = {}
        own = self._own_values(unit)
        for name in [n for n, v in unit.variables.items() if v.role == "parameters" and not v.index]:
            if only is not None and name not in only:
                continue
            resolved = self.graph.connections_to(unit, unit.variables[name])
            self._refuse_outputs(name, resolved)
            variable = unit.variables[name].variable
            value = self._value(unit, variable, [*own.get(variable.name, ()), *self._values_of_connectors(resolved)])
            if value is not None:
                given[name] = value
        if only is None:
            for name in [n for n, v in unit.initials.items() if not v.index]:
                variable = unit.initials[name].variable
                if (value := self._value(unit, variable, own.get(variable.name, ()))) is not None:
                    given[name] = value
        self.places |= {f"{unit.name}.{name}": value.step.where for name, (_, value) in given.items()}
        return given

    def driver(self, unit: SspUnit, target: UnitVariable) -> str | None:
        """The output that drives an input, or one of its elements; None where none does."""
        whole = f"{unit.name}.{target.variable.name}"
        if target.index is not None:
            return self.wiring.get(
                f"{unit.name}.{_element_name(target.variable, target.index)}", self.wiring.get(whole)
            )
        driven = [whole, *(f"{unit.name}.{element}" for element in target.variable.elements)]
        return next((self.wiring[path] for path in driven if path in self.wiring), None)

    def placed(self, problem: Problem) -> Problem:
        """A problem of the system with the place in the SSP that it comes from, where that is known."""
        where = self.places.get(problem.where)
        return problem if where is None else replace(problem, where=where)

    def _unit_connection(self, resolved: ResolvedConnection) -> _UnitConnection | None:
        """A connection between units; None for another, and where the findings say why no value can pass."""
        unit, output = resolved.unit, resolved.output
        if unit is None or output is None:
            return None
        total = composed(unit.declared(output.variable), resolved.steps, self.findings)
        if total is None:
            return None
        return _UnitConnection(resolved.index, unit, output, total, resolved.steps[0].where)

    def _add(self, unit: SspUnit, variable: Variable, connection: _UnitConnection) -> None:
        output, total = connection.output, connection.transformation
        target = f"{unit.name}.{_element_name(variable, connection.index)}"
        origin = f"{connection.unit.name}.{_element_name(output.variable, output.index)}"
        self.wiring[target] = origin
        problem_paths = (f"{origin} -> {target}", f"{origin} -> {target}, transformation", target)
        self.places |= dict.fromkeys(problem_paths, connection.where)
        conversion = unit_conversion(output.variable.quantity, variable.quantity)
        if isinstance(total, Linear) and conversion is not None and _is_close(total, conversion):
            return
        if isinstance(total, Linear):
            self.unconverted.add(target)
        if total != IDENTITY:
            self.transformations[target] = total

    def _hold(self, unit: SspUnit, variable: Variable, values: Sequence[_GivenValue], *, partly: bool) -> None:
        """Give an input, or those of its elements that nothing drives, the value of the SSP or of the unit."""
        path = f"{unit.name}.{variable.name}"
        given = self._value(unit, variable, values)
        if given is not None:
            self.held[path], self.places[path] = given[0], given[1].step.where
            return
        start = unit.source.interface.starts.get(variable.name)
        if start is None and not unit.component.block:
            if not partly:
                self.unset.add(path)
                self.undriven.append(UndrivenInput(path, None))
                return
            start = zeros(variable.quantity.type, variable.shape or 1)
            start = start if variable.shape else start.item()
            remark = f"elements of `{path}` that nothing drives are 0: the unit says no start value"
            self.findings.remarks.append(remark)
        if start is not None:
            self.held[path] = start.tolist() if isinstance(start, np.ndarray) else start
            if not partly:
                self.undriven.append(UndrivenInput(path, self.held[path]))

    def _refuse_outputs(self, parameter: str, resolved: Sequence[ResolvedConnection]) -> None:
        """Refuse connections from outputs to a parameter."""
        for connection in resolved:
            if connection.unit is not None and connection.output is not None:
                output = f"{connection.unit.name}.{connection.output.variable.name}"
                found = f"`{output}` for the parameter `{parameter}`"
                valid = "a value that is known before anything runs"
                self.findings.add_problem(connection.steps[-1].where, found, valid)

    def _value(
        self, unit: SspUnit, variable: Variable, values: Sequence[_GivenValue]
    ) -> tuple[Any, ParameterValue] | None:
        """The value that parameter sets give to a variable, and the last of them.

        Later values replace earlier ones. Elements that nothing gives keep their start values.
        """
        whole = np.empty(variable.shape, dtype=object)
        if (start := unit.source.interface.starts.get(variable.name)) is not None:
            whole[...] = start
        last: ParameterValue | None = None
        for index, value, steps in values:
            converted = constant(value, steps, variable, index, self.findings)
            if converted is None:
                continue
            last = value
            if index is None:
                whole[...] = _as_objects(converted, variable.shape)
            else:
                whole[tuple(i - 1 for i in index)] = converted
        if last is None:
            return None
        if missing := [index for index in _indices(variable) if whole[tuple(i - 1 for i in index)] is None]:
            names = ", ".join(_element_name(variable, index) for index in missing)
            valid = f"all elements of `{variable.name}`"
            self.findings.add_problem(last.step.where, f"no value of {names}", valid)
            return None
        return whole.tolist(), last

    def _own_values(self, unit: SspUnit) -> dict[str, list[_GivenValue]]:
        """The values that parameter sets give to the variables of a unit themselves, by variable."""
        own: dict[str, list[_GivenValue]] = {}
        for name, value in self.values.variables.get(unit.component.path, {}).items():
            if (target := unit.settable(name)) is not None:
                steps = (replace(value.step, to=unit.declared(target.variable)),)
                own.setdefault(target.variable.name, []).append((target.index, value, steps))
        return own

    def _values_of_connectors(self, resolved: Sequence[ResolvedConnection]) -> Iterator[_GivenValue]:
        """The values of connectors of systems that connections begin at; they replace those of the variable itself."""
        for end in [r for r in resolved if r.unit is None]:
            for passed in reversed(end.passed):  # bindings further out replace those further in
                value = self.values.connectors.get(passed.path)
                connector = self.graph.connector(passed.path)
                if value is not None and connector is not None:
                    picked = _picked(value, passed.index, connector.declared)
                    yield end.index, picked, (replace(value.step, to=connector.declared), *passed.steps)
                    break


def _merged(variable: Variable, connections: Sequence[_UnitConnection]) -> Sequence[_UnitConnection]:
    """One connection of a whole array in place of those of all its elements, where these connect an array alike."""
    if not variable.size or not variable.shape or len({c.index for c in connections} - {None}) != variable.size:
        return connections
    first = connections[0]
    for other in connections:
        if (other.unit.name, other.output.variable.name) != (first.unit.name, first.output.variable.name):
            return connections
        if other.transformation != first.transformation:
            return connections
        if other.output.index != other.index or other.output.variable.shape != variable.shape:
            return connections
    return [replace(first, index=None, output=replace(first.output, index=None))]


def _indices(variable: Variable) -> list[tuple[int, ...]]:
    """The indices of all elements, counted from 1; () for a scalar."""
    return [tuple(i + 1 for i in index) for index in np.ndindex(*variable.shape)]


def _element_name(variable: Variable, index: ElementIndex) -> str:
    return variable.element(index) if index else variable.name


def _short(value: Any) -> str:
    """A value for a remark; of a long array its first elements."""
    items = np.ravel(np.array(value, dtype=object)).tolist() if isinstance(value, list) else [value]
    text = ", ".join(str(item) for item in items[:_SHOWN_ELEMENTS]) + (", ..." if len(items) > _SHOWN_ELEMENTS else "")
    return f"[{text}]" if isinstance(value, list) else text


def _as_objects(value: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    array = np.empty(shape, dtype=object)
    array[...] = np.array(value, dtype=object).reshape(shape)
    return array


def _picked(value: ParameterValue, index: ElementIndex, declared: DeclaredType) -> ParameterValue:
    """The value of one element of an array connector; without a text where there is no such element."""
    if not index:
        return value
    texts = value.texts[0].split() if len(value.texts) == 1 else list(value.texts)
    shape = value.declared.shape or declared.shape or (len(texts),)
    known = is_inside(index, shape) and math.prod(shape) == len(texts)
    one = [texts[int(np.ravel_multi_index([i - 1 for i in index], shape))]] if known else []
    return replace(value, texts=tuple(one), declared=replace(value.declared, shape=()))


def _is_close(a: Linear, b: Linear) -> bool:
    """Whether two unit conversions are the same, but for the rounding of factors that were multiplied."""
    return math.isclose(a.factor, b.factor, rel_tol=1e-12) and math.isclose(a.offset, b.offset, rel_tol=1e-12)
