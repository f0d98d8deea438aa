"""Parquet files that are sound as files, with other columns, types, values and metadata than anybody expects."""

from __future__ import annotations

import io
from collections.abc import Callable
from random import Random
from typing import Any, Final

import pyarrow as pa
import pyarrow.parquet as pq

from tests.fuzz import hostile
from tests.fuzz.damage import bytes_damaged, repeatedly
from tests.fuzz.hostile import pick

_TYPES: Final[tuple[Callable[[int], pa.Array], ...]] = (
    lambda n: pa.array(["x"] * n),
    lambda n: pa.array([b"\xff"] * n),
    lambda n: pa.array([None] * n, pa.float64()),
    pa.nulls,
    lambda n: pa.array([[1.0, 2.0]] * n),
    lambda n: pa.array([{"a": 1}] * n),
    lambda n: pa.array([True] * n),
    lambda n: pa.array([2**64 - 1] * n, pa.uint64()),
    lambda n: pa.array([10**30] * n, pa.decimal128(38, 2)),
    lambda n: pa.array([0] * n, pa.timestamp("ns", "UTC")),
    lambda n: pa.array([0] * n, pa.duration("us")),
    lambda n: pa.array([1.0] * n, pa.float16()),
    lambda n: pa.array(["a", "b"] * n).slice(0, n).dictionary_encode(),
    lambda n: pa.array([float("nan")] * n),
    lambda n: pa.array([float("inf"), -1e300] * n).slice(0, n),
    lambda n: pa.array(range(n, 0, -1)),
)
"""Columns that stand in the place of others."""


def parquet_damaged(content: bytes, random: Random, others: list[bytes]) -> bytes:
    """A file whose table was changed, or whose bytes were."""
    if random.random() < 0.5:
        return bytes_damaged(content, random, others)
    table = pq.ParquetFile(io.BytesIO(content)).read()

    def once() -> None:
        nonlocal table
        at = random.randrange(table.num_columns)
        kind = random.randrange(6)
        if kind <= 1:
            column = pick(random, _TYPES)(len(table))
            table = table.set_column(at, table.column_names[at], column)
        elif kind == 2:
            names = [*table.column_names]
            names[at] = pick(random, (_text(random), pick(random, names), f"{names[at]} [{_text(random)}]"))
            table = table.rename_columns(names)
        elif kind == 3 and table.num_columns > 1:
            table = table.remove_column(at)
        elif kind == 4:
            table = pick(random, (table.slice(0, 0), table.slice(1), pa.concat_tables([table, table, table])))
        else:
            of_all: Any = {pick(random, ("macrostep", "pandas", "units", "a")): _text(random)}
            fields = [field.with_metadata({"unit": _text(random)}) for field in table.schema]
            table = pa.Table.from_arrays(table.columns, schema=pa.schema(fields, of_all))

    repeatedly(random, once)
    target = io.BytesIO()
    try:
        pq.write_table(table, target)
    except (pa.ArrowException, ValueError):  # a type that parquet does not have
        return bytes_damaged(content, random, others)
    return target.getvalue()


def _text(random: Random) -> str:
    return hostile.text(random).encode("utf-8", "replace").decode()
