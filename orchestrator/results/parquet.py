"""Rows of a run as parquet files, with units of measurement and provenance in the metadata.

Values are handed to and from pyarrow as buffers, because its own conversions import all of pandas, which takes longer
than to write the file.
"""
# pyright: basic
# pyarrow carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from orchestrator.results.manifest import unfinished
from orchestrator.results.metrics import Frame
from orchestrator.results.provenance import versions
from orchestrator.system.experiment import Scenario
from orchestrator.system.system import System

_GROUP: Final = 2**20, 2**22
"""The most rows of a row group, and about the most bytes of its values: what is in memory at a time."""
_TEXT: Final = 64
"""[byte] How large a text is taken to be."""


def write_signals(frame: Frame, scenario: Scenario, path: Path) -> None:
    """Write all rows of a run as parquet, completely or not at all.

    The unit of measurement and the meaning of each column, and the provenance of the run, stand in the metadata. A
    value that is not a number (NaN) is null in the file, as data frames have it.

    Args:
        frame: The column `time` [s], and one column for each signal element that was kept.
        scenario: What was run.
        path: The file.
    """
    SignalSchema(frame, scenario).write(frame, path)


class SignalSchema:
    """What the columns of a run are: their types, units of measurement and meanings, and the provenance of the run.

    Args:
        frame: Any rows of the run, none at all will do.
        scenario: What is run.
    """

    def __init__(self, frame: Frame, scenario: Scenario) -> None:
        described = {"time": {"unit": "s", "description": "simulated time"}, **_descriptions(scenario.system)}
        texts = _texts_of(scenario.system)
        types = {name: _type(np.asarray(frame[name]).dtype, is_text=name in texts) for name in map(str, frame)}
        provenance = {
            "macrostep": json.dumps({"scenario": scenario.name, "step": scenario.h, "versions": versions()}),
            "units": json.dumps({name: description["unit"] for name, description in described.items()}),
        }
        self._schema = pa.schema([pa.field(n, t, metadata=described[n]) for n, t in types.items()], provenance)
        self._plain = pa.schema([pa.field(name, kind) for name, kind in types.items()])

    @property
    def row_size(self) -> int:
        """[byte] About how much memory a row takes."""
        return _row_size(self._schema)

    def write(self, frame: Frame, path: Path) -> None:
        """Write rows as a file of its own, completely or not at all."""
        _write_whole([_table(frame, self._schema)], self._schema, path)

    def write_part(self, frame: Frame, path: Path) -> None:
        """Write some rows, completely or not at all; `write_meaning` writes once what the columns of all parts are."""
        _write_whole([_table(frame, self._plain)], self._plain, path)

    def write_meaning(self, path: Path) -> None:
        """Write what the columns are, without rows."""
        with unfinished(path) as file:
            pq.write_metadata(self._schema, file)


def merge(parts: Sequence[Path], meaning: Path, path: Path) -> None:
    """Write all rows of some parts as one file, which is the same however the rows are divided.

    Args:
        parts: The parts in the order of their rows.
        meaning: What `SignalSchema.write_meaning` has written.
        path: The file, which is written completely or not at all.
    """
    schema = pq.read_schema(meaning)
    _write_whole((pq.ParquetFile(part).read() for part in parts), schema, path)


def read_columns(path: Path, names: Sequence[str] | None = None, rows: slice | None = None) -> dict[str, Any]:
    """Read rows of a run without pandas; `pandas.read_parquet` reads the same file.

    Args:
        path: The file `signals.parquet`.
        names: The columns; all if not given.
        rows: The rows, from a first one to before a last one; all if not given.

    Returns:
        The values `(n,)` of each column; NaN for nulls among numbers with a fraction, texts, bytes and other columns
        with nulls as arrays of objects.
    """
    file, columns = pq.ParquetFile(path), None if names is None else list(names)
    if rows is None:
        table = file.read(columns)
    else:
        ends = np.cumsum([file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)], dtype=np.int64)
        first = int(np.searchsorted(ends, rows.start, "right"))
        groups = list(range(first, min(int(np.searchsorted(ends, rows.stop)) + 1, len(ends))))
        begin = int(ends[first - 1]) if first else 0
        table = file.read_row_groups(groups, columns).slice(rows.start - begin, rows.stop - rows.start)
    return {name: _values(table.column(name)) for name in table.column_names}


class FileColumns(Mapping[str, Any]):
    """The columns of a file, each of which is read when it is asked for, as `read_columns` reads it.

    Args:
        path: The file `signals.parquet`.
    """

    def __init__(self, path: Path) -> None:
        self._file = pq.ParquetFile(path)
        self._names = dict.fromkeys(self._file.schema_arrow.names)

    @property
    def rows(self) -> int:
        """How many rows the file has."""
        return self._file.metadata.num_rows

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        return _values(self._file.read([name]).column(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _write_whole(tables: Iterable[pa.Table], schema: pa.Schema, path: Path) -> None:
    most = max(1, min(_GROUP[0], _GROUP[1] // _row_size(schema)))
    with unfinished(path) as file, pq.ParquetWriter(file, schema, compression="zstd", **_encoding(schema)) as writer:
        for group in _groups((_conforming(table, schema) for table in tables), most):
            writer.write_table(group, row_group_size=most)


def _encoding(schema: pa.Schema) -> dict[str, Any]:
    """Numbers byte by byte, which take a fifth less room, the rest as dictionaries; statistics nobody reads."""
    numbers = {field.name: "BYTE_STREAM_SPLIT" for field in schema if pa.types.is_floating(field.type)}
    others = [name for name in schema.names if name not in numbers]
    return {"column_encoding": numbers, "use_dictionary": others, "write_statistics": False}


def _groups(tables: Iterable[pa.Table], most: int) -> Iterator[pa.Table]:
    """The same rows in groups of `most`, whose bytes do not depend on how they came."""
    waiting, count = list[pa.Table](), 0
    for table in tables:
        waiting.append(table)
        count += len(table)
        while count >= most:
            whole = pa.concat_tables(waiting)
            yield whole.slice(0, most).combine_chunks()
            waiting, count = [whole.slice(most)], count - most
    if count:
        yield pa.concat_tables(waiting).combine_chunks()


def _conforming(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """The columns of a schema; nulls where a part has no such column."""
    if table.schema.names == schema.names:
        return pa.Table.from_arrays(table.columns, schema=schema)
    has = set(table.schema.names)
    columns = [table.column(f.name) if f.name in has else pa.nulls(len(table), f.type) for f in schema]
    return pa.Table.from_arrays(columns, schema=schema)


def _row_size(schema: pa.Schema) -> int:
    return sum(_TEXT if pa.types.is_large_string(t) or pa.types.is_large_binary(t) else 8 for t in schema.types) or 1


def _table(frame: Frame, schema: pa.Schema) -> pa.Table:
    return pa.Table.from_arrays([_array(np.asarray(frame[f.name]), f.type) for f in schema], schema=schema)


def _type(dtype: np.dtype[Any], *, is_text: bool) -> pa.DataType:
    if dtype.kind == "O":
        return pa.large_string() if is_text else pa.large_binary()
    return pa.from_numpy_dtype(dtype)


def _array(values: np.ndarray[Any, Any], arrow_type: pa.DataType) -> pa.Array:
    if values.dtype == object:
        return _texts(values, arrow_type)
    if values.dtype == bool:
        return pa.Array.from_buffers(arrow_type, len(values), [None, _bits(values)])
    missing = np.isnan(values) if values.dtype.kind == "f" else np.zeros(0, dtype=bool)
    present = _bits(~missing) if missing.any() else None
    data = pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(arrow_type, len(values), [present, data])


def _texts(values: np.ndarray[Any, Any], arrow_type: pa.DataType) -> pa.Array:
    """Texts, or bytes: one buffer with all of them, and one with the offset at which each begins."""
    parts = [value.encode() if isinstance(value, str) else value for value in values]
    offsets = np.cumsum([0, *map(len, parts)], dtype=np.int64)
    return pa.Array.from_buffers(arrow_type, len(parts), [None, pa.py_buffer(offsets), pa.py_buffer(b"".join(parts))])


def _bits(values: np.ndarray[Any, Any]) -> pa.Buffer:
    return pa.py_buffer(np.packbits(values, bitorder="little"))


def _descriptions(system: System) -> dict[str, dict[str, str]]:
    """Unit of measurement, meaning and items of each signal element, also of what inputs and parameters received."""
    descriptions: dict[str, dict[str, str]] = {}
    for unit, variable in _variables(system):
        q = variable.quantity
        description = {"unit": q.unit, "description": q.description}
        if q.type is Type.ENUMERATION and q.enumeration is not None:
            description["items"] = json.dumps(q.enumeration.values)
        descriptions |= {f"{unit}.{element}": description for element in variable.elements}
    return descriptions


def _texts_of(system: System) -> set[str]:
    """The full paths of elements that are texts; other objects are bytes."""
    return {f"{u}.{e}" for u, v in _variables(system) if v.quantity.type is Type.STRING for e in v.elements}


def _variables(system: System) -> Iterator[tuple[str, Variable]]:
    for unit, source in system.units.items():
        interface = source.interface
        for variable in (*interface.parameters, *interface.inputs, *interface.recorded):
            yield unit, variable


def _values(column: pa.ChunkedArray) -> np.ndarray[Any, Any]:
    arrow_type = column.type
    if pa.types.is_boolean(arrow_type) and not column.null_count:
        return np.array(column.to_pylist(), dtype=bool)
    if pa.types.is_floating(arrow_type) and column.null_count:
        column = column.fill_null(float("nan"))
    if column.null_count or not (pa.types.is_floating(arrow_type) or pa.types.is_integer(arrow_type)):
        objects = np.empty(len(column), dtype=object)
        objects[:] = column.to_pylist()
        return objects
    dtype = np.dtype(arrow_type.to_pandas_dtype())
    parts = [np.frombuffer(c.buffers()[1], dtype, len(c), c.offset * dtype.itemsize) for c in column.chunks if len(c)]
    return np.concatenate(parts) if parts else np.zeros(0, dtype)
