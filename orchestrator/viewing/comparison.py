"""Several runs in one recording: the same views, one colour per run, and the differences of chosen signals."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import VehicleState
from components.interfaces.maths import Array
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.pictures import pages, palette
from orchestrator.pictures.plots import titled
from orchestrator.pictures.run_picture import RunPicture
from orchestrator.pictures.screen import Series, screen
from orchestrator.pictures.shapes import Page, SeriesStyle, SeriesValues, Shape, Style, entity
from orchestrator.recording.stream import ShapeBatch, write
from orchestrator.results.provenance import facts, measured_facts
from orchestrator.results.run_folder import KeptRun
from orchestrator.stepping.paces import paces
from orchestrator.system.experiment import TimeGrid
from orchestrator.system.shown import signal_path

RunRows: TypeAlias = Mapping[str, NDArray[Any]]
"""The rows of a run: the column `time` [s], and one column for each signal element that was recorded."""

_LONGEST_CHOICE: Final = 20
"""Signals that a message lists at most."""


def rebuild(run: KeptRun, table: RunRows, path: Path) -> None:
    """Write the recording of a run anew, from its rows.

    Args:
        run: The run.
        table: Its rows.
        path: The file.
    """
    scenario, groups = run.scenario, _groups(run, table)
    picture = RunPicture(scenario.system, scenario.scene, timed=False, recorded=groups)
    about = facts(run.summary) | measured_facts(run.summary)
    page = Page(entity="/about", text=pages.page(run.name, about, scenario.system))
    batches = [*_batches(picture, groups, scenario.grid), *_ending(picture, run, table)]
    write(path, run.name, screen([picture]), [page, *picture.styles()], batches)


def compare(runs: Sequence[KeptRun], tables: Sequence[RunRows], differences: Sequence[str], path: Path) -> None:
    """Write one recording of several runs.

    Args:
        runs: The runs.
        tables: The rows of each run.
        differences: The signal elements whose differences from the first run are shown; place across the road and
            speed if not given.
        path: The file.

    Raises:
        RequestError: A signal is not a number, or was not recorded in every run.
    """
    names = _names(runs)
    groups = [_groups(run, table) for run, table in zip(runs, tables, strict=True)]
    pictures = [
        RunPicture(run.scenario.system, run.scenario.scene, name, i, timed=False, recorded=groups[i])
        for i, (run, name) in enumerate(zip(runs, names, strict=True))
    ]
    chosen = list(differences) or _usual(pictures, tables)
    raise_if_any(_problems(chosen, runs, tables))
    page = pages.comparison(names, [run.summary for run in runs], [run.scenario for run in runs])
    styles: list[Style] = [Page(entity="/about", text=page)]
    for picture in pictures:
        styles += picture.styles()
    styles += _difference_styles(chosen, names)
    batches: list[ShapeBatch] = []
    for i, (run, table) in enumerate(zip(runs, tables, strict=True)):
        grid = run.scenario.grid
        batches += [*_batches(pictures[i], groups[i], grid), *_ending(pictures[i], run, table)]
        if i:
            batches.append(_batch(table, grid, _differences(names[i], chosen, tables[0], table)))
    views = [_view(column, names, pictures[0]) for column in chosen]
    write(path, " against ".join(names), screen(pictures, views), styles, batches)


def difference(first: RunRows, other: RunRows, column: str) -> Array:
    """How much larger a signal is in one run than in another.

    Args:
        first: The rows of the run that is compared with. Between the ticks at which it recorded the signal, the signal
            is interpolated linearly.
        other: The rows of the run whose signal is looked at, `(n,)`.
        column: The signal element.

    Returns:
        The difference at the times of `other`, `(n,)`; NaN where `first` has ended, or where `other` has no value.
    """
    there, here = (np.asarray(table[column], dtype=float) for table in (first, other))
    known = np.isfinite(there)
    if not known.any():
        return np.full(len(here), np.nan)
    time = np.asarray(first["time"], dtype=float)[known]
    return here - np.interp(np.asarray(other["time"], dtype=float), time, there[known], left=np.nan, right=np.nan)


def _difference_styles(columns: Sequence[str], names: Sequence[str]) -> Iterator[Style]:
    for column in columns:
        for i, name in enumerate(names[1:], 1):
            at = entity("difference", name, column)
            yield SeriesStyle(entity=at, names=[name], colours=[palette.run(i)])


def _differences(name: str, columns: Sequence[str], first: RunRows, other: RunRows) -> Iterator[Shape | Style]:
    for column in columns:
        values = difference(first, other, column)
        known = np.isfinite(values)
        yield SeriesValues(entity=entity("difference", name, column), rows=known, values=values[known])


def _view(column: str, names: Sequence[str], picture: RunPicture) -> Series:
    units = {c: s.unit_of_measurement for s in picture.signals for c in s.columns}
    contents = [entity("difference", name, column) for name in names[1:]]
    leaf = column.rpartition(".")[2]  # a plot has room for a short title
    return Series(titled(f"\N{GREEK CAPITAL LETTER DELTA}{leaf}", units[column]), contents)


def _usual(pictures: Sequence[RunPicture], tables: Sequence[RunRows]) -> list[str]:
    """Place across the road and speed, as far as all runs have them."""
    paths = [signal_path(pictures[0].buses, VehicleState, signal) for signal in ("y", "v_x")]
    return [column for column in paths if all(column in table for table in tables)]


def _problems(chosen: Sequence[str], runs: Sequence[KeptRun], tables: Sequence[RunRows]) -> Iterator[Problem]:
    for column in chosen:
        for run, table in zip(runs, tables, strict=True):
            numbers = [name for name in table if name != "time" and np.asarray(table[name]).dtype.kind in "fiub"]
            if column not in numbers:
                found = f"no such signal in {run.where}"
                is_short = len(numbers) <= _LONGEST_CHOICE
                valid = choices(numbers) if is_short else "a recorded signal, such as plant.state.y"
                first = [name for name in numbers if name.startswith(f"{column}[")][:1]  # of an array
                remedy = did_you_mean(column, first or numbers)
                yield Problem(f"--difference {column}", found, valid if numbers else "a run that recorded it", remedy)


def _groups(run: KeptRun, table: RunRows) -> list[RunRows]:
    """The rows as they were recorded: the columns that were kept at the same ticks, without the ticks in between."""
    pace, ticks = paces(run.scenario.system, run.scenario.record), run.scenario.grid.ticks(table["time"])
    groups: list[RunRows] = []
    for every in sorted({pace.get(column, 0) for column in table} - {0}):
        at = ticks % every == 0
        groups.append({name: table[name][at] for name in table if name == "time" or pace.get(name) == every})
    return groups


def _batches(picture: RunPicture, groups: Sequence[RunRows], grid: TimeGrid) -> list[ShapeBatch]:
    return [_batch(rows, grid, picture.shapes(rows, None)) for rows in groups]


def _batch(rows: RunRows, grid: TimeGrid, shapes: Iterable[Shape | Style]) -> ShapeBatch:
    times = np.asarray(rows["time"], dtype=float)
    return ShapeBatch(grid.ticks(times), times, shapes)


def _ending(picture: RunPicture, run: KeptRun, table: RunRows) -> Iterator[ShapeBatch]:
    """How a run ended, and what came of it, at its last tick."""
    if len(table["time"]):
        yield _batch(table, run.scenario.grid, picture.driven(np.asarray(table["time"], dtype=float)))
    ending = picture.ending(facts(run.summary) | measured_facts(run.summary))
    if len(table["time"]) and ending.texts:
        yield _batch({"time": np.repeat(table["time"][-1:], len(ending.texts))}, run.scenario.grid, [ending])


def _names(runs: Sequence[KeptRun]) -> list[str]:
    """The names of the runs, or their folders where two runs have the same name."""
    names = [run.name for run in runs]
    if len(set(names)) == len(names):
        return names
    return [str(Path(run.where)) for run in runs]
