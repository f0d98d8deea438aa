"""The varied set in the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def varied_section(varied: Mapping[str, Any]) -> Iterator[str]:
    """Ranges, distributions and verdicts."""
    yield f"## {varied['count']} variations"
