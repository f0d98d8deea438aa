"""Parquet files of unknown state, which pyarrow reads in a process of its own: damaged ones crash it, or hang it."""
# pyright: basic
# pyarrow carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from components.interfaces.problem import refuse
from fmus.toolchain.asked_library import in_plain_form
from fmus.toolchain.door import reading
from fmus.toolchain.scratch import scratch_folder


def read_parquet(path: Path, where: str, valid: str, remedy: str = "") -> Any:
    """All rows of a parquet file, or of a folder of such.

    Args:
        path: The file, or the folder.
        where: What messages call it.
        valid: What it should be, as messages say it.
        remedy: What to do about one that cannot be read.

    Returns:
        The table of pyarrow, whose columns have different names.

    Raises:
        RequestError: It cannot be read.
    """
    with scratch_folder("table") as folder:
        rows = Path(folder) / "rows"
        in_plain_form("orchestrator.system.parquet_process", path, rows, where, valid, remedy)
        import pyarrow as pa  # noqa: PLC0415 - slow to import, and most runs read none

        with reading(where, valid, remedy), pa.OSFile(str(rows), "rb") as file:
            table = pa.ipc.open_file(file).read_all()
    if twice := sorted(str(name) for name, number in Counter(table.column_names).items() if number > 1):
        raise refuse(where, f"two columns `{twice[0]}`", "a name of its own for each column", remedy)
    return table


def joined(tables: Sequence[Any]) -> Any:
    """Tables of pyarrow one below the other; nulls where one lacks a column, or has it with another type."""
    import pyarrow as pa  # noqa: PLC0415

    if len(tables) == 1:
        return tables[0]
    types = {field.name: field.type for table in tables for field in table.schema}
    same = [table.select([field.name for field in table.schema if field.type == types[field.name]]) for table in tables]
    return pa.concat_tables(same, promote_options="default")
