"""The versions of FMI that are written and read."""

from __future__ import annotations

from enum import IntEnum


class Version(IntEnum):
    """A version of the Functional Mock-up Interface."""

    FMI2 = 2
    FMI3 = 3
