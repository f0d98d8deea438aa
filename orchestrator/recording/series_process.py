"""The process that reads the series of recordings of unknown state, and hands them on as plain arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fmus.toolchain.asked_library import answer
from orchestrator.recording.series_reader import read_series


def _convert(source: str, target: str) -> None:
    series = read_series(Path(source))
    arrays = {f"{k}{i}": part for i, parts in enumerate(series.values()) for k, part in zip("tv", parts, strict=True)}
    with Path(target).open("wb") as file:
        np.savez(file, allow_pickle=False, names=np.array([*series], dtype=np.str_), **arrays)


if __name__ == "__main__":
    answer(_convert)
