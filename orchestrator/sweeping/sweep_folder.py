"""The folder of a sweep: what was asked, the values and results of all variants, the report, and kept runs.

While a sweep goes on, every variant that is done has a line in a file of `DONE`; a sweep that was stopped goes on with
those that have none. At the end they become the table `METRICS`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from components.interfaces.problem import Problem, raise_if_any, refuse
from fmus.toolchain.version import Version
from orchestrator.results.claimed_folder import ClaimedFolder, claim, reclaim
from orchestrator.results.manifest import Contents, read_manifest, unfinished
from orchestrator.results.provenance import now, versions
from orchestrator.results.run_folder import RUN
from orchestrator.results.summary import units
from orchestrator.scenario.options import Options
from orchestrator.sweeping.bands import BAND_COLUMNS
from orchestrator.sweeping.journal import VariantResults, read_journal
from orchestrator.sweeping.plan import PlannedSweep, plan
from orchestrator.sweeping.results_table import CAUSE, ENDED_BY, SECONDS, STATUS, results_in, values_of
from orchestrator.sweeping.sampling import TABLES, VARIANT
from orchestrator.sweeping.sweep_request import SweepRequest
from orchestrator.system.experiment import Scenario
from orchestrator.system.value_texts import plain

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

SWEEP: Final = "sweep.json"
SAMPLES_FILE: Final = "samples.parquet"
METRICS: Final = "metrics.parquet"
BANDS: Final = "bands.parquet"
REPORT: Final = "report.html"
DONE: Final = "done"
"""The folder of what is done, while a sweep goes on."""
KEPT_RUNS: Final = "runs"
"""The folder of the runs that are kept."""
CONTENTS: Final = Contents(
    "sweep", (SWEEP, SAMPLES_FILE, METRICS, BANDS, REPORT, f"{DONE}/*.jsonl"), inner=(KEPT_RUNS,)
)
_BYTES: Final = 2000
"""[byte] The room that a variant takes, while it is in the journal as well as in the table."""


def is_sweep(folder: Path) -> bool:
    """Whether a folder is one of a sweep."""
    return read_manifest(folder, CONTENTS) is not None


def new_sweep(planned: PlannedSweep, out: Path | None) -> ClaimedFolder:
    """Make the folder of a sweep: `out`, or the next free `runs/NAME-sweep-N`.

    Raises:
        RequestError: Something else is in the way, another process writes there, or it has no room for the results.
    """
    claimed = claim(f"{planned.scenario.name}-sweep", out, CONTENTS)
    try:
        _check_room(claimed, len(planned))
        _remove_runs(claimed.path / KEPT_RUNS)
        (claimed.path / DONE).mkdir(exist_ok=True)
        write_samples(planned, claimed.path)
        write_sweep(planned, claimed.path, "running")
    except BaseException:
        claimed.abandon()
        raise
    return claimed


def _remove_runs(folder: Path) -> None:
    """Remove the run folders that a former sweep has kept, as far as a run wrote them."""
    for path in folder.glob("variant-*"):
        claim("", path, RUN).abandon()
    with suppress(OSError):  # it is not there, or holds other things
        folder.rmdir()


def known_sweep(folder: Path) -> tuple[ClaimedFolder, PlannedSweep]:
    """The folder of a sweep that was stopped, and its plan.

    Raises:
        RequestError: It is no folder of a sweep, another process writes there, or its scenario is another one now.
    """
    claimed = reclaim(folder, CONTENTS)
    try:
        known = asked(folder)
        request: SweepRequest = known["request"]
        raise_if_any(_is_search(folder, request))
        if request.samples is not None and request.samples.endswith(TABLES):  # the table may be gone by now
            planned = plan(replace(request, samples=str(folder / SAMPLES_FILE)))
            planned = replace(planned, request=request)
        else:
            planned = plan(request)
        raise_if_any([*_changed(folder, known["scenarios"], planned), *_resampled(folder, planned)])
        claimed.remarks += [
            f"{folder}: was begun with {name} {old}, goes on with {new}"
            for name, old in known["versions"].items()
            if (new := versions().get(name)) != old
        ]
        (claimed.path / DONE).mkdir(exist_ok=True)
    except BaseException:
        claimed.release()
        raise
    return claimed, planned


def write_sweep(planned: PlannedSweep, folder: Path, status: str, more: Mapping[str, Any] | None = None) -> None:
    """Write `SWEEP`: what was asked, and with what it is run."""
    request = planned.request
    options = {name: value for name, value in asdict(request.options).items() if value != getattr(Options(), name)}
    content = {
        "status": status,
        "request": {**{k: v for k, v in asdict(request).items() if k != "options"}, "options": _plain(options)},
        "sampling": str(planned.sampling),
        "variants": len(planned),
        "varied": {v.path: {"values": v.text, "unit": planned.unit(v.path)} for v in planned.variations},
        "units": units(planned.scenario.system),
        "scenarios": fingerprints(planned),
        "versions": versions(),
        "watched": planned.watched.in_words(len(planned)) if planned.watched.columns else "",
        "written": now(),
        **(more or {}),
    }
    with unfinished(folder / SWEEP) as file:
        file.write_text(json.dumps(content, indent=2, default=str) + "\n", encoding="utf-8")


def write_samples(planned: PlannedSweep, folder: Path) -> None:
    """Write `SAMPLES_FILE`: the values of all variants."""
    with unfinished(folder / SAMPLES_FILE) as file:
        _samples(planned).to_parquet(file, index=False)


def write_results(table: pd.DataFrame, folder: Path) -> None:
    """Write `METRICS`, and remove the journal, which it replaces."""
    with unfinished(folder / METRICS) as file:
        table.to_parquet(file, index=False)
    for file in (folder / DONE).glob("*.jsonl"):
        file.unlink()
    (folder / DONE).rmdir()


def write_bands(table: pd.DataFrame, folder: Path) -> None:
    """Write `BANDS`; before `METRICS`, with which the signals go."""
    with unfinished(folder / BANDS) as file:
        table.to_parquet(file, index=False)


def read_bands(folder: Path) -> pd.DataFrame | None:
    """Read `BANDS`; None where there is none. Raises `RequestError` for a damaged one."""
    import pandas as pd  # noqa: PLC0415

    if not (folder / BANDS).is_file():
        return None
    try:
        return _with(pd.read_parquet(folder / BANDS), BAND_COLUMNS)
    except (OSError, ValueError) as error:
        remedy = "Remove it, or begin anew."
        raise refuse(f"{folder}/{BANDS}", f"a damaged file ({error})", "the bands of a sweep", remedy) from None


def read_results(folder: Path) -> pd.DataFrame:
    """Read `METRICS`. Raises `RequestError` where the sweep has not ended."""
    import pandas as pd  # noqa: PLC0415

    try:
        return _with(pd.read_parquet(folder / METRICS), (VARIANT, STATUS, ENDED_BY, CAUSE, SECONDS))
    except FileNotFoundError:
        remedy = f"Go on with it: macrostep sweep {folder}"
        raise refuse(str(folder), "a sweep that was stopped", "a sweep that has ended", remedy) from None
    except (OSError, ValueError) as error:
        raise refuse(f"{folder}/{METRICS}", f"a damaged file ({error})", "the table of a sweep") from None


def _with(table: pd.DataFrame, names: Iterable[str]) -> pd.DataFrame:
    """A table that has some columns. Raises `ValueError` where it has not."""
    if missing := [name for name in names if name not in table]:
        raise ValueError(f"without the column {missing[0]}")
    return table


def results_of(folder: Path, planned: PlannedSweep) -> VariantResults:
    """What is done in a sweep that goes on, or that has ended, by the number of the variant."""
    known = read_journal(folder / DONE)
    if (folder / METRICS).is_file():
        known.update(results_in(read_results(folder), planned.columns))
    return known


def told_before(folder: Path) -> tuple[dict[int, str], float]:
    """The runs that a sweep has kept so far, and the time [s] that it took."""
    content = asked(folder)
    return content["kept"], float(content.get("seconds", 0.0))


def kept_runs(folder: Path, known: Mapping[str, Any]) -> dict[int, Path]:
    """The run folders that a sweep has kept and that are still there, by variant, the worst first.

    Args:
        folder: The folder of the sweep.
        known: What `asked` says of it.
    """
    kept = {number: folder / KEPT_RUNS / name for number, name in known["kept"].items()}
    return {number: path for number, path in kept.items() if path.is_dir()}


def _check_room(claimed: ClaimedFolder, count: int) -> None:
    import shutil  # noqa: PLC0415

    free = shutil.disk_usage(claimed.path).free
    if count * _BYTES > free:
        found = f"{free / 1e6:.0f} MB of room for {count} variants"
        raise refuse(str(claimed.named), found, f"{count * _BYTES / 1e6:.0f} MB", "Choose another folder with --out.")


def asked(folder: Path) -> dict[str, Any]:
    """What was asked for, as `SWEEP` says it: the content of that file, with the `request` as it was.

    Raises:
        RequestError: It is damaged.
    """
    where = f"{folder}/{SWEEP}"
    try:
        content: dict[str, Any] = json.loads((folder / SWEEP).read_text("utf-8"))
        request = dict(content["request"])
        options = dict(request.pop("options"))
        if (mode := options.get("mode")) not in (None, "blocks"):
            options["mode"] = Version(mode)
        request |= {name: tuple(request.get(name, ())) for name in ("vary", "signals")}
        request["options"] = Options(**options)
        kept = {int(number): str(name) for number, name in content.get("kept", {}).items()}
        return {**content, "request": SweepRequest(**request), "kept": kept}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise refuse(where, f"a file that says not what was asked ({error})", "the file of a sweep") from None


def _is_search(folder: Path, request: SweepRequest) -> list[Problem]:
    """The problem of a search, which goes its own way again."""
    return [Problem(str(folder), "a search", "a sweep of samples", "Begin it anew.")] if request.find else []


def fingerprints(planned: PlannedSweep) -> dict[str, str]:
    """A number for all that decides the bits of a scenario, with each combination of units that fill sockets."""
    return {filled or "scenario": _fingerprint(scenario) for filled, scenario in planned.scenarios.items()}


def _fingerprint(scenario: Scenario) -> str:
    parameters = {name: source.parameters for name, source in scenario.system.units.items()}
    content = {
        "units": units(scenario.system),
        "parameters": {name: {path: plain(value) for path, value in of.items()} for name, of in parameters.items()},
        "connections": [str(connection) for connection in scenario.system.connections],
        "held": {path: plain(value) for path, value in scenario.system.held.items()},
        "scene": None if scenario.scene is None else asdict(scenario.scene),
        "experiment": [scenario.h, scenario.start, scenario.until, scenario.tolerance, scenario.algorithm],
        "loops": [scenario.solve_loops, scenario.end_off_road],
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()


def _changed(folder: Path, then: Mapping[str, str], planned: PlannedSweep) -> Iterator[Problem]:
    """What is not as it was when the sweep began."""
    found = "values, times or files that are not those that it began with"
    for filled, now_ in fingerprints(planned).items():
        if then.get(filled) != now_:
            yield Problem(f"{folder}: {filled}", found, "the same scenario, and the same files", "Begin anew.")


def _resampled(folder: Path, planned: PlannedSweep) -> Iterator[Problem]:
    """The problem of values that are not those that the sweep began with."""
    import pandas as pd  # noqa: PLC0415

    try:
        then = pd.read_parquet(folder / SAMPLES_FILE)
    except (OSError, ValueError) as error:
        raise refuse(f"{folder}/{SAMPLES_FILE}", f"a file that cannot be read ({error})", "that of a sweep") from None
    if not _samples(planned).equals(then):
        yield Problem(
            f"{folder}/{SAMPLES_FILE}", "other values than are asked for now", "the same values", "Begin anew."
        )


def _samples(planned: PlannedSweep) -> pd.DataFrame:
    import pandas as pd  # noqa: PLC0415

    table = pd.DataFrame(values_of(planned))
    table.insert(0, VARIANT, range(len(planned)))
    return table


def _plain(options: Mapping[str, Any]) -> dict[str, Any]:
    return json.loads(json.dumps(options, default=str))
