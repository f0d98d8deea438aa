"""The series of a recording, read back from its file."""
# pyright: basic
# rerun's reader carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rerun.chunk import RrdReader


def read_series(path: Path) -> dict[str, tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Every series of a recording.

    Args:
        path: The file `recording.rrd`.

    Returns:
        By entity the ticks `(n,)` in ascending order, each once, and the values `(n, elements)` at these ticks.
    """
    chunks: dict[str, list[tuple[Any, Any]]] = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names and not chunk.is_static:
            values = np.array(batch.column("Scalars:scalars").to_pylist(), dtype=float)
            ticks = np.array(batch.column("tick").cast("int64").to_pylist(), dtype=np.int64)
            chunks.setdefault(chunk.entity_path, []).append((ticks, values))
    series: dict[str, tuple[NDArray[np.int64], NDArray[np.float64]]] = {}
    for entity, parts in chunks.items():
        ticks, first = np.unique(np.concatenate([ticks for ticks, _ in parts]), return_index=True)
        series[entity] = ticks, np.concatenate([values for _, values in parts])[first]
    return series
