"""The figures of a sweep: distributions of metrics, metrics over what varies, and signals over time."""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from orchestrator.pictures.figure_parts import DPI, WIDTH
from orchestrator.pictures.plots import titled
from orchestrator.scenario.table_file import TIME
from orchestrator.sweeping import bands

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

_GOOD, _BAD = "#1f6fd1", "#c62828"
_MOST: Final = 4000
"""Points of a panel at most; of more, every second is drawn, or third, and so on."""
_ZERO: Final = ("gap_obstacle", "gap_edge")
"""Metrics below 0 of which something has gone wrong."""
_ONE: Final = ("mu_f_max", "mu_r_max")
"""Metrics above 1 of which something has gone wrong."""


def distributions(table: pd.DataFrame, metrics: Mapping[str, str]) -> bytes:
    """Histograms of the metrics, as a picture.

    Args:
        table: The results.
        metrics: Metrics and their units of measurement.
    """
    columns = min(4, len(metrics))
    rows = -(-len(metrics) // columns)
    figure = Figure(figsize=(WIDTH, 1.7 * rows), layout="constrained")
    panels = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for axes, (name, unit) in zip(panels, metrics.items(), strict=False):
        values = table[name].to_numpy(dtype=float)
        values = values[np.isfinite(values)]
        axes.hist(values, bins=min(40, max(5, int(np.sqrt(len(values))))), color=_GOOD)
        _limit(axes.axvline, name)
        axes.set_xlabel(titled(name, unit or None), fontsize=7)
        axes.tick_params(labelsize=6)
    for axes in panels[len(metrics) :]:
        axes.set_axis_off()
    return _picture(figure)


def over_values(
    table: pd.DataFrame, metrics: Mapping[str, str], paths: Mapping[str, str], failed: Any, logarithmic: set[str]
) -> bytes:
    """Each metric over each value that varies, as a picture; variants that failed are red.

    Args:
        table: The results.
        metrics: Metrics and their units of measurement.
        paths: What varies, and its unit of measurement.
        failed: Whether each variant failed, `(n,)`.
        logarithmic: The paths whose axis is logarithmic.
    """
    width = max(WIDTH, 1.75 * len(paths))
    figure = Figure(figsize=(width, 1.45 * len(metrics) + 0.3), layout="constrained")
    panels = figure.subplots(len(metrics), len(paths), squeeze=False, sharex="col", sharey="row")
    every = -(-len(table) // _MOST)
    drawn, bad = table.iloc[::every], np.asarray(failed, dtype=bool)[::every]
    size = min(14.0, max(2.0, 1500 / max(len(drawn), 1)))
    for row, (name, unit) in zip(panels, metrics.items(), strict=True):
        values = drawn[name].to_numpy(dtype=float)
        for axes, path in zip(row, paths, strict=True):
            x, names = _abscissa(drawn[path])
            for which, colour in ((~bad, _GOOD), (bad, _BAD)):
                axes.scatter(x[which], values[which], s=size, color=colour, linewidths=0, alpha=0.7, rasterized=True)
            _limit(axes.axhline, name)
            if names:
                axes.set_xticks(range(len(names)), names, rotation=20, ha="right")
            elif path in logarithmic:
                axes.set_xscale("log")
            axes.tick_params(labelsize=6)
        row[0].set_ylabel(titled(name, unit or None), fontsize=6.5)
    for axes, (path, unit) in zip(panels[-1], paths.items(), strict=True):
        axes.set_xlabel(titled(path, unit or None), fontsize=6.5)
    return _picture(figure)


def over_time(table: pd.DataFrame) -> bytes:
    """Signals over time, as a picture: their mean, the range of 90 % of the variants, and that of all.

    Args:
        table: Their bands.
    """
    signals = list(dict.fromkeys(table[bands.SIGNAL]))
    figure = Figure(figsize=(WIDTH, 1.9 * len(signals) + 0.3), layout="constrained")
    panels = figure.subplots(len(signals), 1, squeeze=False, sharex=True)[:, 0]
    for axes, name in zip(panels, signals, strict=True):
        of = table[table[bands.SIGNAL] == name]
        time, (least, low, _, high, largest) = of[TIME], (of[column] for column in bands.PERCENTILES)
        axes.fill_between(time, least, largest, color=_GOOD, alpha=0.15, linewidth=0, label="all variants")
        axes.fill_between(time, low, high, color=_GOOD, alpha=0.35, linewidth=0, label="90 % of them")
        axes.plot(time, of[bands.MEAN], color=_GOOD, linewidth=1.2, label="mean")
        axes.set_ylabel(titled(name, of[bands.UNIT].iloc[0]), fontsize=7)
        axes.tick_params(labelsize=6)
        axes.grid(alpha=0.3, linewidth=0.5)
    panels[0].legend(fontsize=6, frameon=False, ncols=3, loc="best")
    panels[-1].set_xlabel("time [s]", fontsize=7)
    return _picture(figure)


def _abscissa(column: pd.Series[Any]) -> tuple[np.ndarray[Any, Any], list[str]]:
    """Values as numbers; the names of those that are no numbers, which stand at 0, 1, and so on."""
    if column.dtype.kind in "fiu":
        return column.to_numpy(dtype=float), []
    texts = [str(value).rpartition("/")[2] for value in column]
    names = list(dict.fromkeys(texts))
    return np.array([names.index(text) for text in texts], dtype=float), names


def _limit(draw: Any, name: str) -> None:
    if name in _ZERO or name in _ONE:
        draw(0.0 if name in _ZERO else 1.0, color="0.4", linewidth=0.8, linestyle="--")


def _picture(figure: Figure) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, dpi=DPI)
    return content.getvalue()
