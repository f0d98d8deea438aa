"""The summary of a run: metrics, verdicts, versions, hashes and parameters, enough to trust a run and to repeat it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

import numpy as np

from components.interfaces.buses import Actuation
from fmus.toolchain.file_digest import digest_of
from orchestrator.results import metrics
from orchestrator.results.manifest import unfinished
from orchestrator.results.metrics import Chosen
from orchestrator.results.provenance import fault_facts, versions
from orchestrator.results.ranges import out_of_range
from orchestrator.results.run_folder import SUMMARY
from orchestrator.results.task import is_done, task
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.experiment import Scenario
from orchestrator.system.shown import parameter_values, shown, unit_that_shows
from orchestrator.system.system import System


def draft(scenario: Scenario, simulation: Simulation) -> dict[str, Any]:
    """What a summary says that is known before the first step."""
    return {
        "scenario": scenario.name,
        "title": scenario.title,
        "status": "running",
        "metrics": {},
        "verdicts": {},
        "experiment": _experiment(scenario, simulation),
        "schedule": str(simulation.schedule),
        "units": units(scenario.system),
        "connections": [str(c) for c in scenario.system.connections],
        "parameters": scenario.sources,
        "timing": {},
        "versions": versions(),
    }


def summary(
    scenario: Scenario,
    simulation: Simulation,
    columns: Mapping[str, Any],
    ended: SimulationError | KeyboardInterrupt | None,
    known: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The run on one page, for a person and for a machine.

    Args:
        scenario: What was run.
        simulation: The simulation after its last step.
        columns: Its rows, by column.
        ended: What ended the run before its stop time; None if nothing did.
        known: What `draft` has given before.

    Returns:
        The content of `summary.json`.
    """
    # Signals that were not kept at every tick could only give metrics other than those of the run.
    dense = Chosen(columns, ("time", *simulation.log.at_every_tick))
    times = simulation.step_times[: simulation.log.kept] * 1e6
    content = dict(known or draft(scenario, simulation)) | {
        "status": status(ended),
        **measured(scenario, dense),
        "experiment": _experiment(scenario, simulation),
        "timing": _timing(times) if len(times) else {},
    }
    if found := simulation.log.finiteness.found:
        content["not_finite"] = {o.element.path: {"first": o.time, "value": o.value} for o in found}
    if isinstance(ended, SimulationError):
        content["fault"] = _fault(ended)
    if simulation.ended is not None:
        content["ended"] = {"unit": simulation.ended.unit, "time": simulation.ended.time}
    return content


def measured(scenario: Scenario, rows: Mapping[str, Any]) -> dict[str, Any]:
    """The metrics of a run, its verdicts, and what was left: the surroundings of the road, declared ranges.

    Args:
        scenario: What was run.
        rows: The columns of what was kept at every tick.
    """
    known: dict[str, float] = {}
    departed: dict[str, Any] = {}
    if (scene := scenario.scene) is not None and len(rows["time"]):
        buses = shown(scenario.system)
        left = metrics.departure_of(rows, buses, scene)
        departed = {} if left is None else {"departure": asdict(left)}
        wanted = parameter_values(scenario.system, unit_that_shows(buses, Actuation)).get("v_ref")
        v_ref = float(wanted) if isinstance(wanted, int | float) else None
        known = metrics.compute(rows, buses, scene)
        known |= task(rows, buses, scene, v_ref, until=None if left is None else left.row)
    outside = out_of_range(rows, scenario.system)
    return {
        "metrics": known,
        "verdicts": {**is_done(known), **metrics.verdicts(known)},
        **departed,
        **({"out_of_range": outside} if outside else {}),
    }


def _experiment(scenario: Scenario, simulation: Simulation) -> dict[str, Any]:
    experiment: dict[str, Any] = {"step": scenario.h, "stop_time": scenario.until, "ticks": simulation.log.kept}
    if scenario.start:
        experiment["start_time"] = scenario.start
    if scenario.tolerance is not None:
        experiment["tolerance"] = scenario.tolerance
    return experiment


def status(ended: SimulationError | KeyboardInterrupt | None) -> str:
    """How a run ended, in one word: `finished`, `fault` or `interrupted`."""
    if ended is None:
        return "finished"
    return "fault" if isinstance(ended, SimulationError) else "interrupted"


def ending(ended: SimulationError | KeyboardInterrupt | None) -> dict[str, str]:
    """How a run ended, for its recording: the status, and for a fault the tick, the unit and the reason."""
    return {"status": status(ended)} | (fault_facts(_fault(ended)) if isinstance(ended, SimulationError) else {})


def _fault(ended: SimulationError) -> dict[str, Any]:
    return {"tick": ended.tick, "time": ended.time, "unit": ended.unit, "reason": ended.reason}


def _timing(times: np.ndarray[Any, Any]) -> dict[str, float]:
    """Statistics of the wall times [us] of the steps, the only part of a run that differs from one to the next."""
    return {
        "step_median_us": float(np.median(times)),
        "step_p99_us": float(np.percentile(times, 99)),
        "stepping_total_s": float(times.sum() / 1e6),
    }


def units(system: System) -> dict[str, dict[str, Any]]:
    """What each unit of a system is made from, the socket it fills, and how it runs; by the name of the unit."""
    return {name: _unit(system, name) for name in system.units}


def _unit(system: System, name: str) -> dict[str, Any]:
    source = system.units[name]
    described, socket = source.describe(), system.sockets.get(name)
    content: dict[str, Any] = {"kind": described.kind, "socket": socket.name if socket else None}
    if (mapping := source.mapping_text()) is not None:
        content["mapping"] = mapping
    content["runs_as"] = described.runs_as
    if described.isolated is not None:
        content["isolated"] = described.isolated
    if described.file is not None:
        content |= {"file": described.file.name, "sha256": digest_of(described.file)}
    return content


def write_summary(content: Mapping[str, Any], folder: Path, name: str = SUMMARY) -> None:
    """Write the summary, which is the last file of a run, completely or not at all.

    Args:
        content: The content of `summary.json`.
        folder: The run folder.
        name: The name of the file.
    """
    text = json.dumps(_strict(content), indent=2, default=_plain)
    with unfinished(folder / name) as file:
        file.write_text(text + "\n", encoding="utf-8")


def _strict(value: Any) -> Any:
    """The same content, with numbers that JSON has no spelling for (`inf`, `nan`) as texts."""
    if isinstance(value, Mapping):
        return {name: _strict(item) for name, item in cast(Mapping[str, Any], value).items()}
    if isinstance(value, list | tuple):
        return [_strict(item) for item in cast(list[Any], value)]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return cast(Any, value).item()
    raise TypeError(f"{type(value).__name__} in a summary")
