"""Files that say which cluster is started for a sweep, and ends with it: on Slurm, on Kubernetes, or wherever.

A file names a class of Dask's deployment projects and what it is given::

    cluster = "dask_jobqueue.SLURMCluster"    # or "dask_kubernetes.operator.KubeCluster", or any other
    workers = 160

    [options]                                 # the arguments of that class
    cores = 16
    processes = 16
    memory = "32GB"
"""
# pyright: basic
# distributed carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field

from components.interfaces.problem import did_you_mean, refuse
from components.interfaces.progress import Progress
from orchestrator.system.files import checked, read_toml

if TYPE_CHECKING:
    from distributed import Client

_CLASS: Final = "a class of Dask's projects, such as dask_jobqueue.SLURMCluster"
_LOOKS_EVERY: Final = 5.0
"""[s] The time between two looks whether the first worker is there."""


class ClusterFile(BaseModel):
    """The content of such a file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    cluster: str
    """The class of the cluster, with its module."""
    workers: Annotated[int, Field(ge=1)]
    """How many workers are asked for."""
    options: dict[str, Any] = {}
    """The arguments of the class."""


def start_cluster(path: Path, progress: Progress) -> tuple[Client, Any]:
    """Start a cluster, and wait for the first of its workers, as long as that may take.

    Args:
        path: The file that says which.
        progress: Is told that workers are waited for.

    Returns:
        A client, and the cluster, which whoever asked has to close.

    Raises:
        RequestError: The file is none, or the cluster cannot be started.
    """
    from distributed import Client, TimeoutError  # noqa: A004, PLC0415 - an extra

    content = checked(ClusterFile, read_toml(path), str(path))
    made = _class(content.cluster, path)
    cluster: Any = None
    try:
        cluster = made(**content.options)
        cluster.scale(content.workers)
        client = Client(cluster, set_as_default=False)
    except Exception as error:
        if cluster is not None:
            cluster.close()
        words = " ".join(str(error).split()) or type(error).__name__
        raise refuse(str(path), f"a cluster that does not start ({words})", "options that it takes") from error
    try:
        progress.now(f"waiting for the first of {content.workers} workers of {path.name}")
        while True:
            try:
                client.wait_for_workers(1, timeout=_LOOKS_EVERY)
            except TimeoutError:
                continue
            return client, cluster
    except BaseException:
        client.close()
        cluster.close()
        raise


def _class(name: str, path: Path) -> Any:
    """The class of a cluster. Raises `RequestError`."""
    module, _, wanted = name.rpartition(".")
    where = f"{path}: cluster"
    if not module or not all(part.isidentifier() for part in name.split(".")):
        raise refuse(where, f"`{name}`" + (", without its module" if name.isidentifier() else ""), _CLASS)
    try:
        found = import_module(module)
    except ImportError as error:
        project = module.partition(".")[0].replace("_", "-")
        raise refuse(where, f"`{name}`, which is not installed ({error})", _CLASS, f"pip install {project}") from None
    made = getattr(found, wanted, None)
    if not (isinstance(made, type) and hasattr(made, "scale")):
        known = [n for n, value in vars(found).items() if isinstance(value, type) and hasattr(value, "scale")]
        raise refuse(where, f"`{name}`, which is no cluster", _CLASS, did_you_mean(wanted, known))
    return made
