"""The series of a recording of unknown state, which Rerun reads in a process of its own: damaged ones crash it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fmus.toolchain.asked_library import in_plain_form
from fmus.toolchain.door import reading
from fmus.toolchain.scratch import scratch_folder

SeriesOfEntities: TypeAlias = dict[str, tuple[NDArray[np.int64], NDArray[np.float64]]]
"""By entity the ticks `(n,)`, and the values `(n, elements)` at these ticks."""


def kept_series(path: Path, where: str, valid: str, remedy: str = "") -> SeriesOfEntities:
    """Every series of a recording, as `series_reader.read_series` gives them.

    Args:
        path: The file.
        where: What messages call it.
        valid: What it should be, as messages say it.
        remedy: What to do about one that cannot be read.

    Raises:
        RequestError: It cannot be read.
    """
    with scratch_folder("series") as folder:
        plain = Path(folder) / "series.npz"
        in_plain_form("orchestrator.recording.series_process", path, plain, where, valid, remedy)
        with reading(where, valid, remedy), np.load(plain, allow_pickle=False) as arrays:
            names: list[Any] = arrays["names"].tolist()
            return {str(name): (arrays[f"t{i}"], arrays[f"v{i}"]) for i, name in enumerate(names)}
