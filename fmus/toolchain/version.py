"""The versions of FMI that are written and read."""

from __future__ import annotations

from enum import IntEnum
from typing import Final


class Version(IntEnum):
    """A version of the Functional Mock-up Interface."""

    FMI1 = 1
    FMI2 = 2
    FMI3 = 3


WRITTEN_VERSIONS: Final = (Version.FMI2, Version.FMI3)
"""The versions that blocks are exported as; FMI 1.0 is read only."""
