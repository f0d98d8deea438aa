"""All rows of a run as one parquet file, with units of measurement and provenance in its metadata.

Values are handed to and from pyarrow as buffers, because its own conversions import all of pandas, which takes longer
than to write the file.
"""
# pyright: basic
# pyarrow carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from components.interfaces.quantity import Type
from orchestrator.results.metrics import Frame
from orchestrator.results.provenance import versions
from orchestrator.system.experiment import Scenario
from orchestrator.system.system import System


def write_signals(frame: Frame, scenario: Scenario, path: Path) -> None:
    """Write all rows of a run as parquet, completely or not at all.

    The unit of measurement and the meaning of each column, and the provenance of the run, stand in the metadata. A
    value that is not a number (NaN) is null in the file, as data frames have it.

    Args:
        frame: The column `time` [s], and one column for each signal element that was kept.
        scenario: What was run.
        path: The file.
    """
    described = {"time": {"unit": "s", "description": "simulated time"}, **_descriptions(scenario.system)}
    columns = {name: _array(np.asarray(frame[name])) for name in map(str, frame)}
    fields = [pa.field(name, column.type, metadata=described[name]) for name, column in columns.items()]
    provenance = {
        "macrostep": json.dumps({"scenario": scenario.name, "step": scenario.h, "versions": versions()}),
        "units": json.dumps({name: description["unit"] for name, description in described.items()}),
    }
    unfinished = path.with_name(f".{path.name}")  # a process that is killed here leaves no partial file at `path`
    pq.write_table(pa.Table.from_arrays([*columns.values()], schema=pa.schema(fields, provenance)), unfinished)
    unfinished.replace(path)


def read_columns(path: Path) -> dict[str, Any]:
    """Read all rows of a run without pandas; `pandas.read_parquet` reads the same file.

    Args:
        path: The file `signals.parquet`.

    Returns:
        The values `(n,)` of each column; texts, bytes and columns with nulls as arrays of objects.
    """
    table = pq.ParquetFile(path).read()
    return {name: _values(table.column(name)) for name in table.column_names}


def _array(values: np.ndarray[Any, Any]) -> pa.Array:
    if values.dtype == object:
        return _texts(values)
    if values.dtype == bool:
        return pa.Array.from_buffers(pa.bool_(), len(values), [None, _bits(values)])
    missing = np.isnan(values) if values.dtype.kind == "f" else np.zeros(0, dtype=bool)
    present = _bits(~missing) if missing.any() else None
    data = pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [present, data])


def _texts(values: np.ndarray[Any, Any]) -> pa.Array:
    """Texts, or bytes: one buffer with all of them, and one with the offset at which each begins."""
    if not len(values):
        return pa.nulls(0)
    arrow_type = pa.large_string() if isinstance(values[0], str) else pa.large_binary()
    parts = [value.encode() if isinstance(value, str) else value for value in values]
    offsets = np.cumsum([0, *map(len, parts)], dtype=np.int64)
    return pa.Array.from_buffers(arrow_type, len(parts), [None, pa.py_buffer(offsets), pa.py_buffer(b"".join(parts))])


def _bits(values: np.ndarray[Any, Any]) -> pa.Buffer:
    return pa.py_buffer(np.packbits(values, bitorder="little"))


def _descriptions(system: System) -> dict[str, dict[str, str]]:
    """Unit of measurement, meaning and items of each signal element, also of what inputs and parameters received."""
    descriptions: dict[str, dict[str, str]] = {}
    for unit, source in system.units.items():
        interface = source.interface
        for variable in (*interface.parameters, *interface.inputs, *interface.recorded):
            q = variable.quantity
            description = {"unit": q.unit, "description": q.description}
            if q.type is Type.ENUMERATION and q.enumeration is not None:
                description["items"] = json.dumps(q.enumeration.values)
            descriptions |= {f"{unit}.{element}": description for element in variable.elements}
    return descriptions


def _values(column: pa.ChunkedArray) -> np.ndarray[Any, Any]:
    arrow_type = column.type
    if pa.types.is_boolean(arrow_type) and not column.null_count:
        return np.array(column.to_pylist(), dtype=bool)
    if column.null_count or not (pa.types.is_floating(arrow_type) or pa.types.is_integer(arrow_type)):
        objects = np.empty(len(column), dtype=object)
        objects[:] = column.to_pylist()
        return objects
    dtype = np.dtype(arrow_type.to_pandas_dtype())
    parts = [np.frombuffer(c.buffers()[1], dtype, len(c), c.offset * dtype.itemsize) for c in column.chunks if len(c)]
    return np.concatenate(parts) if parts else np.zeros(0, dtype)
