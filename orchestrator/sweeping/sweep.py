"""Many variants of one scenario, from a request to a folder."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.arguments import checked_arguments
from components.interfaces.interruption import without_interrupts
from components.interfaces.problem import Gathered, RequestError, raise_if_any
from components.interfaces.progress import SILENT, Progress
from orchestrator.execution import Execution, execute
from orchestrator.loading import load
from orchestrator.results.claimed_folder import ClaimedFolder
from orchestrator.scenario.options import UNCHANGED, Options
from orchestrator.sweeping import ranking, sweep_folder
from orchestrator.sweeping.bands import band_table
from orchestrator.sweeping.engine import DIED, Engine, Workforce, of_executor, workforce
from orchestrator.sweeping.journal import VariantResult, VariantResults
from orchestrator.sweeping.plan import PlannedSweep, Variant, iterate, plan
from orchestrator.sweeping.results_table import results_table
from orchestrator.sweeping.search import FailureSearch
from orchestrator.sweeping.sent_files import needed_files
from orchestrator.sweeping.sweep_request import SweepRequest, absolute, completed
from orchestrator.sweeping.tally import Tally
from orchestrator.sweeping.variation import MOST, spelled
from orchestrator.sweeping.work import SweepTask

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

WORST: Final = ("worst:3",)
"""The runs that are kept if nothing else is asked for."""


@dataclass
class Swept:
    """A sweep that has ended, or was interrupted."""

    folder: Path
    planned: PlannedSweep
    results: VariantResults
    """By the number of the variant."""
    is_whole: bool = False
    """Whether all variants are done, and the folder is complete."""
    seconds: float = 0.0
    """[s] The time that it took, with that of before it was stopped."""
    remarks: list[str] = field(default_factory=list[str])
    kept: dict[int, Path] = field(default_factory=dict[int, Path])
    """The run folders of those that are kept, the worst first."""
    found: list[int] = field(default_factory=list[int])
    """Of a search: the worst variant of each kind of failure, the worst first."""
    mildest: int | None = None
    """Of a search: the failing variant that is nearest to the middle of what varies."""


@checked_arguments
def sweep(  # noqa: PLR0913 - what makes a sweep
    scenario: str | Path,
    variations: Mapping[str, Any],
    *,
    samples: str | None = None,
    grid: str | None = None,
    seed: int = 0,
    find: str | None = None,
    budget: str = "60s",
    options: Options = UNCHANGED,
    signals: Sequence[str] = (),
    executor: Executor | None = None,
    out: Path | None = None,
    keep: Sequence[str] | None = None,
    progress: Progress = SILENT,
) -> pd.DataFrame:
    """Run many variants of a scenario, on all cores, and write the folder of a sweep.

    Args:
        scenario: What is run, as `load` takes it.
        variations: What varies: by the path of a parameter or the name of a socket a text (`"1500:2500"`,
            `"log:1e-3:1e-1"`, `"normal:10,0.5"`) or a list of values.
        samples: How it is sampled: `sobol:512`, `lhs:100`, `random:100`, `saltelli:64`, or a table `FILE.csv`.
        grid: The number of values of each variation, in place of `samples`: `"20"`, `"20,5"`.
        seed: The seed of the random numbers.
        find: Failures that are looked for, in place of samples: `"gap_edge < 0"`, `"not inside_road"`, `"fault"`.
        budget: How long they are looked for (`"60s"`), or by how many variants (`"500"`).
        options: What is changed in all variants.
        signals: The signals whose mean and range over all variants are kept; place across the road and speed, if there
            are none.
        executor: Who works: any executor of `concurrent.futures`; a process for each core if not given.
        out: The folder; the next free `runs/NAME-sweep-N` if not given.
        keep: The variants whose run folders are kept: `worst:10`, or numbers; the three worst if not given, and what
            a search finds.
        progress: Receives reports on what is going on.

    Returns:
        A row for each variant: values, metrics, verdicts, fault and time; `attrs["folder"]` is the folder.

    Raises:
        RequestError: Something is wrong with the request; the error has all problems, and nothing was run.
    """
    texts = tuple(f"{path}={spelled(values)}" for path, values in variations.items())
    request = SweepRequest(str(scenario), texts, samples, grid, seed, find, budget, options, tuple(signals))
    done = run_sweep(
        request, lambda: workforce(None, None) if executor is None else of_executor(executor), out, keep, progress
    )
    table = results_table(done.planned, done.results)
    table.attrs["folder"] = str(done.folder)
    return table


def run_sweep(
    request: SweepRequest,
    force: Callable[[], Workforce],
    out: Path | None,
    keep: Sequence[str] | None,
    progress: Progress,
) -> Swept:
    """Begin a sweep and run all its variants.

    Args:
        request: What was asked for.
        force: Gives who works.
        out: The folder, or None.
        keep: The variants whose runs are kept; the worst if not given. A search keeps what it finds as well.
        progress: Receives reports.

    Raises:
        RequestError: As `sweep` does.
    """
    progress.now("getting ready")
    wrong = Gathered()
    planned = wrong.attempt(lambda: plan(absolute(completed(request)), progress), None)
    wrong.attempt(lambda: _check_kept(keep, planned), None)
    workers = wrong.attempt(force, None)
    raise_if_any(wrong.problems)
    assert planned is not None  # noqa: S101 - it would be a problem
    assert workers is not None  # noqa: S101
    with sweep_folder.new_sweep(planned, out) as claimed:
        try:
            return _carried_out(claimed, planned, workers, keep, progress)
        except RequestError:
            if request.find is not None:  # for something that nobody measures
                claimed.abandon()
            raise


def go_on(folder: Path, force: Callable[[], Workforce], keep: Sequence[str] | None, progress: Progress) -> Swept:
    """Go on with a sweep that was stopped; its variants that are done are not run again.

    Args:
        folder: Its folder.
        force: Gives who works.
        keep: The variants whose runs are kept.
        progress: Receives reports.

    Raises:
        RequestError: It is no folder of a sweep, or what it runs is not what it was.
    """
    progress.now("getting ready")
    claimed, planned = sweep_folder.known_sweep(folder)
    with claimed:
        _check_kept(keep, planned)
        return _carried_out(claimed, planned, force(), keep, progress)


def _carried_out(
    claimed: ClaimedFolder, planned: PlannedSweep, force: Workforce, keep: Sequence[str] | None, progress: Progress
) -> Swept:
    folder = claimed.path
    journal = folder / sweep_folder.DONE
    task = SweepTask(uuid.uuid4().hex, planned.request.scenario, planned.request.options, watched=planned.watched)
    if force.is_here:
        task = replace(task, journal=str(journal))
    elif force.lost is not None:  # a cluster, whose machines have other disks
        task = replace(task, files=tuple(needed_files(planned)))
    done = Swept(claimed.named, planned, sweep_folder.results_of(folder, planned), remarks=[*claimed.remarks])
    former, done.seconds = sweep_folder.told_before(folder)
    done.kept = {n: there for n, name in former.items() if (there := folder / sweep_folder.KEPT_RUNS / name).is_dir()}
    tally = Tally(planned, done.results, time.monotonic)
    progress.now(tally)
    engine = Engine(task, force, journal, progress)
    try:
        with engine.working():
            numbers = _worked(engine, done, tally, keep)
        _keep(done, folder, numbers, progress)
        done.is_whole = len(done.results) == len(planned)
    except KeyboardInterrupt:
        done.results = sweep_folder.results_of(folder, planned)  # the workers have ended what they were at
    except RequestError:
        sweep_folder.write_sweep(planned, folder, "interrupted", {"seconds": done.seconds + tally.seconds})
        raise
    done.seconds += tally.seconds
    with without_interrupts():
        progress.now("writing the report")
        _conclude(done, folder)
    return done


def _worked(engine: Engine, done: Swept, tally: Tally, keep: Sequence[str] | None) -> list[int]:
    """Run all variants, or look for failures; return the variants whose runs are kept."""

    def noted(variants: Iterator[Variant]) -> Iterator[VariantResult]:
        for result in engine.run(variants):
            done.results[result.variant] = result
            tally.note(result)
            yield result

    if done.planned.request.find is None:
        for _ in noted(iterate(done.planned, set(done.results))):
            pass
        return ranking.kept(WORST if keep is None else keep, done.results, len(done.planned))
    search = FailureSearch(done.planned, noted)
    try:
        search.go()
    finally:
        done.found, done.mildest = search.distinct(), search.mildest()
    wanted = ranking.kept(keep or (), done.results, len(done.planned))
    return [*dict.fromkeys(n for n in (*done.found, done.mildest, *wanted) if n is not None)]


def _conclude(done: Swept, folder: Path) -> None:
    """Write what is known; of a sweep that was interrupted what it takes to go on."""
    more: dict[str, object] = {"kept": {str(number): path.name for number, path in done.kept.items()}}
    more["seconds"] = round(done.seconds, 3)
    is_search = done.planned.request.find is not None
    if not done.is_whole and not is_search:
        sweep_folder.write_sweep(done.planned, folder, "interrupted", more)
        return
    from orchestrator.sweeping.sweep_report import write_report  # noqa: PLC0415 - matplotlib is slow to import

    if is_search:
        sweep_folder.write_samples(done.planned, folder)
        more |= {"found": done.found, "mildest": done.mildest}
    if done.results:
        table, bands = results_table(done.planned, done.results), band_table(done.planned, done.results.signals)
        if len(bands):
            sweep_folder.write_bands(bands, folder)
        elif (former := sweep_folder.read_bands(folder)) is not None:  # of a sweep that had ended before
            bands = former
        kept = {number: path.name for number, path in done.kept.items()}
        write_report(done.planned, table, bands, kept, folder, done.seconds, done.found, done.mildest)
        sweep_folder.write_results(table, folder)
    sweep_folder.write_sweep(done.planned, folder, "finished" if done.is_whole else "interrupted", more)


def _check_kept(keep: Sequence[str] | None, planned: PlannedSweep | None) -> None:
    count = MOST if planned is None or planned.request.find is not None else len(planned)
    ranking.kept(keep or (), {}, count)


def _keep(done: Swept, folder: Path, numbers: Sequence[int], progress: Progress) -> None:
    """Run some variants once more, each into a run folder; the same values give the same rows."""
    deadly = [number for number in numbers if done.results[number].fault.startswith(DIED)]
    done.remarks += [f"variant {number} is not kept: it ends the process that runs it" for number in deadly]
    numbers = [number for number in numbers if number not in deadly]
    for i, number in enumerate(numbers, 1):
        progress.now(f"keeping run {i} of {len(numbers)}: variant {number}")
        options = done.planned.options_of(done.planned.variant(number))
        there = folder / sweep_folder.KEPT_RUNS / f"variant-{number}"
        finished = execute(
            load(done.planned.request.scenario, options),
            there,
            SILENT,
            Execution(figures=False, name=f"variant {number}"),
        )
        if isinstance(finished.ended, KeyboardInterrupt):
            raise finished.ended
        done.kept[number] = there
