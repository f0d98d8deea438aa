"""Recordings and tables that the viewer can browse, served by this process on this machine only."""
# pyright: basic
# rerun's catalog carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rerun.server import Server

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

_LOOPBACK: Final = "127.0.0.1"
"""The usual address of Rerun's server is that of all networks."""


class Catalog:
    """What the viewer finds at a URL, until `close`."""

    def __init__(self) -> None:
        self._server = Server(host=_LOOPBACK)
        self._client = self._server.client()

    def add_recordings(self, name: str, recordings: Sequence[Path]) -> list[str]:
        """Add recordings, which look as the first of them says.

        Args:
            name: What they are called together.
            recordings: The files.

        Returns:
            The URL of each.
        """
        dataset = self._client.create_dataset(name)
        files = [recording.resolve().as_uri() for recording in recordings]
        identifiers = dataset.register(files).wait().segment_ids
        dataset.register_blueprint(files[0], set_default=True)
        return [dataset.segment_url(identifier) for identifier in identifiers]

    def add_table(self, name: str, table: pd.DataFrame) -> str:
        """Add a table; a URL in it is a link.

        Args:
            name: What it is called.
            table: The table, in whose names `.` becomes `/`, because the catalog takes it for a part of a structure.

        Returns:
            Its URL.
        """
        import pyarrow as pa  # noqa: PLC0415 - slow to import

        content = pa.Table.from_pandas(table, preserve_index=False)
        content = content.rename_columns([column.replace(".", "/") for column in content.column_names])
        entry = self._client.create_table(name, content.schema.remove_metadata())
        entry.append(content.to_batches())
        return f"{self._server.url()}/entry/{entry.id}"

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
