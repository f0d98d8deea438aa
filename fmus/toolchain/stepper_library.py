"""The library of the native stepper: compiled once for this machine, and kept in the user's cache."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import hashlib
import threading
from contextlib import suppress
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

from fmus.toolchain.compiler import FLAGS, BuildError, find_compiler
from fmus.toolchain.kept_libraries import keep, kept_library
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.scratch import scratch_folder

_SOURCE: Final = "stepper.c"
_FLAGS: Final = ("-O3", *FLAGS[1:])
"""It has loops that are worth it, and is compiled once."""
_loading = threading.Lock()
_loaded: list[StepperLibrary] = []


@dataclass(frozen=True)
class StepperLibrary:
    """The library, or why there is none."""

    library: ctypes.CDLL | None
    reason: str = ""
    """In words; empty where there is the library, or no compiler, without which nothing is expected of it."""


def stepper_library() -> StepperLibrary:
    """The library of the native stepper, looked for once per process."""
    with _loading:
        if not _loaded:
            _loaded.append(_load())
        return _loaded[0]


def _load() -> StepperLibrary:
    try:
        return StepperLibrary(_library())
    except (OSError, BuildError) as error:
        return StepperLibrary(None, str(error).splitlines()[0])


def _library() -> ctypes.CDLL | None:
    """The library, from the cache or compiled now; None without a compiler. Raises `OSError` and `BuildError`."""
    compiler = find_compiler()
    if compiler is None:
        return None
    source = (files("fmus") / "runtime" / _SOURCE).read_bytes()
    stamp = f"{platform_tuple()} {compiler.identity} {_FLAGS}".encode()
    kept = kept_library(hashlib.sha256(stamp + source).hexdigest()[:32])
    if kept.is_file():
        with suppress(OSError):  # one that is damaged is compiled again
            return ctypes.CDLL(str(kept))
    with scratch_folder("stepper") as folder:
        place = Path(folder) / _SOURCE
        place.write_bytes(source)
        library = place.with_suffix(".so")
        compiler.link([compiler.compile(place, place.parent, _FLAGS)], library)
        with suppress(OSError):  # without a cache, it is compiled in each process
            keep(library, kept)
        return ctypes.CDLL(str(library))
