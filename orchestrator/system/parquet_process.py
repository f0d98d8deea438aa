"""The process that reads a parquet file of unknown state, and hands its rows on in the plain form of Arrow."""
# pyright: basic
# pyarrow carries no types.

from __future__ import annotations

from fmus.toolchain.asked_library import answer_once


def main() -> None:
    """Read one file, or a folder of parts."""
    answer_once(_rows)


def _rows(path: str) -> bytes:
    import pyarrow as pa  # noqa: PLC0415 - it counts as reading the file, with the limits of that
    import pyarrow.parquet as pq  # noqa: PLC0415

    table = pq.read_table(path, use_threads=False)
    table.validate(full=True)
    plain = [(field, _plain(column)) for field, column in zip(table.schema, table.columns, strict=True)]
    fields = [pa.field(field.name, column.type, metadata=field.metadata) for field, column in plain]
    table = pa.Table.from_arrays([column for _, column in plain], schema=pa.schema(fields, table.schema.metadata))
    target = pa.BufferOutputStream()
    with pa.ipc.new_stream(target, table.schema) as writer:
        writer.write_table(table)
    return target.getvalue().to_pybytes()


def _plain(column):
    """A column without a dictionary of its values."""
    import pyarrow as pa  # noqa: PLC0415

    return column.cast(column.type.value_type) if pa.types.is_dictionary(column.type) else column


if __name__ == "__main__":
    main()
