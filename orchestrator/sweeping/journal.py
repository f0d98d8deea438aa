"""The results of variants: of one, of all in columns, and the files in which they stand while a sweep goes on."""

from __future__ import annotations

import os
import threading
import uuid
from array import array
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from math import isnan, nan
from pathlib import Path
from typing import Any, Final

import msgspec

_ID: Final = uuid.uuid4().hex
"""Names this process, also among those of other machines, and those that had its number before."""
_ABSENT: Final = -1
"""Stands for a verdict that a variant does not have; for a metric NaN does, which is never one."""


class VariantResult(msgspec.Struct, frozen=True, omit_defaults=True):
    """What came of a variant."""

    variant: int
    seconds: float
    """[s] The wall time that it took."""
    metrics: dict[str, float]
    verdicts: dict[str, bool]
    fault: str = ""
    """What ended it before its stop time, or why it did not begin; empty if nothing did."""
    cause: str = ""
    """The kind of the fault, by which faults are grouped: the reason without the time."""
    signals: dict[str, bytes] = {}
    """What is kept of the signals that are watched."""


class VariantResults(MutableMapping[int, VariantResult]):
    """Results by the number of the variant, in columns: those of 100 000 variants take some ten megabytes.

    Args:
        results: Results to begin with.
    """

    def __init__(self, results: Mapping[int, VariantResult] | None = None) -> None:
        self._places: dict[int, int] = {}
        self._seconds: array[float] = array("d")
        self._metrics: dict[str, array[float]] = {}
        self._verdicts: dict[str, array[int]] = {}
        self._faults: dict[int, tuple[str, str]] = {}
        self._signals: dict[int, dict[str, bytes]] = {}
        self.update(results or {})

    def __setitem__(self, variant: int, result: VariantResult) -> None:
        place = self._places.setdefault(variant, len(self._places))
        _put({"": self._seconds}, place, {"": result.seconds}, "d", nan)
        _put(self._metrics, place, result.metrics, "d", nan)
        _put(self._verdicts, place, result.verdicts, "b", _ABSENT)
        self._faults.pop(variant, None)
        self._signals.pop(variant, None)
        if result.fault or result.cause:
            self._faults[variant] = result.fault, result.cause
        if result.signals:
            self._signals[variant] = result.signals

    def __getitem__(self, variant: int) -> VariantResult:
        place = self._places[variant]
        metrics = {name: value for name, value in _at(self._metrics, place) if not isnan(value)}
        verdicts = {name: bool(value) for name, value in _at(self._verdicts, place) if value != _ABSENT}
        fault, cause = self._faults.get(variant, ("", ""))
        signals = self._signals.get(variant, {})
        return VariantResult(variant, self._seconds[place], metrics, verdicts, fault, cause, signals)

    def __delitem__(self, variant: int) -> None:
        raise NotImplementedError("what is done stays done")

    def __iter__(self) -> Iterator[int]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    @property
    def signals(self) -> Mapping[int, Mapping[str, bytes]]:
        """What is kept of the signals that are watched, by the number of the variant."""
        return self._signals


def _put(columns: dict[str, Any], place: int, values: Mapping[str, Any], kind: str, absent: float) -> None:
    """Put values into a row of columns, which become long enough for it."""
    for name in values:
        if name not in columns:
            columns[name] = array(kind)
    for name, column in columns.items():
        if (missing := place + 1 - len(column)) > 0:
            column.extend([absent] * missing)
        column[place] = values.get(name, absent)


def _at(columns: Mapping[str, Any], place: int) -> Iterator[tuple[str, Any]]:
    """A row of columns, as far as they are long enough."""
    return ((name, column[place]) for name, column in columns.items() if place < len(column))


def write_journal(folder: Path, results: Sequence[VariantResult]) -> None:
    """Add results to what this thread has done, in a file of its own; a line is there as a whole, or does not count."""
    file = folder / f"{_ID}-{os.getpid()}-{threading.get_ident()}.jsonl"
    with file.open("ab", buffering=0) as stream:
        stream.write(b"".join(msgspec.json.encode(result) + b"\n" for result in results))


def read_journal(folder: Path) -> VariantResults:
    """All results in a journal.

    Args:
        folder: The folder; a line that a killed process has left incomplete is no result.
    """
    found = VariantResults()
    decoder = msgspec.json.Decoder(VariantResult)
    for file in sorted(folder.glob("*.jsonl")):
        with file.open("rb") as lines:
            for line in lines:
                if not line.endswith(b"\n"):
                    continue
                try:
                    result = decoder.decode(line)
                except msgspec.DecodeError:
                    continue
                if result.variant not in found:
                    found[result.variant] = result
    return found
