"""Building FMUs: a block's C is generated and compiled once for both versions of FMI, and only when it has changed."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from components.interfaces.block import Block
from components.interfaces.maths import Array
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from components.interfaces.progress import SILENT, Progress
from fmus.export.compilation import Compilation
from fmus.export.fingerprint import Stamp, stamp
from fmus.toolchain.archives import writable_folder
from fmus.toolchain.compiler import BuildError, Compiler, find_compiler, required_compiler
from fmus.toolchain.scratch import scratch_folder
from fmus.toolchain.version import Version

__all__ = ["BuildError", "Built", "build", "build_all"]


@dataclass(frozen=True)
class Built:
    """An FMU that is up to date, and whether it had to be built."""

    path: Path
    rebuilt: bool


@dataclass(frozen=True)
class _Job:
    block: type[Block[Any, Any, Any]]
    version: Version
    start: Array
    path: Path
    stamp: Stamp | None


def build(block: type[Block[Any, Any, Any]], version: Version, start: Mapping[str, Any], folder: Path) -> Built:
    """Build `folder/fmi2/NAME.fmu` or `folder/fmi3/NAME.fmu`, unless it is there and up to date.

    Args:
        block: The block.
        version: The version of FMI.
        start: The start value of every parameter, by its name.
        folder: The folder of all FMUs.

    Raises:
        RequestError: A start value is wrong, the folder cannot be written to, or there is no compiler.
        BuildError: The compiler fails.
    """
    return build_all([(block, version, start)], folder, SILENT)[0]


def build_all(
    requests: Sequence[tuple[type[Block[Any, Any, Any]], Version, Mapping[str, Any]]],
    folder: Path,
    progress: Progress,
) -> list[Built]:
    """Build several FMUs on all cores.

    Args:
        requests: Block, version of FMI and start values of each FMU, as `build` takes them.
        folder: The folder of all FMUs.
        progress: Receives a report on each FMU that had to be built.

    Returns:
        The FMUs in the order of the requests.

    Raises:
        RequestError: As `build` raises it, with the problems of all requests.
        BuildError: The compiler fails.
    """
    raise_if_any(problem for block, _, start in requests for problem in request_problems(block, start))
    available = find_compiler()
    jobs = [_job(block, version, start, folder, available) for block, version, start in requests]
    by_path = {job.path: job for job in jobs}
    raise_if_any(_conflict(job) for job in jobs if not np.array_equal(job.start, by_path[job.path].start))
    stale = [
        job
        for job in by_path.values()
        if job.stamp is None or not job.stamp.fits(job.path, with_compiler=available is not None)
    ]
    if stale:
        compiler = required_compiler("run blocks in this process: macrostep run SCENARIO --blocks")
        for parent in dict.fromkeys(job.path.parent for job in stale):
            writable_folder(parent)
        _build(stale, compiler, progress)
    rebuilt = {job.path for job in stale}
    return [Built(job.path, job.path in rebuilt) for job in jobs]


def _conflict(job: _Job) -> Problem:
    remedy = "Build one, and set the other's parameters when it is used."
    return Problem(
        str(job.path), "two requests with different start values", "one set of start values for a file", remedy
    )


def request_problems(block: type[Block[Any, Any, Any]], start: Mapping[str, Any]) -> list[Problem]:
    """The reasons why a block with these start values cannot become an FMU."""
    if block.native:
        return start_problems(block, start)
    found = "equations that call a library, which do not become C"
    return [Problem(f"block `{block.name}`", found, "a native block", "Run it so: macrostep run SCENARIO --blocks.")]


def start_problems(block: type[Block[Any, Any, Any]], start: Mapping[str, Any]) -> list[Problem]:
    """The problems of the start values that are given to a block's parameters."""
    declared = {v.name: v.quantity for v in block.parameters()}
    problems = [
        Problem(f"{block.name}.{name}", "no value", q.range, "Parameters have no default: give it a start value.")
        for name, q in declared.items()
        if name not in start
    ]
    for name, value in start.items():
        if name in declared:
            problems += declared[name].problems(f"{block.name}.{name}", value)
        else:
            remedy = did_you_mean(name, declared)
            problems.append(Problem(f"{block.name}.{name}", "an unknown parameter", choices(declared), remedy))
    return problems


def _job(
    block: type[Block[Any, Any, Any]],
    version: Version,
    start: Mapping[str, Any],
    folder: Path,
    compiler: Compiler | None,
) -> _Job:
    values = [np.ravel(np.asarray(start[v.name], dtype=float)) for v in block.parameters()]
    column = np.concatenate(values) if values else np.zeros(0)
    path = folder / f"fmi{version}" / f"{block.name}.fmu"
    return _Job(block, version, column, path, stamp(block, version, column, compiler))


def _build(jobs: Sequence[_Job], compiler: Compiler, progress: Progress) -> None:
    """Generate C in this thread, because CasADi is not thread-safe, while other threads compile what is generated."""
    alike: dict[tuple[Any, bytes], list[_Job]] = {}
    for job in sorted(jobs, key=lambda job: not job.block.staged):  # the long compilations first
        alike.setdefault((job.block, job.start.tobytes()), []).append(job)
    pool = ThreadPoolExecutor(os.cpu_count())
    with scratch_folder("build") as temporary:
        try:
            compilation = Compilation(Path(temporary), compiler, pool, {job.version for job in jobs})
            blocks = [(compilation.compile_block(group[0].block, group[0].start), group) for group in alike.values()]
            # All compilations are queued before the tasks that wait for them, which could fill the pool otherwise; what
            # takes longest is waited for last.
            written = [
                (job, compilation.write_fmu(block, job.version, job.path, job.stamp))
                for block, group in reversed(blocks)
                for job in group
            ]
            for job, done in written:
                done.result()
                progress.done(f"built {job.block.name} for FMI {job.version}.0")
        finally:
            pool.shutdown(cancel_futures=True)
