"""A unit that is stepped by itself in a measuring process, and the rows of outputs that it shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import DTYPES, Type, zeros
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.units.make import fmu_unit
from fmus.units.unit import (
    EndRequested,
    ExperimentSetup,
    Operation,
    UnitError,
    by_type,
    carry_out,
    is_failure,
    positions,
    widths,
)

Rows: TypeAlias = Mapping[Type, NDArray[Any]]
"""The values of all variables of one direction by type, `(rows, elements)`, in the order of the interface."""


@dataclass(frozen=True)
class Course:
    """What a unit is given, step by step."""

    h: float
    """[s] The step."""
    steps: int
    inputs: Rows
    """The inputs of each step; without entries for an FMU that has none."""


class Running:
    """A unit of an FMU with columns of its own, in a `with` statement, which starts and ends it.

    Args:
        archive: The FMU.
        h: The step [s].
        parameters: The values of parameters that differ from the FMU's own.
        name: The name of the instance.
        setup: The experiment that the FMU is told; its own if not given.
    """

    def __init__(
        self,
        archive: Archive,
        h: float,
        parameters: Mapping[str, Any] | None = None,
        *,
        name: str = "fmu",
        setup: ExperimentSetup | None = None,
    ) -> None:
        self.h = h
        self.parameters = dict(parameters or {})
        self.unit = fmu_unit(name, archive)
        self.interface = archive.interface
        self.inputs = {kind: zeros(kind, n) for kind, n in widths(self.interface.inputs).items()}
        self.outputs = {kind: zeros(kind, n) for kind, n in widths(self.interface.outputs).items()}
        self._starts = start_values(archive)
        put(self.inputs, self._starts)
        self._setup = setup or ExperimentSetup(archive.suggested.start, archive.suggested.stop)
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []
        self.tick = 0

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        try:
            if error is None:
                self.unit.terminate()
        finally:
            self.close()

    @property
    def time(self) -> float:
        """The present instant [s]."""
        return self._setup.start + self.tick * self.h

    def start_over(self) -> None:
        """Start the unit again after a reset, with the inputs of its first start."""
        put(self.inputs, self._starts)
        self.start()

    def start(self) -> None:
        """Initialise the unit and show its outputs at the start."""
        self.tick = 0
        self.unit.bind(self.inputs, self.outputs)
        self._setters, self._getters = self.unit.setters(), self.unit.getters()
        self.unit.enter_initialization(self.parameters, self._setup)
        self.set()
        self.unit.exit_initialization()
        self.show()

    def set(self) -> None:
        """Give the unit its inputs."""
        self._checked("setting its inputs", carry_out(self._setters))

    def show(self) -> None:
        """Fetch the outputs."""
        self._checked("getting its outputs", carry_out(self._getters))

    def step(self) -> None:
        """Give the unit its inputs, make one step, and fetch the outputs. Raises `UnitError` and `EndRequested`."""
        self.set()
        self._checked("a step", self.unit.step(self.time, self.h))
        self.tick += 1
        self.show()

    def close(self) -> None:
        """Release the unit."""
        self.unit.close()

    def _checked(self, action: str, status: object) -> None:
        if isinstance(status, int) and is_failure(status):
            words = {2: "discarded", 3: "an error", 4: "a fatal error"}
            at = f"{action} at {self.time:g} s: {words.get(status, f'status {status}')}"
            raise UnitError(self.unit.name, at, self.unit.messages)


def followed(
    running: Running, course: Course, first: int = 0, last: int | None = None, pause: Callable[[], object] | None = None
) -> Rows:
    """Step a unit along a course.

    Args:
        running: The unit, which stands where the step `first` begins.
        course: What it is given.
        first: The first step.
        last: The step before which this ends; all if not given.
        pause: Called after each step, if given.

    Returns:
        The outputs after each step, and at the start where `first` is 0; fewer where the FMU asks for the end.
    """
    rows = [copied(running.outputs)] if first == 0 else []
    for k in range(first, course.steps if last is None else last):
        put(running.inputs, {kind: table[k] for kind, table in course.inputs.items()})
        try:
            running.step()
        except EndRequested:
            break
        rows.append(copied(running.outputs))
        if pause is not None:
            pause()
    return {
        kind: np.array([row[kind] for row in rows], dtype=column.dtype).reshape(len(rows), column.size)
        for kind, column in running.outputs.items()
    }


def copied(columns: Mapping[Type, NDArray[Any]]) -> dict[Type, NDArray[Any]]:
    """The present values of columns."""
    return {kind: column.copy() for kind, column in columns.items()}


def put(columns: Mapping[Type, NDArray[Any]], values: Mapping[Type, NDArray[Any]]) -> None:
    """Write values into columns."""
    for kind, row in values.items():
        columns[kind][:] = row


def start_values(archive: Archive) -> dict[Type, NDArray[Any]]:
    """The start values of all inputs; 0 where the file has none."""
    found: dict[Type, NDArray[Any]] = {}
    for kind, group in by_type(archive.interface.inputs).items():
        parts = [np.ravel(_start(archive, v)) for v in group]
        found[kind] = np.concatenate(parts).astype(DTYPES[kind])
    return found


def _start(archive: Archive, variable: Variable) -> NDArray[Any]:
    start = archive.interface.starts.get(variable.name)
    empty = zeros(variable.quantity.type, variable.shape)
    if start is None:
        return empty
    return np.broadcast_to(np.asarray(start, dtype=DTYPES[variable.quantity.type]), variable.shape)


def first_difference(one: Rows, other: Rows, variables: tuple[Variable, ...]) -> tuple[int, str, Any, Any] | None:
    """Where two series of rows first differ in a bit: row, element, and both values; None if they are the same."""
    lengths = {len(table) for rows in (one, other) for table in rows.values()}
    if len(lengths) > 1:
        return min(lengths), "the end", "the last row", "more rows"
    found: list[tuple[int, str, Any, Any]] = []
    places = positions(variables)
    for variable in variables:
        kind, at = places[variable.name]
        mine, theirs = (rows[kind][:, at : at + variable.size] for rows in (one, other))
        row = _first_row(mine, theirs)
        if row is not None:
            element = next(i for i in range(variable.size) if not _same(mine[row, i], theirs[row, i]))
            name = variable.elements[element] if variable.quantity.shape else variable.name
            found.append((row, name, mine[row, element], theirs[row, element]))
    return min(found, key=lambda item: item[0], default=None)


def _first_row(one: NDArray[Any], other: NDArray[Any]) -> int | None:
    for row, (mine, theirs) in enumerate(zip(one, other, strict=True)):
        if not _same(mine, theirs):
            return row
    return None


def _same(one: Any, other: Any) -> bool:
    mine, theirs = np.asarray(one), np.asarray(other)
    return mine.tolist() == theirs.tolist() if mine.dtype == object else mine.tobytes() == theirs.tobytes()
