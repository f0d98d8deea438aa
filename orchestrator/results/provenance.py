"""What ran: the versions that a result can depend on."""

from __future__ import annotations

import platform
from importlib import metadata
from typing import Final

_LIBRARIES: Final = ("casadi", "fmpy", "numpy", "pandas", "rerun-sdk")


def versions() -> dict[str, str]:
    """What ran: macrostep, Python and the libraries that a result can depend on."""
    found = {"macrostep": own_version(), "python": platform.python_version()}
    return found | {name: metadata.version(name) for name in _LIBRARIES}


def own_version() -> str:
    """The version of macrostep, also when it runs from a checkout without being installed."""
    try:
        return metadata.version("macrostep")
    except metadata.PackageNotFoundError:
        return "0 (not installed)"
