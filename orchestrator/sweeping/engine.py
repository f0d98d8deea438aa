"""Who works on the variants: processes on this machine, threads, a cluster, or any executor of `concurrent.futures`."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import RequestError, refuse
from components.interfaces.progress import SILENT, Progress
from orchestrator.sweeping.journal import VariantResult, read_journal, write_journal
from orchestrator.sweeping.plan import Variant
from orchestrator.sweeping.work import (
    SweepTask,
    begin,
    end,
    in_batches,
    leave_signals,
    run_batch,
)

ON: Final = "--on"
_BATCH: Final = 0.25
"""[s] The time that a batch of variants takes, so that a report on it costs little."""
_LARGEST: Final = 64
"""Variants of a batch at most: so many are in doubt when a process dies."""
_ATTEMPTS: Final = 3
"""How often a variant is run that a cluster loses."""
_AHEAD: Final = 2
"""Batches that wait for each worker."""
_LOOKS_EVERY: Final = 2.0
"""[s] The time between two looks at the workers of a cluster."""
_LOOKS_FOR_PARENT: Final = 0.5
"""[s] The time between two looks whether the process that asked for the sweep lives."""
DIED: Final = "the process that ran it died"


@dataclass(frozen=True)
class Workforce:
    """Who works, and how many at once."""

    make: Callable[[int], Executor]
    """Makes an executor with so many workers."""
    workers: int
    is_here: bool
    """Whether the workers can write to the folder of the sweep."""
    replaceable: bool
    """Whether an executor that broke can be made anew."""
    words: str
    capacity: Callable[[], int] | None = None
    """How many there are now, where that changes."""
    did_it: Callable[[Exception], bool] = lambda _: False
    """Whether an error says that workers have died of the only variant that was run."""
    lost: Callable[[], Iterator[str]] | None = None
    """Gives a line for each worker that was lost since it was asked last; raises an error where none is left."""

    def executor(self) -> Executor:
        """An executor with all workers."""
        return self.make(self.workers)

    def present(self) -> int:
        """How many work at this time."""
        return self.workers if self.capacity is None else self.capacity()


def workforce(on: str | None, jobs: int | None, progress: Progress = SILENT) -> Workforce:
    """Who works.

    Args:
        on: `processes` (the usual), `threads`, the address of a Dask scheduler, `tcp://head:8786`, or a file that says
            which cluster is started, `slurm.toml`.
        jobs: How many work at once; one for each core if not given.
        progress: Is told when workers are waited for.

    Raises:
        RequestError: There is no such workforce, or it cannot be reached.
    """
    if jobs is not None and jobs < 1:
        raise refuse("--jobs", f"{jobs}", "a whole number, 1 or more")
    count = jobs or os.cpu_count() or 1
    if on is None or on == "processes":
        return Workforce(_processes, count, is_here=True, replaceable=True, words=f"{count} processes")
    if on == "threads":
        return Workforce(ThreadPoolExecutor, count, is_here=True, replaceable=False, words=f"{count} threads")
    if "://" in on or on.endswith(".toml"):
        from orchestrator.sweeping.cluster import dask_workforce  # noqa: PLC0415 - an extra

        return dask_workforce(on, jobs, progress)
    valid = "processes, threads, the address of a Dask scheduler, or a file of a cluster"
    raise refuse(f"{ON} {on}", "an unknown workforce", valid)


def of_executor(executor: Executor) -> Workforce:
    """An executor that a person brings, which is not closed."""
    workers = getattr(executor, "_max_workers", None) or os.cpu_count() or 1
    return Workforce(lambda _: _Borrowed(executor), workers, is_here=False, replaceable=False, words="an executor")


class _Borrowed(Executor):
    """An executor of somebody else, which goes on when the sweep has ended."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self._executor.submit(fn, *args, **kwargs)


def _processes(count: int) -> Executor:
    # A forked process would share locks with our threads, and one that `multiprocessing` spawns runs the script that
    # has asked for the sweep once more.
    from loky import backend, process_executor  # noqa: PLC0415 - slow to import

    made: Any = process_executor.ProcessPoolExecutor  # type: ignore[unknown] - loky carries no types
    # Their working folder is that of whoever asks, in which nothing is looked for.
    how = {"context": backend.get_context("loky"), "env": {"PYTHONSAFEPATH": "1"}}  # type: ignore[unknown]
    executor: Executor = made(count, initializer=_in_process, **how)  # type: ignore[unknown]
    return executor


def _in_process() -> None:
    """Begin a worker process, which ends with the one that made it."""
    leave_signals()
    threading.Thread(target=_end_after, args=(os.getppid(),), daemon=True).start()


def _end_after(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOKS_FOR_PARENT)
    os._exit(1)


def _died(variant: Variant) -> VariantResult:
    """The result of a variant of which the process died that ran it."""
    return VariantResult(variant.number, 0.0, {}, {}, DIED, DIED)


class Engine:
    """Runs the variants of a sweep.

    Args:
        task: The sweep.
        force: Who works on it.
        journal: Where what is done is written down.
        progress: Is told of workers that were lost.
    """

    def __init__(self, task: SweepTask, force: Workforce, journal: Path, progress: Progress = SILENT) -> None:
        self._task, self._force, self._journal, self._progress = task, force, journal, progress
        self._seconds = 0.0
        self._executor: Executor | None = None
        self._pending: dict[Future[list[VariantResult]], list[Variant]] = {}

    @contextmanager
    def working(self) -> Generator[None]:
        """Have workers in the block; they get ready at once."""
        self._executor = self._force.executor()
        begun = [self._executor.submit(begin, self._task) for _ in range(self._force.workers)]
        try:
            yield
        finally:
            for future in (*begun, *self._pending):
                future.cancel()
            self._executor.shutdown(wait=True)
            end(self._task)  # threads work in this process

    def run(self, variants: Iterator[Variant]) -> Iterator[VariantResult]:
        """Run variants.

        Args:
            variants: The variants.

        Returns:
            Their results, each when it has come; all of them are in the journal.
        """
        batches = in_batches(variants, self._size)
        pending, more = self._pending, True
        suspects: list[Variant] = []
        while more or pending:
            while more and len(pending) < _AHEAD * self._force.present():
                batch = next(batches, None)
                more = batch is not None
                if batch is not None:
                    pending[self._submit(batch)] = batch
            for future in self._finished(pending) if pending else ():
                batch = pending.pop(future)
                try:
                    yield from self._noted(future.result())
                except BrokenExecutor:
                    lost = [variant for one in (batch, *pending.values()) for variant in one]
                    pending.clear()
                    yield from self._after_death(lost)
                    break
                except RequestError:
                    raise
                except Exception:
                    if self._force.lost is None:
                        raise
                    suspects += batch  # a cluster gives up on all that was on a worker when it died
        for variant in suspects:
            yield from self._noted([self._alone(variant)])

    def _alone(self, variant: Variant) -> VariantResult:
        """The result of a variant that workers of a cluster may have died of, while it runs no other."""
        for attempt in range(_ATTEMPTS):
            future = self._submit([variant])
            try:
                self._finished([future])
                return future.result()[0]
            except RequestError:
                raise
            except Exception as error:
                is_last = attempt == _ATTEMPTS - 1  # what is cancelled was lost, each time with the worker that ran it
                if self._force.did_it(error) or (is_last and isinstance(error, CancelledError)):
                    return _died(variant)
                if is_last:
                    raise
        raise AssertionError("the last attempt returns or raises")

    def _finished(self, pending: Collection[Future[Any]]) -> Collection[Future[Any]]:
        """Wait for the next that is done; meanwhile tell of workers that were lost."""
        while True:
            every = None if self._force.lost is None else _LOOKS_EVERY
            finished, _ = wait(pending, every, FIRST_COMPLETED)
            for line in () if self._force.lost is None else self._force.lost():
                self._progress.done(line)
            if finished:
                return finished

    def _submit(self, batch: list[Variant]) -> Future[list[VariantResult]]:
        assert self._executor is not None  # noqa: S101 - `run` is called in the block of `working`
        try:
            return self._executor.submit(run_batch, self._task, batch)
        except BrokenExecutor as error:  # a worker died while nothing was under way
            failed: Future[list[VariantResult]] = Future()
            failed.set_exception(error)
            return failed

    def _noted(self, results: Sequence[VariantResult]) -> Sequence[VariantResult]:
        for result in results:
            self._seconds += 0.2 * (result.seconds - self._seconds) if self._seconds else result.seconds
        if self._task.journal is None:
            write_journal(self._journal, results)
        return results

    def _size(self) -> int:
        return max(1, min(_LARGEST, int(_BATCH / self._seconds))) if self._seconds else 1

    def _after_death(self, lost: Sequence[Variant]) -> Iterator[VariantResult]:
        """Go on after a worker process has died, with which all others end: who of those in doubt did it?"""
        if not self._force.replaceable:
            raise refuse(ON, f"{self._force.words} that broke while variants were run", "an executor that goes on")
        known = read_journal(self._journal)
        yield from (known[v.number] for v in lost if v.number in known)
        alone: Executor | None = None
        for variant in (v for v in lost if v.number not in known):
            alone = alone or self._force.make(1)
            try:
                yield from self._noted(alone.submit(run_batch, self._task, [variant]).result())
            except BrokenExecutor:
                alone.shutdown(wait=False)
                alone = None
                result = _died(variant)
                write_journal(self._journal, [result])
                yield result
        if alone is not None:
            alone.shutdown()
        if self._executor is not None:
            self._executor.shutdown(wait=False)
        self._executor = self._force.executor()
