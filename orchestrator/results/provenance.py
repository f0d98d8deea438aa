"""Provenance: the versions that a result depends on, and the facts in a run's summary about its origin."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, Final

from orchestrator.results.ranges import range_remarks

_LIBRARIES: Final = ("casadi", "fmpy", "numpy", "pandas", "rerun-sdk")


def versions() -> dict[str, str]:
    """The versions of macrostep, of Python and of the libraries that a result can depend on, by name."""
    from importlib import metadata  # noqa: PLC0415 - slow to import, and the facts of a summary do not need it

    version_of = {"macrostep": own_version(), "python": platform.python_version()}
    return version_of | {name: metadata.version(name) for name in _LIBRARIES}


def now() -> str:
    """The present date and time in UTC, as results tell when they were made."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def own_version() -> str:
    """The version of macrostep, also when it runs from a checkout without being installed."""
    from importlib import metadata  # noqa: PLC0415

    try:
        return metadata.version("macrostep")
    except metadata.PackageNotFoundError:
        return "0 (not installed)"


def facts(summary: Mapping[str, Any]) -> dict[str, str]:
    """The most important facts about a run: scenario, status, fault, units and versions.

    Args:
        summary: The content of `summary.json`; empty for a run that was cut short.

    Returns:
        A text for each fact, in the order in which they are shown.
    """
    if not summary:
        return {"status": "cut short: there is no summary.json"}
    texts: dict[str, str] = {}
    if "damaged" in summary:
        texts["damaged"] = str(summary["damaged"])
    if "scenario" in summary:
        texts["scenario"] = f"{summary['scenario']}: {summary.get('title', '')}"
    texts["status"] = summary.get("status", "unknown")
    if "fault" in summary:
        texts |= fault_facts(summary["fault"])
    for name, unit in summary.get("units", {}).items():
        own_process = ", in a process of its own" if "isolated" in unit else ""
        texts[f"unit {name}"] = f"{unit['kind']}, {unit['runs_as']}{own_process}"
    return texts | dict(summary.get("versions", {}))


NO: Final = ": no"
"""What a text of verdicts holds where one of them does not hold."""
SHOWN_METRICS: Final = {
    **dict.fromkeys(("gap_obstacle", "gap_edge", "path_error_rms", "path_error_max"), "m"),
    "r_peak": "rad/s",
    "mu_f_max": "",
    "mu_r_max": "",
}
"""The metrics that a person is shown of a run, and their units of measurement."""
_TOLD: Final = ("gap_obstacle", "gap_edge", "path_error_max", "mu_f_max", "mu_r_max")
"""The metrics of the entry `metrics`."""


def measured_facts(summary: Mapping[str, Any]) -> dict[str, str]:
    """What came of a run: the entries `verdicts`, `metrics` and `out of range`, as far as there are any.

    Each verdict, metric and remark is a line, because the viewer's log cuts off long ones.

    Args:
        summary: The content of `summary.json`.
    """
    held: Mapping[str, bool] = summary.get("verdicts", {})
    verdicts = [f"{name.replace('_', ' ')}{': yes' if holds else NO}" for name, holds in held.items()]
    known: Mapping[str, float] = summary.get("metrics", {})
    metrics = [f"{name} {known[name]:.3g} {SHOWN_METRICS[name]}".rstrip() for name in _TOLD if name in known]
    outside = range_remarks(summary.get("out_of_range", {}))
    told = {"verdicts": verdicts, "metrics": metrics, "out of range": outside}
    return {name: "\n".join(lines) for name, lines in told.items() if lines}


def fault_facts(fault: Mapping[str, Any]) -> dict[str, str]:
    """What ended a run before its stop time, and when.

    Args:
        fault: The tick, the time [s], the unit (empty where it was none) and the reason.

    Returns:
        The entries `fault` and `fault at`.
    """
    at = f"tick {fault['tick']} (t = {fault['time']:g} s)"
    unit = f"unit `{fault['unit']}`: " if fault["unit"] else ""
    return {"fault": f"{unit}{fault['reason']}", "fault at": at}
