"""The opening of several units at once."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from contextlib import contextmanager

from orchestrator.system.source import UnitSource


@contextmanager
def opening(sources: Iterable[UnitSource]) -> Generator[None]:
    """Prepare for the units that are opened in a `with` statement: their processes start at the same time."""
    number = sum(source.describe().isolated is not None for source in sources)
    if number < 2:  # noqa: PLR2004 - one alone starts when it is opened
        yield
        return
    from fmus.units.unit_process import started_processes  # noqa: PLC0415 - only units in processes need it

    with started_processes(number):
        yield
