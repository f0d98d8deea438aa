"""The run folder: everything that a run produced, enough to read it, trust it and repeat it.

``signals.parquet`` (all signals, units in the metadata), ``recording.rrd`` (Rerun), ``summary.json`` (metrics,
verdicts, versions, hashes, parameters), ``system.ssp`` and ``figures/*.png``. `summary.json` is written last: a folder
without it is not whole.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from components.interfaces.problem import refuse
from orchestrator.pictures import pages
from orchestrator.results import metrics
from orchestrator.results.provenance import versions
from orchestrator.ssp import writer as ssp
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.experiment import Scenario
from orchestrator.system.system import System

SUMMARY: Final = "summary.json"


def new_folder(scenario: str, out: Path | None) -> Path:
    """The folder for a run: `out`, or the next free ``runs/NAME-1``, ``-2``, ...

    A former run at `out` is replaced; anything else that is there stays. Raises `RequestError`.
    """
    folder = out
    if folder is None:
        taken = {int(p.name.rpartition("-")[2]) for p in Path("runs").glob(f"{scenario}-[0-9]*") if _numbered(p)}
        folder = Path("runs") / f"{scenario}-{max(taken, default=0) + 1}"
    where, valid = str(folder), "a folder that is new, empty or a former run, in a place that can be written to"
    if folder.is_file():
        raise refuse(where, "a file", valid, "Choose another folder with --out.")
    try:
        if folder.is_dir() and any(folder.iterdir()):
            if not is_run(folder):
                raise refuse(where, "a folder with other things in it", valid, "Choose another folder with --out.")
            shutil.rmtree(folder)
        (folder / "figures").mkdir(parents=True, exist_ok=True)
        (folder / ".writable").touch()
        (folder / ".writable").unlink()
    except OSError as error:
        raise refuse(
            where, f"a folder that cannot be written to ({error.strerror})", valid, "Choose another one."
        ) from error
    return folder


def is_run(folder: Path) -> bool:
    """Whether a folder holds a run, whole or cut short."""
    return (folder / "system.ssp").is_file()


def _numbered(path: Path) -> bool:
    return path.name.rpartition("-")[2].isdigit()


def summary(
    scenario: Scenario,
    simulation: Simulation,
    columns: Mapping[str, Any],
    ended: SimulationError | KeyboardInterrupt | None,
) -> dict[str, Any]:
    """The run in one page, for a person and for a machine; `columns` are those of the simulation."""
    roles = {socket.name: unit for unit, socket in scenario.system.sockets.items()}
    found: dict[str, float] = {}
    if scenario.scene is not None and len(columns["time"]):
        # what is not there at every tick could only give metrics that are not those of the run
        dense = {name: columns[name] for name in ("time", *simulation.log.at_every_tick)}
        found = metrics.compute(dense, roles, scenario.scene)
    times = simulation.step_times[: simulation.log.kept] * 1e6
    told: dict[str, Any] = {
        "scenario": scenario.name,
        "title": scenario.title,
        "status": status(ended),
        "metrics": found,
        "verdicts": metrics.verdicts(found),
        "experiment": {"step": scenario.h, "stop_time": scenario.until, "ticks": simulation.log.kept},
        "schedule": str(simulation.schedule),
        "units": units(scenario.system),
        "connections": [str(c) for c in scenario.system.connections],
        "parameters": scenario.sources,
        "timing": _timing(times) if len(times) else {},
        "versions": versions(),
    }
    if isinstance(ended, SimulationError):
        told["fault"] = _fault(ended)
    return told


def status(ended: SimulationError | KeyboardInterrupt | None) -> str:
    """How a run ended, in a word."""
    if ended is None:
        return "finished"
    return "fault" if isinstance(ended, SimulationError) else "interrupted"


def ending(ended: SimulationError | KeyboardInterrupt | None) -> dict[str, str]:
    """How a run ended, for a person who looks at its recording: the status, and a fault with tick, unit and reason."""
    return {"status": status(ended)} | (pages.fault(_fault(ended)) if isinstance(ended, SimulationError) else {})


def _fault(ended: SimulationError) -> dict[str, Any]:
    return {"tick": ended.tick, "time": ended.time, "unit": ended.unit, "reason": ended.reason}


def _timing(times: np.ndarray[Any, Any]) -> dict[str, float]:
    """Wall time; the only part of a run that differs from one to the next."""
    return {
        "step_median_us": float(np.median(times)),
        "step_p99_us": float(np.percentile(times, 99)),
        "stepping_total_s": float(times.sum() / 1e6),
    }


def units(system: System) -> dict[str, dict[str, Any]]:
    """What fills each place in the system, and how it runs."""
    return {name: _unit(system, name) for name in system.units}


def _unit(system: System, name: str) -> dict[str, Any]:
    source = system.units[name]
    described, socket = source.describe(), system.sockets.get(name)
    told: dict[str, Any] = {"kind": described.kind, "socket": socket.name if socket else None}
    if (mapping := source.mapping_text()) is not None:
        told["mapping"] = mapping
    told["runs_as"] = described.runs_as
    if described.file is not None:
        told |= {"file": described.file.name, "sha256": hashlib.sha256(described.file.read_bytes()).hexdigest()}
    return told


def write_summary(told: Mapping[str, Any], folder: Path) -> None:
    """Write `summary.json`, the last file of a run."""
    text = json.dumps(told, indent=2, default=_plain)
    (folder / SUMMARY).write_text(text + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return cast(Any, value).item()
    raise TypeError(f"{type(value).__name__} in a summary")


def write_system(scenario: Scenario, folder: Path) -> None:
    """Write `system.ssp`, before the first step, so that even a run that dies can be repeated."""
    ssp.write(scenario, folder / "system.ssp")
