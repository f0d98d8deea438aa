"""All rows of a run as one parquet file, with units and provenance in its metadata."""
# pyright: basic
# pyarrow carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from components.interfaces.quantity import Type
from orchestrator.provenance import versions
from orchestrator.scenario import Scenario
from orchestrator.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd


def write_signals(frame: pd.DataFrame, scenario: Scenario, path: Path) -> None:
    """All rows as parquet; each column's unit and meaning, and the run's provenance, stand in the metadata."""
    known = {"time": {"unit": "s", "description": "simulated time"}, **_descriptions(scenario.system)}
    table = pa.Table.from_pandas(frame, preserve_index=False)
    for i, name in enumerate(table.column_names):
        field = table.schema.field(i).with_metadata(known[name])
        table = table.set_column(i, field, table.column(i))
    provenance = {
        "macrostep": json.dumps({"scenario": scenario.name, "step": scenario.h, "versions": versions()}),
        "units": json.dumps({name: told["unit"] for name, told in known.items()}),
    }
    pq.write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), **provenance}), path)


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
    """The values without a detour: `read_table` and pyarrow's own conversion to numpy import all of pandas."""
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
