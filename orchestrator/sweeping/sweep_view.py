"""A sweep in the viewer: the table of all variants, signals over all of them, and the runs that are kept."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from components.interfaces.problem import Problem, raise_if_any, refuse
from fmus.toolchain.scratch import scratch_folder
from orchestrator.pictures import pages, palette
from orchestrator.pictures.plots import titled
from orchestrator.pictures.screen import Panel, Series, ViewGroup
from orchestrator.pictures.shapes import Page, SeriesStyle, SeriesValues, Style, entity
from orchestrator.recording.stream import ShapeBatch, write
from orchestrator.results import run_folder
from orchestrator.results.run_folder import KeptRun
from orchestrator.scenario.table_file import TIME
from orchestrator.sweeping import bands, findings, sweep_folder
from orchestrator.sweeping.results_table import verdict_names
from orchestrator.sweeping.sampling import VARIANT
from orchestrator.viewing import repair, viewer
from orchestrator.viewing.photograph import Look

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

METRICS_TAB, BANDS_TAB = "metrics", "bands"
"""What a picture of a sweep may show, beside the tabs of the runs that are kept."""
_RECORDING: Final = "recording"
"""The column of links to the runs that are kept."""
_CURVES: Final = {
    bands.MEAN: palette.SERIES[0],
    "5 %": palette.SERIES[1],
    "95 %": palette.SERIES[1],
    "least": palette.LIMIT,
    "largest": palette.LIMIT,
}
"""What is drawn of a signal, and in which colour."""


def show_sweep(  # noqa: PLR0913 - one parameter per option of the command
    folder: Path,
    differences: Sequence[str],
    tell: Callable[[str], None],
    *,
    web: bool = False,
    picture: Path | None = None,
    times: Sequence[float] = (),
    look: Look | None = None,
) -> None:
    """Open a sweep, and come back when the viewer is closed.

    Args:
        folder: Its folder.
        differences: Of the runs that are kept, the signals whose differences from the worst are shown.
        tell: Called with each line of text for the user.
        web: Whether to open a browser instead of a window.
        picture: A PNG file that is written instead of opening the viewer.
        times: Times [s] at which pictures are taken.
        look: The size of the window in the pictures, and what they show: the table of `metrics` (the usual), the
            `bands` over all variants, or a tab of the runs that are kept (the usual where there are times).

    Raises:
        RequestError: The sweep has not ended, or cannot be shown so.
    """
    viewer.check(picture, times, look, web=web)
    known, table = sweep_folder.asked(folder), sweep_folder.read_results(folder)
    look = look or Look()
    tab = look.tab or ("" if times or differences else METRICS_TAB)
    if times and tab == METRICS_TAB:
        raise refuse("--at", f"it beside --tab {METRICS_TAB}", f"--tab {BANDS_TAB}, or a tab of the runs that are kept")
    with scratch_folder("show") as scratch:
        if picture is None or tab == METRICS_TAB:
            with _catalog(folder, known, table, differences, Path(scratch), tell) as url:
                viewer.present(url, tell, web=web, picture=picture, look=replace(look, tab=None))
        elif tab == BANDS_TAB:
            source = _overview(folder, known, findings.ranked(known["varied"], table), Path(scratch))
            viewer.present(source, tell, picture=picture, times=times, look=replace(look, tab=None))
        else:
            source = _together(_kept(folder, known), differences, Path(scratch), tell)
            viewer.present(source, tell, picture=picture, times=times, look=look)


@contextmanager
def _catalog(  # noqa: PLR0913 - what is served
    folder: Path,
    known: Mapping[str, Any],
    table: pd.DataFrame,
    differences: Sequence[str],
    scratch: Path,
    tell: Callable[[str], None],
) -> Generator[str]:
    """Serve a sweep, and give the URL of its table, the worst variant first."""
    from orchestrator.recording.catalog import Catalog  # noqa: PLC0415 - slow to import

    kept = _kept(folder, known) if sweep_folder.kept_runs(folder, known) else {}
    ranked = findings.ranked(known["varied"], table)
    with closing(Catalog()) as catalog:
        catalog.add_recordings("all variants", [_overview(folder, known, ranked, scratch)])
        links: dict[int, str] = {}
        if kept:
            recordings = [repair.whole_recording(run, _made(scratch / str(n)), tell) for n, run in kept.items()]
            links = dict(zip(kept, catalog.add_recordings("kept runs", recordings), strict=True))
        if len(kept) > 1:
            catalog.add_recordings("kept runs together", [_together(kept, differences, scratch, tell)])
        ranked.insert(1, _RECORDING, [links.get(number) for number in ranked[VARIANT]])
        yield catalog.add_table(METRICS_TAB, ranked)


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


def _together(
    kept: Mapping[int, KeptRun], differences: Sequence[str], scratch: Path, tell: Callable[[str], None]
) -> Path:
    """The recording of the worst runs in one picture, as many as have colours of their own."""
    return viewer.recording(list(kept.values())[: len(palette.RUNS)], differences, scratch, tell)


def _kept(folder: Path, known: Mapping[str, Any]) -> dict[int, KeptRun]:
    """The runs that are kept, by variant, the worst first. Raises `RequestError` where there are none."""
    kept = sweep_folder.kept_runs(folder, known)
    if not kept:
        remedy = f"Keep some: macrostep sweep {folder} --keep worst:3"
        raise refuse(str(folder), "a sweep without run folders", "a sweep that has kept runs", remedy)
    found = {number: run_folder.find(path) for number, path in kept.items()}
    raise_if_any(problem for problem in found.values() if isinstance(problem, Problem))
    return {number: run for number, run in found.items() if isinstance(run, KeptRun)}


def _overview(folder: Path, known: Mapping[str, Any], ranked: pd.DataFrame, scratch: Path) -> Path:
    """Write the recording of all variants: signals over time, and a page."""
    styles: list[Style] = [Page(entity="/about", text=_page(folder, known, ranked))]
    batches: list[ShapeBatch] = []
    views: list[Series] = []
    for signal, of in _by_signal(folder):
        at = entity("bands", signal)
        styles.append(SeriesStyle(entity=at, names=list(_CURVES), colours=list(_CURVES.values())))
        values = SeriesValues(entity=at, values=of[list(_CURVES)].to_numpy(dtype=float))
        ticks, times = of[bands.TICK].to_numpy(dtype=np.int64), of[TIME].to_numpy(dtype=float)
        batches.append(ShapeBatch(ticks, times, [values]))
        views.append(Series(titled(signal, of[bands.UNIT].iloc[0]), [at], legend=True, is_high=True))
    page = Panel("page", "About this sweep", "/about")
    layout = ViewGroup("row", [ViewGroup("column", views), page], [3, 2]) if views else ViewGroup("tabs", [page])
    path = scratch / "all-variants.rrd"
    write(path, f"{folder.name}: all variants", layout, styles, batches)
    return path


def _by_signal(folder: Path) -> Iterator[tuple[str, pd.DataFrame]]:
    table = sweep_folder.read_bands(folder)
    for signal, of in () if table is None else table.groupby(bands.SIGNAL, sort=False):
        yield str(signal), of


def _page(folder: Path, known: Mapping[str, Any], ranked: pd.DataFrame) -> str:
    """What was asked for, how it went, and the worst variants, in Markdown."""
    verdicts, watched = verdict_names(ranked), known.get("watched", "")
    varied: Mapping[str, Mapping[str, str]] = known["varied"]
    shares = [(s.name, f"{s.holds} of {s.known}", f"{100 * s.value:.1f} %") for s in findings.shares(ranked) if s.known]
    worst: list[tuple[object, ...]] = []
    for record in ranked.head(findings.WORST_SHOWN).to_dict("records"):
        row: dict[str, Any] = {str(name): value for name, value in record.items()}
        worst.append((row[VARIANT], *(_shown(row[path]) for path in varied), findings.why(row, verdicts)))
    return "\n".join(
        [
            f"# {folder.name}\n\n{len(ranked)} variants, {known['sampling']}, seed {known['request'].seed}\n",
            f"A search for {known['request'].find}.\n" if known["request"].find else "",
            "## What varies\n",
            pages.table(("", "values", "unit"), [(path, v["values"], v["unit"]) for path, v in varied.items()]),
            "## Verdicts\n",
            pages.table(("", "holds in", "share"), shares),
            "## The worst\n",
            pages.table(("variant", *varied, "why"), worst),
            watched,
            "Orange are the ends of the range of 90 %, grey those of the whole range.\n" if watched else "",
        ]
    )


def _shown(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
