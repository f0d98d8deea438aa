"""The process that reads parquet files of unknown state, and hands their rows on in the plain form of Arrow."""
# pyright: basic
# pyarrow carries no types.

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from fmus.toolchain.asked_library import answer


def _convert(source: str, target: str) -> None:
    whole = Path(source).is_file()  # its errors name no file, and so does the message
    table = pq.ParquetFile(source).read(use_threads=False) if whole else pq.read_table(source, use_threads=False)
    table.validate(full=True)
    columns = [_plain(column) for column in table.columns]
    fields = [pa.field(f.name, c.type, metadata=f.metadata) for f, c in zip(table.schema, columns, strict=True)]
    plain = pa.Table.from_arrays(columns, schema=pa.schema(fields, table.schema.metadata))
    with pa.OSFile(target, "wb") as file, pa.ipc.new_file(file, plain.schema) as writer:
        writer.write_table(plain)


def _plain(column: pa.ChunkedArray) -> pa.ChunkedArray:
    """A column without a dictionary of its values."""
    return column.cast(column.type.value_type) if pa.types.is_dictionary(column.type) else column


if __name__ == "__main__":
    answer(_convert)
