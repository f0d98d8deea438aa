"""A Dask cluster as the workforce of a sweep (the extra `cluster`)."""
# pyright: basic
# distributed carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from concurrent.futures import Executor, Future
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.results.provenance import own_version

if TYPE_CHECKING:
    from distributed import Client

    from orchestrator.sweeping.engine import Workforce

_ANSWERS_WITHIN: Final = 10
"""[s] The time that a scheduler has to answer."""
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
    return Workforce(lambda _: _Cluster(client), jobs or threads, is_here=False, replaceable=False, words=words)


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

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self._executor.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - as the base
        self._executor.shutdown(wait=wait and not cancel_futures)
        self._client.close()
