"""The distributions over the varied set, as cumulative shares of the cases."""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from orchestrator.pictures.figure_parts import DPI, WIDTH
from orchestrator.pictures.tracks import line_styles
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.varied.varied_set import VariedSet

_PANELS: Final = (
    ("gap_edge", "gap to edge [m]", (-1.5, 1.0)),
    ("gap_obstacle", "gap to obstacle [m]", (-0.1, 3.0)),
    ("path_error_rms", "rms path error [m]", (0.0, 0.6)),
    ("r_dot_rms", "rms yaw acceleration [rad/s2]", (0.0, 4.0)),
)
"""Metric, title and limits of each panel; where a curve leaves its panel, it tells the share beyond the limits."""


def draw_varied(varied: VariedSet, path: Path) -> None:
    """Draw the distributions of the controllers, without those that are points of a curve of gains only."""
    shown = [c for c in varied.plan.controllers if c.role is not RunRole.SWEEP]
    figure = Figure(figsize=(WIDTH, 5.0), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    for axes, (metric, title, limits) in zip(panels, _PANELS, strict=True):
        for controller, (colour, dashes, _) in zip(shown, line_styles([c.label for c in shown]), strict=True):
            results = [case.results[controller.name] for case in varied.cases if controller.name in case.results]
            values = np.sort([r.metrics[metric] for r in results if metric in r.metrics])
            if len(values):
                share = np.arange(1, len(values) + 1) / len(values)
                axes.step(
                    np.r_[limits[0] - 1, values, limits[1] + 1],
                    np.r_[0, share, 1],
                    where="post",
                    color=colour,
                    linestyle=dashes,
                    linewidth=1.3,
                    label=controller.label,
                )
        axes.set(xlim=limits, ylim=(0, 1), xlabel=title)
        axes.set_ylabel("share of the cases below", fontsize=8)
        axes.grid(visible=True, color="0.88", linewidth=0.6)
        axes.tick_params(labelsize=8)
    handles, texts = panels[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper center", ncols=6, fontsize=7, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI)
