"""All rows of a run as one parquet file, with units and provenance in its metadata.

Values go to and from pyarrow by their memory: its own conversions import all of pandas, and a person waits for that.
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
    """All rows as parquet; each column's unit and meaning, and the run's provenance, stand in the metadata.

    What is no number (NaN) is null in the file, as data frames have it.
    """
    known = {"time": {"unit": "s", "description": "simulated time"}, **_descriptions(scenario.system)}
    columns = {name: _array(np.asarray(frame[name])) for name in map(str, frame)}
    fields = [pa.field(name, column.type, metadata=known[name]) for name, column in columns.items()]
    provenance = {
        "macrostep": json.dumps({"scenario": scenario.name, "step": scenario.h, "versions": versions()}),
        "units": json.dumps({name: told["unit"] for name, told in known.items()}),
    }
    beside = path.with_name(f".{path.name}")  # whoever is killed while writing leaves a whole file, or none
    pq.write_table(pa.Table.from_arrays([*columns.values()], schema=pa.schema(fields, provenance)), beside)
    beside.replace(path)


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
    """Texts, or bytes: one after the other, and where each begins."""
    if not len(values):
        return pa.nulls(0)
    kind = pa.large_string() if isinstance(values[0], str) else pa.large_binary()
    parts = [value.encode() if isinstance(value, str) else value for value in values]
    begins = np.cumsum([0, *map(len, parts)], dtype=np.int64)
    return pa.Array.from_buffers(kind, len(parts), [None, pa.py_buffer(begins), pa.py_buffer(b"".join(parts))])


def _bits(values: np.ndarray[Any, Any]) -> pa.Buffer:
    return pa.py_buffer(np.packbits(values, bitorder="little"))


def _descriptions(system: System) -> dict[str, dict[str, str]]:
    found: dict[str, dict[str, str]] = {}
    for unit, source in system.units.items():
        for variable in source.interface.outputs:
            q = variable.quantity
            told = {"unit": q.unit, "description": q.description}
            if q.type is Type.ENUMERATION and q.enumeration is not None:
                told["items"] = json.dumps({item.name: item.value for item in q.enumeration})
            found |= {f"{unit}.{element}": told for element in variable.elements}
    return found


def read_columns(path: Path) -> dict[str, Any]:
    """All rows of a run, column by column; people rather use `pandas.read_parquet`."""
    table = pq.ParquetFile(path).read()
    return {name: _values(table.column(name)) for name in table.column_names}


def _values(column: pa.ChunkedArray) -> np.ndarray[Any, Any]:
    kind = column.type
    if pa.types.is_boolean(kind) and not column.null_count:
        return np.array(column.to_pylist(), dtype=bool)
    if column.null_count or not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):  # texts and bytes
        found = np.empty(len(column), dtype=object)
        found[:] = column.to_pylist()
        return found
    dtype = np.dtype(kind.to_pandas_dtype())
    parts = [np.frombuffer(c.buffers()[1], dtype, len(c), c.offset * dtype.itemsize) for c in column.chunks if len(c)]
    return np.concatenate(parts) if parts else np.zeros(0, dtype)
