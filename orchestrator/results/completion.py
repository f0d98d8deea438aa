"""The folder of a run whose process has died is completed, from the rows and the facts that are on disk."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, cast

from components.interfaces.problem import RequestError
from orchestrator.results import summary
from orchestrator.results.claimed_folder import reclaim
from orchestrator.results.kept_summary import DAMAGED
from orchestrator.results.manifest import remove
from orchestrator.results.metrics import Chosen
from orchestrator.results.parquet import FileColumns, merge
from orchestrator.results.run_folder import DRAFT, MEANING, ROWS, RUN, SIGNALS, UNFINISHED, KeptRun, parts
from orchestrator.stepping.paces import without_gaps

_TEXTS: Final = ("scenario", "title")
_TABLES: Final = ("units", "versions", "metrics", "verdicts", "timing")
_LEAST: Final[dict[str, Any]] = {**dict.fromkeys(_TEXTS, ""), **{name: {} for name in _TABLES}}
"""What a summary has where nothing else is known."""


def finish(folder: Path, reason: str, *, interrupted: bool = False, unit: str = "") -> dict[str, Any]:
    """Complete the folder of a run whose process has died: one file with all rows, and the summary.

    Nothing is changed where the run had completed its folder itself.

    Args:
        folder: The run folder.
        reason: What ended the process, in words.
        interrupted: Whether it was ended because a person asked for the end of the run.
        unit: The unit that ended it, where it is known.

    Returns:
        The content of `summary.json`. Its status is `interrupted`, or `fault` with the reason, where the run had not
        come to its end; where it had, the status is what it was then, and the entry `closing` has the reason.

    Raises:
        RequestError: It is no run folder, or another process is writing to it.
        OSError: The folder cannot be written to; the rows that are there stay.
    """
    with reclaim(folder, RUN) as claimed:
        here = claimed.path
        known = KeptRun(str(folder), here, None).summary
        if known and DAMAGED not in known:
            return dict(known)
        if (here / ROWS / MEANING).is_file() and not (here / SIGNALS).is_file():
            merge(parts(here), here / ROWS / MEANING, here / SIGNALS)
        content = _content(here, reason, unit, interrupted=interrupted)
        summary.write_summary(content, here)
        remove(here, RUN, UNFINISHED)
    return content


def _content(folder: Path, reason: str, unit: str, *, interrupted: bool) -> dict[str, Any]:
    content = _draft(folder)
    if content.get("status") not in {None, "running"}:
        return {**content, "closing": reason}
    last: dict[str, Any] = {"tick": 0, "time": 0.0}
    with suppress(RequestError, OSError, ValueError):  # system.ssp or the rows are gone or damaged
        scenario = KeptRun(str(folder), folder, None).scenario
        rows = FileColumns(folder / SIGNALS)
        if len(times := rows["time"]):
            last = {"tick": int(scenario.grid.ticks(times[-1:])[0]), "time": float(times[-1])}
            content["experiment"] = {**content.get("experiment", {}), "ticks": last["tick"] + 1}
        kept = Chosen(rows, {"time": None, **dict.fromkeys(without_gaps(scenario.system, scenario.record))})
        content |= summary.measured(scenario, kept)
    fault = {} if interrupted else {"fault": {**last, "unit": unit, "reason": reason}}
    return {**_LEAST, **content, "status": "interrupted" if interrupted else "fault", **fault}


def _draft(folder: Path) -> dict[str, Any]:
    with suppress(OSError, ValueError, RecursionError):
        content = json.loads((folder / DRAFT).read_text(encoding="utf-8"))
        if isinstance(content, dict):
            return cast(dict[str, Any], content)
    return {}
