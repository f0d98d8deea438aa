"""The columns of a table compared with the inputs of a system, which then follow them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import unit_conversion
from components.interfaces.problem import Gathered, Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.quantity import DTYPES, TRUTHS, Quantity, Type
from components.interfaces.record import Variable
from orchestrator.scenario.table_file import TableColumn, TableFile, numbers, shown
from orchestrator.system.connection import is_part
from orchestrator.system.input_table import InputColumn, InputTable
from orchestrator.system.system import System

_BOOLEANS: Final = TRUTHS | {"1.0": True, "0.0": False}


@dataclass(frozen=True)
class _Element:
    """An input, or one element of it."""

    unit: str
    variable: Variable
    at: int
    name: str
    """Its name without the unit."""

    @property
    def path(self) -> str:
        """The full path, with the name that the file of the unit has for it."""
        return f"{self.unit}.{self.name}"

    @property
    def place(self) -> str:
        """The full path, as signals have it."""
        return f"{self.unit}.{self.variable.elements[self.at]}"


def with_table(system: System, table: TableFile, *, hold: bool) -> tuple[System, list[str]]:
    """Let inputs of a system follow a table.

    Args:
        system: The system.
        table: The table.
        hold: Whether all values hold until the next row; else floating-point inputs that are not discrete are
            interpolated.

    Returns:
        The system, and what a person should know of how the columns were taken.

    Raises:
        RequestError: A column is no input, or its values are none that the input takes; all problems.
    """
    found = _Columns(system, table)
    wrong = Gathered()
    read = [wrong.attempt(partial(_driven, system, table, *taken, hold=hold), None) for taken in found.taken.values()]
    columns = [column for column in read if column is not None]
    raise_if_any([*found.problems, *wrong.problems])
    raise_if_any(_without_value(system, columns))
    inputs = InputTable(table.times, tuple(columns), hold, table.suffix, table.content)
    held = dict(system.held)
    for path in set(inputs.paths) & set(system.unset):
        held[path] = _first(system, path, columns)
    driven = replace(system, held=held, unset=frozenset(system.unset) - held.keys(), table=inputs)
    return driven, found.remarks


class _Columns:
    """Which column drives which input."""

    def __init__(self, system: System, table: TableFile) -> None:
        self._system, self._table = system, table
        self.problems: list[Problem] = []
        self.remarks: list[str] = []
        self.taken: dict[str, tuple[_Element, TableColumn]] = {}
        """By the full path of an element."""
        self._elements = list(_elements(system))
        left = [column for column in table.columns.values() if not self._take(column, self._named(column.name))]
        if table.is_run:  # it has all signals of another system, whose units have other names
            left = [c for c in left if not self._take(c, self._named(c.name.partition(".")[2]), replaced=False)]
            self._remark_on_run(left)
        else:
            self.problems += [self._unknown(column.name) for column in left]

    def _named(self, name: str) -> list[_Element]:
        exact = [element for element in self._elements if element.path == name]
        return exact or [element for element in self._elements if element.name == name]

    def _take(self, column: TableColumn, elements: Sequence[_Element], *, replaced: bool = True) -> bool:
        """Note the element that a column drives; return whether there is one, or a problem instead."""
        where = f"{self._table.where}: {column.name}"
        if len(elements) > 1:
            named = choices(element.path for element in elements)
            self.problems.append(Problem(where, f"inputs of several units: {named}", "the name of one with its unit"))
        if len(elements) != 1:
            return len(elements) > 1
        element = elements[0]
        if (driver := self._driver(element)) is not None:
            if not self._table.is_run:
                found = f"two sources of {element.path}, {driver} and the table"
                self.problems.append(Problem(where, found, "one source"))
            return not self._table.is_run
        if element.place in self.taken:
            if replaced:
                found = f"{element.path}, which `{self.taken[element.place][1].name}` drives"
                self.problems.append(Problem(where, found, "one column for each input"))
            return replaced
        self.taken[element.place] = element, column
        return True

    def _driver(self, element: _Element) -> str | None:
        """The output that is connected to an element."""
        wire = self._system.driver(element.unit, element.variable.name, element.at)
        return None if wire is None else wire.origin

    def _unknown(self, name: str) -> Problem:
        where = f"{self._table.where}: {name}"
        arrays = [e for e in self._elements if is_part(e.path, name) or is_part(e.name, name)]
        if arrays:
            return Problem(where, "an array", f"a column for each element: {', '.join(e.name for e in arrays)}")
        free = [element for element in self._elements if self._driver(element) is None]
        meant = did_you_mean(name, [e.name for e in free]) or did_you_mean(name, [e.path for e in free])
        valid = choices(e.path for e in free) if free else "no column: connections drive all inputs"
        return Problem(where, "a column that is no input", valid, meant)

    def _remark_on_run(self, left: Sequence[TableColumn]) -> None:
        if not self.taken:
            valid = choices(element.path for element in self._elements if self._driver(element) is None)
            self.problems.append(Problem(self._table.where, "no column that is an input", valid))
        renamed = [f"{e.path} follows `{c.name}`" for e, c in self.taken.values() if c.name != e.path]
        more = [f"{len(left)} of its {len(self._table.columns)} columns are no inputs here"] if left else []
        if renamed or more:
            self.remarks.append(f"{self._table.where}: {'; '.join([*renamed, *more])}")


def _elements(system: System) -> Iterator[_Element]:
    for unit, source in system.units.items():
        for variable in source.interface.inputs:
            spelled = source.element_names(variable, "inputs") if variable.shape else [variable.name]
            for at, name in enumerate(variable.elements):
                yield _Element(unit, variable, at, name)
                if len(spelled) == variable.size and spelled[at] != name:
                    yield _Element(unit, variable, at, spelled[at])


def _driven(system: System, table: TableFile, element: _Element, column: TableColumn, *, hold: bool) -> InputColumn:
    quantity = element.variable.quantity
    values = _values(table, column, quantity)
    one = replace(quantity, shape=())
    if replace(quantity, shape=values.shape).problems("", values):
        rows = enumerate(values.tolist())
        raise_if_any(p for row, value in rows for p in one.problems(table.at(row, column.name), value))
    interface = system.units[element.unit].interface
    steps = hold or not quantity.type.is_float or element.variable.name in interface.discrete
    own = values.astype(DTYPES[quantity.type])
    return InputColumn(element.unit, element.variable.name, element.at, element.place, quantity.type, own, steps)


def _values(table: TableFile, column: TableColumn, quantity: Quantity) -> NDArray[Any]:
    """The values of a column as the input takes them. Raises `RequestError`."""
    kind = quantity.type
    if kind.is_float:
        return _converted(table, column, quantity)
    if column.unit not in (None, "1"):
        where = f"{table.where}: {column.name}"
        raise refuse(where, f"the unit `{column.unit}`", f"none: values of type {kind} have no unit of measurement")
    if kind is Type.STRING:
        return np.array([str(value) for value in column.read()], dtype=object)
    if kind is Type.BINARY:
        raise refuse(f"{table.where}: {column.name}", "an input of bytes", "numbers, Booleans, enumerations or texts")
    items = {} if quantity.enumeration is None else dict(quantity.enumeration.values)
    valid = quantity.range
    found: list[Any] = []
    for row, value in enumerate(column.read()):
        text = str(value).strip()
        if kind is Type.BOOLEAN and text.lower() in _BOOLEANS:
            found.append(_BOOLEANS[text.lower()])
        elif text in items:
            found.append(items[text])
        elif kind is not Type.BOOLEAN and (number := _whole(text)) is not None:
            found.append(number)
        else:
            raise refuse(table.at(row, column.name), shown(value), valid)
    values = np.array(found)
    return values if values.dtype.kind in "biu" else np.array(found, dtype=object)  # of too large ones, each is told


def _whole(text: str) -> int | None:
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return int(float(text)) if float(text).is_integer() else None
    except (ValueError, OverflowError):
        return None


def _converted(table: TableFile, column: TableColumn, quantity: Quantity) -> NDArray[np.float64]:
    values = numbers(table, column)
    if column.unit is None:
        return values
    conversion = unit_conversion(Quantity(column.unit, ""), quantity)
    if conversion is None:
        where, wanted = f"{table.where}: {column.name}", quantity.unit
        raise refuse(where, f"the unit `{column.unit}`", f"`{wanted}`, or another that measures the same")
    return np.asarray(conversion(values))


def _without_value(system: System, columns: Sequence[InputColumn]) -> Iterator[Problem]:
    """The problems of arrays that nobody has a value for, of which a table drives only some elements."""
    for path in system.unset:
        variable = system.variable(path, role="inputs")
        mine = {column.element for column in columns if f"{column.unit}.{column.input}" == path}
        if mine and (left := [name for i, name in enumerate(variable.elements) if i not in mine]):
            yield Problem(path, f"no value of {', '.join(left)}", "a column for each element of the array")


def _first(system: System, path: str, columns: Sequence[InputColumn]) -> Any:
    """The first value of an input."""
    variable = system.variable(path, role="inputs")
    values = {c.element: c.values[0] for c in columns if f"{c.unit}.{c.input}" == path}
    whole = np.array([values[i] for i in range(variable.size)], dtype=object).reshape(variable.shape)
    return whole.tolist()
