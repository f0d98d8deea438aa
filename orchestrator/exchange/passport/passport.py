"""The passport of an FMU: every line, measured one after the other."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import Problem, RequestError, refuse
from components.interfaces.progress import SILENT, Progress
from fmus.reading.archive import Archive
from fmus.toolchain.platform_names import platform_tuple
from orchestrator.exchange.check import opened
from orchestrator.exchange.passport import (
    concurrency,
    cost,
    declarations,
    determinism,
    drive,
    dynamics,
    faults,
    feedthrough_measured,
    fit_lines,
    identity,
    loading_here,
    smoke_tests,
    validation,
)
from orchestrator.exchange.passport.bench import STAGE_PATIENCE, Bench
from orchestrator.exchange.passport.passport_line import GROUPS, Line, Mark, Topic
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.results.provenance import now, versions
from orchestrator.scenario.requested_fmus import RequestedFmus
from orchestrator.system.source import Fmu

SCHEMA: Final = 1
"""The version of the JSON; it changes when keys get another meaning, or go."""

_MEASURED: Final[Sequence[Topic]] = (
    determinism.PROCESSES,
    determinism.AGAIN,
    determinism.RESET,
    determinism.RESTORED,
    determinism.SERIALIZED,
    determinism.INTERLEAVED,
    determinism.THREADS,
    feedthrough_measured.DECLARED,
    dynamics.CONVERGENCE,
    dynamics.OWN_STEP,
    dynamics.MACRO,
    cost.STEP_TIME,
    cost.MEMORY,
    faults.AT_LIMITS,
    faults.NOT_A_NUMBER,
)
"""The lines of an FMU that runs."""


@dataclass(frozen=True)
class Passport:
    """What an FMU is and how it behaves."""

    identity: Mapping[str, Any]
    lines: tuple[Line, ...]
    provenance: Mapping[str, Any]
    pictures: tuple[bytes, ...] = ()
    """Pictures of the drive (PNG), which the JSON does not have."""

    @property
    def good(self) -> bool:
        """Whether no line fails."""
        return all(line.mark is not Mark.FAILS for line in self.lines)

    def count(self, mark: Mark) -> int:
        """The number of lines with a mark."""
        return sum(line.mark is mark for line in self.lines)

    def data(self) -> dict[str, Any]:
        """The passport as plain data."""
        return {
            "schema": SCHEMA,
            "file": self.identity["file"],
            "passes": self.good,
            "counts": {mark.value: self.count(mark) for mark in Mark},
            "identity": dict(self.identity),
            "lines": [line.data() for line in self.lines],
            "provenance": dict(self.provenance),
        }


def passport(path: Path, progress: Progress = SILENT, patience: float = STAGE_PATIENCE) -> Passport:
    """Measure an FMU. Nothing of it runs in this process.

    Args:
        path: The FMU, or the mapping file (`.toml`) of one.
        progress: Receives reports on what is being measured.
        patience: The time [s] that each stage of a measurement may take.

    Raises:
        RequestError: There is no such file, or it is neither of both.
    """
    if path.suffix not in {".fmu", ".toml"} or not path.is_file():
        found = "no such file" if not path.is_file() else f"a file ending in `{path.suffix}`"
        raise refuse(str(path), found, "an .fmu, or the .toml that maps one")
    began = time.monotonic()
    mapping = read_mapping(path) if path.suffix == ".toml" else None
    where = path if mapping is None else mapping.fmu
    if where is None:
        raise refuse(f"{path}: fmu", "nothing", "the path of the FMU, relative to this file")
    fmu = RequestedFmus(progress=progress).fmu(str(where))
    progress.now("checking the rules of FMI")
    archive, broken = _opened(fmu)
    known = identity.file_facts(fmu.path)
    lines = validation.lines(fmu.path, broken)
    images: list[bytes] = []
    if archive is None:
        why = f"it cannot be opened: see {validation.OPENS.key}"
        topics = (loading_here.LOADS, loading_here.EXPORTED, loading_here.FIRST_STEP, *_MEASURED)
        lines += [topic.does_not_apply(why) for topic in (*topics, declarations.STARTS, declarations.DECLARED_LIMITS)]
    else:
        known |= identity.facts(archive)
        with Bench(archive, lenient=bool(broken), patience=patience) as bench:
            measured, images = _measured(bench, path, mapping, progress, lenient=bool(broken))
        lines += measured
    order = list(GROUPS)
    lines.sort(key=lambda line: order.index(line.group))
    return Passport(known, tuple(lines), _provenance(time.monotonic() - began), tuple(images))


def _opened(fmu: Fmu) -> tuple[Archive | None, Sequence[Problem]]:
    """The FMU, read leniently where it breaks rules; None where it cannot be read at all."""
    try:
        return opened(fmu)
    except RequestError as error:
        return None, error.problems


def _measured(
    bench: Bench, path: Path, mapping: MappingFile | None, progress: Progress, *, lenient: bool
) -> tuple[list[Line], list[bytes]]:
    """All lines but those about the rules, and the pictures of the drive."""
    lines = declarations.lines(bench.archive)
    progress.now("loading the library and making the first step")
    loading, runs = loading_here.lines(bench)
    lines += loading
    if runs:
        lines += _behaviour(bench, progress)
    else:
        lines += [topic.does_not_apply("it does not run here: see the lines about its library") for topic in _MEASURED]
    progress.now("running the smoke tests that it carries")
    lines += smoke_tests.lines(bench, runs=runs)
    fitted = fit_lines.fittings(bench.archive, mapping)
    lines.append(fit_lines.line(fitted))
    plant = fitted.get(drive.SOCKET)
    why_not = None
    if plant is None or plant.problems:
        why_not = f"it does not fit the socket {drive.SOCKET}"
    elif not runs:
        why_not = "it does not run here"
    progress.now(f"driving `{drive.SCENARIO}`")
    driven, images = drive.lines(path, why_not, lenient=lenient)
    return [*lines, *driven], images


def _behaviour(bench: Bench, progress: Progress) -> list[Line]:
    """The lines about an FMU that runs."""
    progress.now("driving it in two processes")
    baseline, lines = determinism.driven(bench)
    if baseline is None:
        why = f"it does not get through the course: see {determinism.PROCESSES.key}"
        others = [t for t in _MEASURED if t.key.partition(".")[0] in ("determinism", "state", "instances")][1:]
        lines += [topic.does_not_apply(why) for topic in others]
    else:
        progress.now("resetting it, and going back to saved states")
        lines += determinism.lines(bench, baseline)
        progress.now("stepping two instances at once")
        lines += concurrency.lines(bench, baseline)
    progress.now("moving its inputs one by one")
    lines += feedthrough_measured.lines(bench)
    progress.now("halving its step")
    lines += dynamics.lines(bench)
    progress.now("making 10 000 steps")
    lines += cost.lines(bench)
    progress.now("trying its limits")
    lines += faults.lines(bench)
    return lines


def _provenance(seconds: float) -> dict[str, Any]:
    """What the figures depend on: the versions, and the machine without its name."""
    return {
        "versions": versions(),
        "machine": {
            "platform": platform_tuple(),
            "system": f"{platform.system()} {platform.release()}",
            "processor": _processor(),
            "cores": os.cpu_count(),
        },
        "made": now(),
        "duration": {"value": round(seconds, 1), "unit": "s"},
    }


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text("utf-8", "replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
