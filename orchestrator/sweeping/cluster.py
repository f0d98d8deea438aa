"""A Dask cluster as the workforce of a sweep (the extra `cluster`)."""
# pyright: basic
# distributed carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.problem import Problem, raise_if_any, refuse
from components.interfaces.progress import Progress
from orchestrator.results.provenance import own_version
from orchestrator.sweeping.sent_files import SentFiles, read_files
from orchestrator.sweeping.work import SweepTask

if TYPE_CHECKING:
    from distributed import Client

    from orchestrator.sweeping.engine import Workforce

_ANSWERS_WITHIN: Final = 10
"""[s] The time that a scheduler has to answer."""
_WITHOUT_WORKERS: Final = 30.0
"""[s] The time after which a cluster without workers is given up."""
_TRIES: Final = 3
"""How often a batch is given to another worker after one was lost."""


def dask_workforce(on: str, jobs: int | None, progress: Progress) -> Workforce:
    """The workers of a cluster.

    Args:
        on: The address of its scheduler, or the file of a cluster that is started for the sweep.
        jobs: How many batches are under way at once; as many as the cluster has threads if not given.
        progress: Is told when workers are waited for.

    Raises:
        RequestError: distributed is not installed, nobody answers, there are no workers, or they have another version.
    """
    from orchestrator.sweeping.engine import ON, Workforce  # noqa: PLC0415 - that module leads here

    where = f"{ON} {on}"
    try:
        import distributed  # noqa: PLC0415 - an extra
    except ImportError:
        raise refuse(where, "no distributed", "the extra `cluster`", "pip install 'macrostep[cluster]'") from None
    client, ends = _reached(on, where, progress)
    try:
        workers = _workers(client)
        raise_if_any(_strangers(client, where) if workers else [_empty(where, on)])
    except BaseException:
        ends()
        raise
    watch = _Watch(client, where, workers)
    return Workforce(
        lambda _: _Cluster(client, ends),
        jobs or watch.threads,
        is_here=False,
        replaceable=False,
        words=f"{len(workers)} workers of {on}",
        capacity=None if jobs else lambda: max(1, watch.threads),
        did_it=lambda error: isinstance(error, distributed.KilledWorker),
        lost=watch.lost,
    )


def _reached(on: str, where: str, progress: Progress) -> tuple[Client, Callable[[], object]]:
    """A client of a cluster, and what ends it; a cluster that somebody else has started goes on then."""
    if "://" not in on:
        from orchestrator.sweeping.cluster_file import start_cluster  # noqa: PLC0415 - an extra

        client, cluster = start_cluster(Path(on), progress)
        return client, lambda: (client.close(), cluster.close())
    from distributed import Client  # noqa: PLC0415 - an extra

    try:
        client = Client(on, timeout=_ANSWERS_WITHIN, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise refuse(where, f"nobody who answers ({reason})", "the address of a Dask scheduler") from None
    return client, client.close


def _workers(client: Client) -> dict[str, int]:
    """The workers of a cluster, and how many threads each has."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    return {address: worker["nthreads"] for address, worker in workers.items()}


class _Watch:
    """Looks which workers a cluster has, and which it has lost."""

    def __init__(self, client: Client, where: str, workers: Mapping[str, int]) -> None:
        self._client, self._where, self._workers = client, where, workers
        self._last = time.monotonic()

    @property
    def threads(self) -> int:
        """How many threads the workers have, as far as it is known."""
        return sum(self._workers.values())

    def lost(self) -> Iterator[str]:
        """A line for each worker that is gone. Raises `RequestError` where there has been none for a while."""
        present = _workers(self._client)
        for worker in sorted(self._workers.keys() - present):
            yield f"the worker {worker} was lost; others take over what it was at"
        self._workers = present
        if present:
            self._last = time.monotonic()
        elif time.monotonic() - self._last > _WITHOUT_WORKERS:
            remedy = "Start some, and go on with the sweep by its folder."
            raise refuse(self._where, f"no worker for {_WITHOUT_WORKERS:g} s", "a cluster with workers", remedy)


def _empty(where: str, address: str) -> Problem:
    return Problem(where, "a cluster without workers", "one with workers", f"Start one: dask worker {address}")


def _strangers(client: Client, where: str) -> list[Problem]:
    """The problems of workers that have no macrostep, or another one."""
    mine = own_version()
    found: Any = client.run(_version)
    remedy = "Install the same version on all machines."
    return [
        Problem(f"{where}: worker {worker}", version, f"macrostep {mine}", remedy)
        for worker, version in found.items()
        if version != f"macrostep {mine}"
    ]


def _version() -> str:
    try:
        from orchestrator.results.provenance import own_version  # noqa: PLC0415 - on the worker

        return f"macrostep {own_version()}"
    except ImportError:
        return "no macrostep"


class _Cluster(Executor):
    """The standard interface of a cluster, which ends as `ends` does."""

    def __init__(self, client: Client, ends: Callable[[], object]) -> None:
        self._client, self._ends = client, ends
        self._executor = client.get_executor(pure=False, retries=_TRIES)
        self._files: Any = None

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        task, *rest = args
        if not task.files:
            return self._executor.submit(fn, task, *rest, **kwargs)
        # Dask gives what was scattered to each worker once; it is lost with the last worker that has it.
        if self._files is None or self._files.status not in ("pending", "finished"):
            self._files = self._client.scatter(read_files(task.files), hash=False)
        return self._executor.submit(_with_files, self._files, fn, replace(task, files=()), *rest, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: ARG002, FBT001, FBT002 - as the base
        self._executor.shutdown(wait=False)  # what is under way is not wanted any more
        self._ends()


def _with_files(files: SentFiles, work: Any, task: SweepTask, *variants: Any) -> Any:
    """Work with the files that were sent, on the worker."""
    return work(files.task(task), *(files.variants(batch) for batch in variants))
