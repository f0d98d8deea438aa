"""A Dask cluster as the workforce of a sweep (the extra `cluster`)."""
# pyright: basic
# distributed carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.problem import Problem, raise_if_any, refuse
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


def dask_workforce(address: str, jobs: int | None) -> Workforce:
    """The workers of a cluster.

    Args:
        address: The address of its scheduler.
        jobs: How many batches are under way at once; as many as the cluster has threads if not given.

    Raises:
        RequestError: distributed is not installed, nobody answers, there are no workers, or they have another version.
    """
    from orchestrator.sweeping.engine import ON, Workforce  # noqa: PLC0415 - that module leads here

    where = f"{ON} {address}"
    try:
        from distributed import Client  # noqa: PLC0415 - an extra
    except ImportError:
        raise refuse(where, "no distributed", "the extra `cluster`", "pip install 'macrostep[cluster]'") from None
    try:
        client = Client(address, timeout=_ANSWERS_WITHIN, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise refuse(where, f"nobody who answers ({reason})", "the address of a Dask scheduler") from None
    try:
        workers = client.scheduler_info(n_workers=-1)["workers"]
        raise_if_any(_strangers(client, where) if workers else [_empty(where, address)])
    except BaseException:
        client.close()
        raise
    threads = sum(worker["nthreads"] for worker in workers.values())
    words = f"{len(workers)} workers of {address}"
    return Workforce(
        lambda _: _Cluster(client),
        jobs or threads,
        is_here=False,
        replaceable=False,
        words=words,
        lost=_Watch(client, where, set(workers)).lost,
    )


class _Watch:
    """Looks which workers a cluster has lost."""

    def __init__(self, client: Client, where: str, workers: set[str]) -> None:
        self._client, self._where, self._workers = client, where, workers
        self._last = time.monotonic()

    def lost(self) -> Iterator[str]:
        """A line for each worker that is gone. Raises `RequestError` where there has been none for a while."""
        present: set[str] = set(self._client.scheduler_info(n_workers=-1)["workers"])
        for worker in sorted(self._workers - present):
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
    """The standard interface of a cluster; the client is closed with it, the cluster goes on."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False, retries=_TRIES)
        self._files: Any = None

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        task, *rest = args
        if not task.files:
            return self._executor.submit(fn, task, *rest, **kwargs)
        if self._files is None:  # Dask gives what was scattered to each worker once
            self._files = self._client.scatter(read_files(task.files), hash=False)
        return self._executor.submit(_with_files, self._files, fn, replace(task, files=()), *rest, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - as the base
        self._executor.shutdown(wait=wait and not cancel_futures)
        self._client.close()


def _with_files(files: SentFiles, work: Any, task: SweepTask, *variants: Any) -> Any:
    """Work with the files that were sent, on the worker."""
    return work(files.task(task), *(files.variants(batch) for batch in variants))
