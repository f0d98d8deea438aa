"""Files with the values of inputs over time: CSV, or parquet such as the `signals.parquet` of a run.

The first column is `time`, each other one has the name of an input: `v`, `car.v`, `v [km/h]`, `x[2]`.
"""
# pyright: basic
# pyarrow carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import unit_conversion
from components.interfaces.problem import Problem, raise_if_any, refuse
from components.interfaces.quantity import Quantity
from orchestrator.system.contents import read_bytes
from orchestrator.system.parquet_tables import read_parquet
from orchestrator.system.value_texts import behind

TIME: Final = "time"
_SECOND: Final = Quantity("s", "the unit of measurement of times")
_VALID: Final = "a table: a .csv or .parquet file with the column `time` first, and one for each input"

LARGEST_TABLE: Final = 4 * 2**30
"""[byte] The largest file of a table."""


@dataclass(frozen=True)
class TableColumn:
    """A column as the file has it."""

    name: str
    unit: str | None
    """The unit of measurement; None where the file does not give it."""
    read: Callable[[], Sequence[Any]] = field(repr=False)
    """Gives the values, row by row: texts in a CSV file."""


@dataclass(frozen=True)
class TableFile:
    """A file that was read, whose columns have not been compared with the inputs of a system."""

    where: str
    """The file, as messages name it."""
    suffix: str
    content: bytes = field(repr=False)
    times: NDArray[np.float64] = field(repr=False)
    """[s] The time of each row, increasing, (rows,)."""
    columns: Mapping[str, TableColumn]
    """All columns but the time, by their names."""
    lines: Sequence[int] = field(repr=False)
    """The line, or the row, of each row in the file, counted from 1."""
    is_run: bool = False
    """Whether a run has written it, with all its signals."""

    def at(self, row: int, column: str) -> str:
        """The place of a value, for messages."""
        word = "line" if self.suffix == ".csv" else "row"
        return f"{self.where}, {word} {self.lines[row]}, `{column}`"


def read_table(path: Path, where: str | None = None) -> TableFile:
    """Read a table, and check its times.

    Args:
        path: The file.
        where: The file, as messages name it; its path if not given.

    Raises:
        RequestError: It cannot be read, is no table, or its times do not increase.
    """
    where = where or str(path)
    if path.suffix not in {".csv", ".parquet"}:
        raise refuse(where, f"a file ending in `{path.suffix}`", _VALID)
    content = read_bytes(path, where, _VALID, LARGEST_TABLE)
    columns, lines, is_run = _csv(content, where) if path.suffix == ".csv" else _parquet(path, where)
    if not columns or columns[0].name.lower() != TIME:
        first = f"the first column `{columns[0].name}`" if columns else "no columns"
        raise refuse(where, first, _VALID)
    if not lines:
        raise refuse(where, "no rows", _VALID)
    names = [column.name for column in columns]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise refuse(where, f"two columns `{twice[0]}`", "a name of its own for each column")
    by_name = {column.name: column for column in columns[1:]}
    table = TableFile(where, path.suffix, content, np.zeros(0), by_name, lines, is_run)
    return TableFile(where, path.suffix, content, _times(table, columns[0]), by_name, lines, is_run)


def numbers(table: TableFile, column: TableColumn) -> NDArray[np.float64]:
    """The values of a column as numbers, (rows,); none is NaN.

    Raises:
        RequestError: Values are no numbers, each with its place.
    """
    values = column.read()
    found = np.array([_number(value) for value in values])
    rows: list[int] = np.flatnonzero(np.isnan(found)).tolist()
    raise_if_any(Problem(table.at(row, column.name), shown(values[row]), "a number") for row in rows)
    return found


def _number(value: Any) -> float:
    """The number that a value is; NaN where it is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def shown(value: Any) -> str:
    """A value of a table, for messages."""
    return "nothing" if value is None or value == "" else f"`{value}`"


def _times(table: TableFile, column: TableColumn) -> NDArray[np.float64]:
    conversion = unit_conversion(Quantity(column.unit or "s", "a time"), _SECOND)
    if conversion is None:
        raise refuse(f"{table.where}: {column.name}", f"the unit `{column.unit}`", "a unit of time, such as `s`")
    times = np.asarray(conversion(numbers(table, column)))
    infinite = np.flatnonzero(~np.isfinite(times))
    raise_if_any(Problem(table.at(int(i), column.name), f"{times[i]}", "a finite number") for i in infinite)
    raise_if_any(
        Problem(
            table.at(int(i) + 1, column.name),
            f"{times[i + 1]:g} s after {times[i]:g} s",
            "times that increase",
            "Sort the rows.",
        )
        for i in np.flatnonzero(np.diff(times) <= 0)
    )
    return times


_Content = tuple[list[TableColumn], Sequence[int], bool]
"""All columns, the line of each row, and whether a run has written the file."""


def _csv(content: bytes, where: str) -> _Content:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise refuse(where, f"bytes that are no UTF-8 (at byte {error.start})", _VALID) from error
    header, _, _ = text.partition("\n")
    delimiter = next((mark for mark in (";", "\t") if mark in header), ",")
    reader = csv.reader(io.StringIO(text), delimiter=delimiter, skipinitialspace=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append([cell.strip() for cell in row])
                lines.append(reader.line_num)
    except csv.Error as error:
        raise refuse(f"{where}, line {reader.line_num}", f"what is no CSV ({error})", _VALID) from error
    if not rows:
        return [], [], False
    names, *body = rows
    raise_if_any(
        Problem(f"{where}, line {line}", f"{len(row)} values", f"{len(names)}, one for each column")
        for row, line in zip(body, lines[1:], strict=True)
        if len(row) != len(names)
    )
    columns: list[TableColumn] = []
    for i, name in enumerate(names):
        read = lambda i=i: [row[i] for row in body]  # noqa: E731 - its only use is one line below
        columns.append(TableColumn(*_named(name), read))
    return columns, lines[1:], False


def _named(header: str) -> tuple[str, str | None]:
    """The name of a column and its unit of measurement, from a header such as `plant.actuation.delta_f [rad]`."""
    parts = behind(header)
    return (header, None) if parts is None else parts


def _parquet(path: Path, where: str) -> _Content:
    table = read_parquet(path, where, _VALID)
    columns: list[TableColumn] = []
    for item in table.schema:
        unit = (item.metadata or {}).get(b"unit")
        name, given = _named(str(item.name))
        given = unit.decode("utf-8", "replace") if unit else given
        columns.append(TableColumn(name, given or None, table.column(item.name).to_pylist))
    is_run = b"macrostep" in (table.schema.metadata or {})
    return columns, range(1, table.num_rows + 1), is_run
