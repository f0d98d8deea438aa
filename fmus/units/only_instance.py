"""FMUs of which a process can hold only one instance: the second one is refused before anything of it runs."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from components.interfaces.problem import refuse
from fmus.reading.archive import Archive

_running: set[Path] = set()


@contextmanager
def only_instance(archive: Archive) -> Generator[None]:
    """Be the only one in this process that has an instance of an FMU.

    Args:
        archive: An FMU that says that a process can hold only one.

    Raises:
        RequestError: Another one has an instance.
    """
    file = archive.path.resolve()
    if file in _running:
        found = "an FMU of which this process has an instance already, and which says that it can hold only one"
        remedy = "Close the other one first, or run one of them in a process of its own."
        raise refuse(archive.where, found, "one instance at a time", remedy)
    _running.add(file)
    try:
        yield
    finally:
        _running.discard(file)
