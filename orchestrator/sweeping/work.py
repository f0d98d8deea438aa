"""The work on variants, which is one function in every thread, process or cluster worker: `run_batch`.

What is needed for a sweep is prepared once in each process: the scenario is loaded, its simulations are opened, and
then reset for each variant. A variant that ends in a fault is a result with a fault, and costs no other.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import RequestError, refuse
from fmus.toolchain.compiler import BuildError
from orchestrator.loading import load
from orchestrator.results.metrics import Chosen
from orchestrator.results.provenance import own_version
from orchestrator.results.summary import measured
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulation_of
from orchestrator.sweeping.journal import VariantResult, write_journal
from orchestrator.sweeping.kept_scenario import KeptScenario
from orchestrator.sweeping.plan import Variant, options_of
from orchestrator.sweeping.watched_signals import UNWATCHED, WatchedSignals
from orchestrator.system.experiment import Scenario


@dataclass(frozen=True)
class SweepTask:
    """What a worker has to know of a sweep."""

    key: str
    """Names the sweep."""
    scenario: str
    """What is run; a file by its absolute path."""
    options: Options
    """What is changed in all variants."""
    journal: str | None = None
    """The folder in which a worker writes what is done, before it reports; None where it cannot be reached."""
    watched: WatchedSignals = UNWATCHED
    """The signals that are kept."""
    files: tuple[str, ...] = ()
    """The files that workers on other machines need, by their absolute paths."""
    version: str = field(default_factory=own_version)
    """The version of macrostep, which workers must have as well."""


def run_batch(task: SweepTask, variants: Sequence[Variant]) -> list[VariantResult]:
    """Run some variants, one after the other.

    Args:
        task: The sweep.
        variants: The variants.

    Returns:
        Their results, in the same order; each is in the journal when the next one begins.
    """
    runner = _runner(task)
    results: list[VariantResult] = []
    for variant in variants:
        results.append(runner.run(variant))
        if task.journal is not None:
            write_journal(Path(task.journal), results[-1:])
    return results


def begin(task: SweepTask) -> None:
    """Prepare a worker, so that its first variant does not wait for it; whatever is wrong shows with the variants."""
    _runner(task)


def end(task: SweepTask) -> None:
    """Close what this process holds for a sweep, where it has worked on it itself."""
    with _STARTING:
        if (runner := _RUNNERS.pop(task.key, None)) is not None:
            runner.close()


def leave_signals() -> None:
    """Leave Ctrl-C to the process that asked for the sweep: it ends its workers in order."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


_RUNNERS: Final[dict[str, _Runner]] = {}
_STARTING: Final = threading.Lock()


def _runner(task: SweepTask) -> _Runner:
    if task.version != (mine := own_version()):  # workers of a cluster come and go while a sweep runs
        found, valid = f"a worker with macrostep {mine}", f"macrostep {task.version}"
        raise refuse("cluster", found, valid, "Install the same version on all machines, and go on with the sweep.")
    with _STARTING:
        if task.key not in _RUNNERS:
            for runner in _RUNNERS.values():  # a cluster's workers outlive sweeps
                runner.close()
            _RUNNERS.clear()
            _RUNNERS[task.key] = _Runner(task)
        return _RUNNERS[task.key]


class _Runner:
    """Runs the variants of one sweep in this process."""

    def __init__(self, task: SweepTask) -> None:
        self._task = task
        self._prepared: dict[tuple[tuple[str, str], ...], KeptScenario] = {}
        self._preparing = threading.Lock()

    def run(self, variant: Variant) -> VariantResult:
        began = time.perf_counter()

        def result(measured: Mapping[str, Any], fault: str = "", cause: str = "") -> VariantResult:
            return VariantResult(
                variant.number,
                time.perf_counter() - began,
                measured.get("metrics", {}),
                measured.get("verdicts", {}),
                fault,
                cause or fault,
                measured.get("signals", {}),
            )

        try:
            content, ended = self._simulated(variant)
        except RequestError as error:
            return result({}, f"refused: {error}".replace("\n", "; "))
        except BuildError as error:
            return result({}, f"not built: {error}")
        except SimulationError as error:  # a unit that cannot be opened or initialised
            return result({}, str(error), _cause(error))
        return result(content) if ended is None else result(content, str(ended), _cause(ended))

    def close(self) -> None:
        """Close all simulations that are open."""
        for prepared in self._prepared.values():
            prepared.pool.close()

    def _simulated(self, variant: Variant) -> tuple[dict[str, Any], SimulationError | None]:
        prepared = self._prepare(variant.fillings)
        changes = prepared.changes(variant.settings)
        if changes is None:  # the file of a unit has to be looked at again
            scenario = load(self._task.scenario, options_of(self._task.options, variant))
            with simulation_of(scenario) as simulation:
                return self._run(variant.number, scenario, simulation)
        values, scene = changes
        with prepared.pool.simulation(values) as simulation:
            scenario = replace(prepared.scenario, system=simulation.system, scene=scene)
            return self._run(variant.number, scenario, simulation)

    def _prepare(self, fillings: Mapping[str, str]) -> KeptScenario:
        key = tuple(sorted(fillings.items()))
        with self._preparing:
            if key not in self._prepared:
                options = options_of(self._task.options, Variant(0, (), fillings))
                self._prepared[key] = KeptScenario(load(self._task.scenario, options))
            return self._prepared[key]

    def _run(
        self, number: int, scenario: Scenario, simulation: Simulation
    ) -> tuple[dict[str, Any], SimulationError | None]:
        ended: SimulationError | None = None
        try:
            simulation.run()
        except SimulationError as error:
            ended = error
        if simulation.log.kept == 0:
            return {}, ended
        rows = Chosen(simulation.columns(), ("time", *simulation.log.at_every_tick))
        return {**measured(scenario, rows), "signals": self._task.watched.taken(number, rows)}, ended


def _cause(error: SimulationError) -> str:
    return f"{error.unit}: {error.reason}" if error.unit else error.reason


def in_batches(variants: Iterator[Variant], size: Callable[[], int]) -> Iterator[list[Variant]]:
    """Variants in batches, each as large as `size` says when it begins."""
    batch: list[Variant] = []
    wanted = size()
    for variant in variants:
        batch.append(variant)
        if len(batch) >= wanted:
            yield batch
            batch, wanted = [], size()
    if batch:
        yield batch
