"""The result figures of the paper, drawn from run folders.

The paper shows trajectory and yaw rate in three comparisons: different algorithms, static and moving obstacles.
"""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from orchestrator.pictures.figure_parts import DPI, EGO_COLOUR, WIDTH
from orchestrator.pictures.signals import SignalColumns, signals
from orchestrator.pictures.tracks import Track, distances, line_styles, trajectories, yaw_rates
from orchestrator.reproduction.paper import matched
from orchestrator.reproduction.paper.evidence import AS_FMU, IN_PROCESS, Evidence, Result, Timing
from orchestrator.reproduction.paper.experiments import FigureKind, ReportFigure
from orchestrator.reproduction.runs import Outcome
from orchestrator.results.run_folder import SYSTEM
from orchestrator.ssp import reader as ssp_reader

_SMOOTHNESS_TITLES: Final = ("total variation of r [rad/s]", "rms yaw acceleration [rad/s2]")
_WAY_COLOURS: Final = {AS_FMU: EGO_COLOUR, IN_PROCESS: "#8a9bb0"}


def draw(planned: ReportFigure, outcomes: Mapping[str, Outcome], evidence: Evidence, path: Path) -> bool:
    """Draw a figure of the report.

    Args:
        planned: What the figure shows, and of which runs.
        outcomes: The executed runs by name.
        evidence: The metrics of the runs.
        path: The file to write.

    Returns:
        Whether there was anything to draw.
    """
    if planned.kind is FigureKind.SMOOTHNESS:
        figure = _smoothness([r for r in evidence.results if r.name in planned.runs], evidence)
    elif planned.kind is FigureKind.TIME:
        figure = _times(evidence.timings)
    else:
        tracks = [track for name in planned.runs if (track := _track(outcomes[name])) is not None]
        figure = _DRAWN_FROM_TRACKS[planned.kind](tracks)
    if figure is None:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI)
    return True


def _track(outcome: Outcome) -> Track | None:
    """The track of a run; None if it has no scene or no rows."""
    scenario = ssp_reader.read(outcome.folder / SYSTEM)
    frame = outcome.rows()
    if scenario.scene is None or frame.empty:
        return None
    columns = SignalColumns(frame, signals(scenario.system))
    return Track(outcome.run.label, columns, outcome.buses, scenario.scene)


def _smoothness(single: Sequence[Result], evidence: Evidence) -> Figure | None:
    """The curve of each tracker's gains, and the other controllers as points; down and to the left is better."""
    curves = evidence.curves_for(single[0]) if single else []
    if not curves:
        return None
    figure = Figure(figsize=(WIDTH, 3.3), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, name, title in zip(panels, matched.SMOOTHNESS, _SMOOTHNESS_TITLES, strict=True):
        for curve, (colour, _, marker) in zip(curves, line_styles([c.label for c in curves]), strict=True):
            error, value = ([p.metrics[m] for p in curve.points] for m in (matched.ACCURACY, name))
            axes.plot(error, value, "-", color=colour, marker=marker, linewidth=1.2, label=f"{curve.label}, gains")
        for result, (colour, _, marker) in zip(single, line_styles([r.label for r in single]), strict=True):
            at = [result.metrics[matched.ACCURACY]], [result.metrics[name]]
            axes.plot(*at, marker, color=colour, markersize=9, label=result.label, zorder=5)
        axes.set(xlabel="rms path error [m]", xlim=(0, None), ylim=(0, None))
        axes.set_ylabel(title, fontsize=9)
        axes.margins(0.08)
        axes.grid(visible=True, color="0.88", linewidth=0.6)
        axes.tick_params(labelsize=8)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6, fontsize=7, frameon=False)
    return figure


def _times(timings: Sequence[Timing]) -> Figure | None:
    """The time per sample of each controller, in each way that it runs; the axis is logarithmic."""
    if not timings:
        return None
    figure = Figure(figsize=(WIDTH, 0.7 + 0.2 * len(timings)), layout="constrained")
    axes = figure.subplots()
    names = [f"{timing.controller}, {timing.way}" for timing in timings]
    p50, p99 = ([getattr(timing, name) for timing in timings] for name in ("p50_us", "p99_us"))
    colours = [_WAY_COLOURS[timing.way] for timing in timings]
    axes.barh(names, p50, height=0.65, color=colours)
    axes.hlines(names, p50, p99, color="0.25", linewidth=1.2)
    axes.invert_yaxis()
    axes.set(xscale="log", xlabel="time per sample [us], p50 to p99")
    axes.grid(visible=True, axis="x", color="0.88", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8)
    return figure


_DRAWN_FROM_TRACKS: Final[Mapping[FigureKind, Callable[[Sequence[Track]], Figure | None]]] = {
    FigureKind.TRAJECTORY: trajectories,
    FigureKind.YAW_RATE: yaw_rates,
    FigureKind.DISTANCE: distances,
}
