"""Connections through systems in systems, followed back to what each input and each parameter of a unit comes from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from components.interfaces.problem import did_you_mean
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.connections import Connector, ConnectorPath, SspConnection
from orchestrator.ssp.ssp_units import SspUnit
from orchestrator.ssp.system_elements import SspSystem
from orchestrator.ssp.transformations import ConversionStep
from orchestrator.system.named_variables import ElementIndex, UnitVariable


@dataclass(frozen=True)
class PassedConnector:
    """A connector on the way to a variable.

    Attributes:
        path: The connector.
        index: The element of it that leads on; None for all of it.
        steps: The conversions from this connector to the variable.
    """

    path: ConnectorPath
    index: ElementIndex
    steps: tuple[ConversionStep, ...]


@dataclass(frozen=True)
class ResolvedConnection:
    """A connection into a variable of a unit, followed back to where it begins.

    Attributes:
        index: The element that the connection leads to; None for the whole variable.
        unit: The unit that it comes from; None where it begins at a connector of a system.
        output: The output, or the output clock, of that unit.
        passed: The connectors on the way, the nearest first; the last is where the connection begins.
    """

    index: ElementIndex
    unit: SspUnit | None
    output: UnitVariable | None
    passed: tuple[PassedConnector, ...]

    @property
    def steps(self) -> tuple[ConversionStep, ...]:
        """The conversions on the whole way."""
        return self.passed[-1].steps


class ConnectionGraph:
    """All connections of an SSP.

    Args:
        root: The outermost system.
        units: The units, by the path of their component.
        findings: Where problems are gathered.
    """

    def __init__(self, root: SspSystem, units: Mapping[tuple[str, ...], SspUnit], findings: Findings) -> None:
        self._units, self._findings = units, findings
        self._elements = {element.path: element for element in root.walk()}
        self._by_target: dict[ConnectorPath, list[SspConnection]] = {}
        for system in (e for e in root.walk() if isinstance(e, SspSystem)):
            for connection in system.connections:
                self._by_target.setdefault(self._whole(connection.target), []).append(connection)

    def connector(self, path: ConnectorPath) -> Connector | None:
        """A connector that the file lists for an element."""
        element = self._elements.get(path[0])
        return None if element is None else element.connectors.get(path[1])

    def connections_to(self, unit: SspUnit, target: UnitVariable) -> list[ResolvedConnection]:
        """The connections into a variable: none, one into the whole variable, or those into its elements."""
        arriving = self._by_target.get((unit.component.path, target.variable.name), [])
        indices = [self._index(c, c.target, c.target_index) for c in arriving]
        taken: dict[ElementIndex, int] = {}
        for i, index in enumerate(indices):
            same = [*taken.values()][:1] if index is None else [taken[k] for k in (index, None) if k in taken]
            for first in same[:1]:
                found = f"a second source of `{unit.name}.{arriving[i].target[1]}`"
                valid = f"one source, as in {arriving[first].step.where}"
                self._findings.add_problem(arriving[i].step.where, found, valid)
                return []
            taken[index] = i
        resolved: list[ResolvedConnection] = []
        for connection, index in zip(arriving, indices, strict=True):
            # the variable of the unit itself, not its connector, decides what arrives
            steps = (replace(connection.step, to=unit.declared(target.variable)),)
            if index is None and self._splits(connection):
                for zero_based in np.ndindex(*target.variable.shape):
                    element = tuple(i + 1 for i in zero_based)
                    resolved += self._follow(connection, element, element, steps)
            else:
                resolved += self._follow(connection, index, None if index is None else (), steps)
        return resolved

    def _variable(self, path: ConnectorPath) -> UnitVariable | None:
        unit = self._units.get(path[0])
        return unit.variables.get(path[1]) if unit else None

    def _whole(self, path: ConnectorPath) -> ConnectorPath:
        """The path of the whole variable, where a connector is one element of it."""
        target = self._variable(path)
        return path if target is None else (path[0], target.variable.name)

    def _index(self, connection: SspConnection, path: ConnectorPath, index: ElementIndex) -> ElementIndex:
        """The element that one end of a connection means."""
        target, connector = self._variable(path), self.connector(path)
        own = None if target is None else target.index
        if index is None:
            return own
        declared = connector.declared.shape if connector is not None else None
        shape = declared or () if target is None else target.shape
        if target is None and not shape:  # a system may leave the lengths open
            return index
        if own or not is_inside(index, shape):
            found = f"the element {' '.join(map(str, index))} of `{path[1]}`"
            lengths = " x ".join(map(str, shape))
            valid = f"an element of {lengths}" if shape else "no element: it is a scalar"
            self._findings.add_problem(connection.step.where, found, valid)
            return own
        return index

    def _splits(self, connection: SspConnection) -> bool:
        """Whether the elements of a whole array come from connections of their own somewhere on the way."""
        seen: set[ConnectorPath] = set()
        waiting = [connection]
        while waiting:
            connection = waiting.pop()
            source = connection.source
            if connection.source_index is not None or self._variable(source) or source in seen:
                continue
            seen.add(source)
            before = self._by_target.get(source, [])
            if any(c.target_index is not None for c in before):
                return True
            waiting += before
        return False

    def _follow(
        self, connection: SspConnection, index: ElementIndex, wanted: ElementIndex, steps: tuple[ConversionStep, ...]
    ) -> Iterator[ResolvedConnection]:
        """Go back along a connection to the unit that it comes from.

        Args:
            connection: The last connection, into the variable of the unit.
            index: The element of the variable that it leads to; None for the whole variable.
            wanted: The element of the source that is wanted; () where that is a scalar, None for all of it.
            steps: The conversion of that connection.
        """
        passed: list[PassedConnector] = []
        seen: set[tuple[ConnectorPath, ElementIndex]] = set()
        while True:
            source = connection.source
            here = self._index(connection, source, connection.source_index) or (wanted or None)
            passed.append(PassedConnector(source, here, steps))
            if source[0] in self._elements and not isinstance(self._elements[source[0]], SspSystem):
                yield from self._beginning(connection, index, here, passed)
                return
            before = [c for c in self._by_target.get(source, []) if c.target_index in (None, here)]
            if len(before) > 1:
                found = f"a second source of the connector `{source[1]}`"
                valid = f"one source, as in {before[0].step.where}"
                self._findings.add_problem(before[1].step.where, found, valid)
            circular = (source, here) in seen
            if before and circular:
                where = connection.step.where
                self._findings.add_problem(where, "connections in a circle", "a way from a unit to a unit")
            if not before or circular:
                yield ResolvedConnection(index, None, None, tuple(passed))
                return
            seen.add((source, here))
            connection = before[0]
            wanted = here if connection.target_index is None else ()
            steps = (connection.step, *steps)

    def _beginning(
        self, connection: SspConnection, index: ElementIndex, here: ElementIndex, passed: Sequence[PassedConnector]
    ) -> Iterator[ResolvedConnection]:
        """The resolved connection from the output that it begins at; nothing where the findings refuse that."""
        path, name = connection.source
        unit = self._units.get(path)
        if unit is None:
            return  # its component cannot be used, as the findings say
        output, where = unit.variables.get(name), connection.step.where
        if output is not None and here and not is_inside(here, output.variable.shape):
            found = f"one element for `{unit.name}.{name}` of shape {output.variable.shape}"
            self._findings.add_problem(where, found, "arrays of one shape, or scalars")
        elif output is not None and output.role in ("outputs", "clocks"):
            yield ResolvedConnection(index, unit, UnitVariable(output.role, output.variable, here), tuple(passed))
        elif unit.has(name):
            found = f"`{unit.name}.{name}`, which is not an output"
            self._findings.add_problem(where, found, "an output: a master reads nothing else while it runs")
        else:
            close = did_you_mean(name, unit.variables)
            self._findings.add_problem(where, f"no variable `{name}` of `{unit.name}`", "one that it has", close)


def is_inside(index: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    """Whether an array of this shape has an element, counted from 1."""
    return len(index) == len(shape) and all(1 <= i <= n for i, n in zip(index, shape, strict=True))
