"""A drive: the scenario `static` with the FMU as the plant, beside the plant that the scenario has."""

# pyright: basic
# matplotlib and pandas carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.buses import VehicleState
from components.interfaces.problem import RequestError
from orchestrator.exchange.passport.bench import STAGE_PATIENCE
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic
from orchestrator.results import metrics
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.experiment import Scenario
from orchestrator.system.shown import shown, signal_path

SCENARIO: Final = "static"
SOCKET: Final = "plant"
"""The socket that the scenario is driven for."""
FINISHES: Final = Topic("drive.finishes", f"As the plant of `{SCENARIO}` it reaches the stop time")
_ASIDE: Final = 1.0
"""[m] How far aside from the path of the scenario's plant the FMU may drive."""
BESIDE_USUAL: Final = Topic(
    "drive.beside", f"As the plant of `{SCENARIO}` it keeps within {_ASIDE:g} m of the path of the scenario's own plant"
)
_WORDS: Final = {"gap_obstacle": "the nearest obstacle", "gap_edge": "the edge of the road"}
"""The metrics that are told beside it, in words."""
_LARGEST: Final = 1e4
"""[m] A vehicle that is farther away than this is not drawn."""


@dataclass(frozen=True)
class Drive:
    """One run of the scenario."""

    scenario: Scenario
    columns: Mapping[str, Any]
    measured: Mapping[str, float]
    fault: SimulationError | None

    def of(self, signal: str) -> Any:
        """The rows of a signal of the vehicle's state."""
        return np.asarray(self.columns[signal_path(shown(self.scenario.system), VehicleState, signal)], dtype=float)


def lines(path: Path, why_not: str | None, *, lenient: bool) -> tuple[list[Line], list[bytes]]:
    """The lines about the drive, and pictures of it (PNG).

    Args:
        path: The FMU, or the mapping file of one.
        why_not: Why it cannot be driven, as it does not fit; None where it can.
        lenient: Whether broken rules of FMI are overlooked.
    """
    if why_not is not None:
        return [topic.does_not_apply(why_not) for topic in (FINISHES, BESIDE_USUAL)], []
    usual = _driven(Options(mode="blocks"))
    request = Options(
        mode="blocks", replacements={SOCKET: str(path)}, lenient=lenient, isolate=[f"{SOCKET}:{STAGE_PATIENCE:g}"]
    )
    try:
        mine = _driven(request)
    except RequestError as error:
        reason = "; ".join(problem.found for problem in error.problems)
        return [FINISHES.fails(reason), BESIDE_USUAL.does_not_apply("there is no drive")], []
    return [_finishes(mine), _beside(mine, usual)], pictures(mine, usual)


def _driven(options: Options) -> Drive:
    scenario = prepare(SCENARIO, options)
    simulation = Simulation(scenario.system, h=scenario.h, until=scenario.until)
    fault: SimulationError | None = None
    try:
        with simulation:
            simulation.run()
    except SimulationError as error:
        fault = error
    columns = simulation.columns()
    assert scenario.scene is not None  # noqa: S101 - the scenario has a road
    return Drive(scenario, columns, metrics.compute(columns, shown(scenario.system), scenario.scene), fault)


def _finishes(mine: Drive) -> Line:
    if mine.fault is not None:
        return FINISHES.fails(f"it ends at {mine.fault.time:g} s: {mine.fault.reason}")
    return FINISHES.passes(f"{mine.columns['time'][-1]:g} s")


def _beside(mine: Drive, usual: Drive) -> Line:
    rows = min(drawable(mine), drawable(usual))
    if not rows:
        return BESIDE_USUAL.does_not_apply("there are no rows to compare")
    x, y, road_x, road_y = (drive.of(axis)[:rows] for drive in (mine, usual) for axis in "xy")
    away = float(np.hypot(x - road_x, y - road_y).max())
    aside = float(np.abs(y - np.interp(x, usual.of("x"), usual.of("y"))).max())
    figures = {"distance": Measured(away, "m"), "offset": Measured(aside, "m")}
    text = f"from `{usual.scenario.system.units[SOCKET].interface.kind}` it is up to {aside:.3g} m aside"
    text += f", and {away:.3g} m away at the same instant"
    for name, words in _WORDS.items():
        if name in mine.measured:
            figures[name] = Measured(mine.measured[name], "m")
            text += f"; {mine.measured[name]:.3g} m to {words} ({usual.measured[name]:.3g} m)"
    return BESIDE_USUAL.passes(text, figures) if aside <= _ASIDE else BESIDE_USUAL.fails(text, figures)


def pictures(mine: Drive, usual: Drive) -> list[bytes]:
    """Both drives on the road, and their yaw rates over time, as PNG; none where there is nothing to see."""
    from orchestrator.pictures import figure_parts, tracks  # noqa: PLC0415 - matplotlib is slow to import
    from orchestrator.pictures.signals import SignalColumns, signals  # noqa: PLC0415

    found: list[tracks.Track] = []
    for label, drive in (("this FMU", mine), ("the scenario's plant", usual)):
        system, scene = drive.scenario.system, drive.scenario.scene
        rows = drawable(drive)
        if scene is not None and rows:
            columns = {name: values[:rows] for name, values in drive.columns.items()}
            found.append(tracks.Track(label, SignalColumns(columns, signals(system)), shown(system), scene))
    figures = [tracks.trajectories(found), tracks.yaw_rates(found)]
    images: list[bytes] = []
    for figure in figures:
        if figure is not None:
            image = io.BytesIO()
            figure.savefig(image, format="png", dpi=figure_parts.DPI)
            images.append(image.getvalue())
    return images


def drawable(drive: Drive) -> int:
    """The number of rows up to the first that is not finite, or too far away."""
    near = (np.abs(drive.of("x")) < _LARGEST) & (np.abs(drive.of("y")) < _LARGEST) & np.isfinite(drive.of("psi"))
    return len(near) if near.all() else int(near.argmin())
