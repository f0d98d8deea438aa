"""Why a library is not loaded: the libraries of the system that it needs and that are not here, and their packages."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Collection, Sequence
from typing import Final

from components.interfaces.problem import listed

DEBIAN_PACKAGES: Final = {
    "libblas.so.3": "libblas3",
    "libc++.so.1": "libc++1",
    "libc++abi.so.1": "libc++abi1",
    "libcrypto.so.1.1": "libssl1.1",
    "libcrypto.so.3": "libssl3",
    "libcurl.so.4": "libcurl4",
    "libexpat.so.1": "libexpat1",
    "libgcc_s.so.1": "libgcc-s1",
    "libgfortran.so.3": "libgfortran3",
    "libgfortran.so.4": "libgfortran4",
    "libgfortran.so.5": "libgfortran5",
    "libGL.so.1": "libgl1",
    "libgomp.so.1": "libgomp1",
    "libhdf5_serial.so.103": "libhdf5-103-1",
    "libhdf5_serial.so.310": "libhdf5-310",
    "liblapack.so.3": "liblapack3",
    "libncurses.so.5": "libncurses5",
    "libncurses.so.6": "libncurses6",
    "libomp.so.5": "libomp5",
    "libopenblas.so.0": "libopenblas0",
    "libpython3.11.so.1.0": "libpython3.11",
    "libpython3.12.so.1.0": "libpython3.12",
    "libpython3.13.so.1.0": "libpython3.13",
    "libquadmath.so.0": "libquadmath0",
    "libsqlite3.so.0": "libsqlite3-0",
    "libssl.so.1.1": "libssl1.1",
    "libssl.so.3": "libssl3",
    "libstdc++.so.5": "libstdc++5",
    "libstdc++.so.6": "libstdc++6",
    "libtbb.so.12": "libtbb12",
    "libtbb.so.2": "libtbb2",
    "libtinfo.so.5": "libtinfo5",
    "libtinfo.so.6": "libtinfo6",
    "libuuid.so.1": "libuuid1",
    "libX11.so.6": "libx11-6",
    "libxml2.so.2": "libxml2",
    "libz.so.1": "zlib1g",
    "libzmq.so.5": "libzmq5",
}
"""The package of Debian and Ubuntu that has a library, by the name of its file."""


def not_loaded(reason: str, needed: Sequence[str], beside: Collection[str]) -> tuple[str, str]:
    """What is wrong with a library that the system does not load, and what to do, as parts of a message.

    Args:
        reason: What the loader of the system says.
        needed: The libraries that the library needs, by the names of their files.
        beside: The names of the files in its folder.
    """
    missing = [name for name in needed if not _is_here(name)]
    if missing and (near := [name for name in missing if name in beside]):
        found = f"a library that does not look for {listed(near)} in its own folder"
        return found, "Have it linked with the run path $ORIGIN."
    if missing:
        packages = sorted({DEBIAN_PACKAGES[name] for name in missing if name in DEBIAN_PACKAGES})
        debian = f" (Debian: apt-get install {' '.join(packages)})" if packages else ""
        found = f"a library that needs {listed(missing, len(missing))}, which {'is' if len(missing) == 1 else 'are'}"
        return f"{found} not on this machine", f"Install {'it' if len(missing) == 1 else 'them'}{debian}."
    if match := re.search(r"version `([^']+)' not found", reason):
        found = f"a library that needs {match[1].replace('_', ' ', 1)}, which is newer than that of this machine"
        return found, "Use a newer system, or have it compiled for an older one."
    if match := re.search(r"undefined symbol: (\S+)", reason):
        return f"a library that uses `{match[1]}`, which no library has that it names", "Have it linked completely."
    return f"a library that cannot be loaded ({reason})", "Compile it for this platform."


def _is_here(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True
