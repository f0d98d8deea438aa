"""Several runs in one recording: the same views, one colour per run, and the difference of chosen signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.pictures import pages, palette, screen
from orchestrator.pictures.run_picture import RunPicture
from orchestrator.pictures.shapes import Page, SeriesStyle, SeriesValues, Shape, Style, entity
from orchestrator.recording.stream import ShapeBatch, write
from orchestrator.results.run_folder import KeptRun
from orchestrator.stepping.rows import paces

RunRows: TypeAlias = Mapping[str, NDArray[Any]]
"""The rows of a run: the column `time`, and one for each recorded signal element"""


def rebuild(run: KeptRun, table: RunRows, path: Path) -> None:
    """Write the recording of a run anew, from its rows."""
    scenario, groups = run.scenario, _groups(run, table)
    picture = RunPicture(scenario.system, scenario.scene, timed=False, recorded=groups)
    styles = [Page(entity="/about", text=pages.page(run.name, pages.facts(run.summary), scenario.system))]
    batches = [*_batches(picture, groups, scenario.h), *_fault(picture, run, table)]
    write(path, run.name, screen.screen([picture]), [*styles, *picture.styles()], batches)


def compare(runs: Sequence[KeptRun], tables: Sequence[RunRows], differences: Sequence[str], path: Path) -> None:
    """Write a recording of all `runs`, with the `differences` of signals from the first. Raises `RequestError`."""
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
    views = [_view(column, names, pictures[0]) for column in chosen]
    styles += [
        SeriesStyle(entity=entity("difference", name, column), names=[name], colours=[palette.run(i)])
        for column in chosen
        for i, name in enumerate(names)
        if i
    ]
    batches: list[ShapeBatch] = []
    for i, (run, table) in enumerate(zip(runs, tables, strict=True)):
        h = run.scenario.h
        batches += [*_batches(pictures[i], groups[i], h), *_fault(pictures[i], run, table)]
        if i:
            batches.append(ShapeBatch(_ticks(table, h), h, _differences(names[i], chosen, tables[0], table)))
    write(path, " against ".join(names), screen.screen(pictures, views), styles, batches)


def difference(first: RunRows, other: RunRows, column: str) -> NDArray[np.float64]:
    """How much larger a signal is in `other` than in `first`, at the times of `other`; NaN where `first` has ended.

    Between the ticks at which `first` recorded it, its signal is a line.
    """
    there, here = (np.asarray(table[column], dtype=float) for table in (first, other))
    known = np.isfinite(there)
    if not known.any():
        return np.full(len(here), np.nan)
    time = np.asarray(first["time"], dtype=float)[known]
    return here - np.interp(np.asarray(other["time"], dtype=float), time, there[known], left=np.nan, right=np.nan)


def _differences(name: str, columns: Sequence[str], first: RunRows, other: RunRows) -> Iterator[Shape | Style]:
    for column in columns:
        values = difference(first, other, column)
        known = np.isfinite(values)
        yield SeriesValues(entity=entity("difference", name, column), rows=known, values=values[known])


def _view(column: str, names: Sequence[str], picture: RunPicture) -> screen.Series:
    units = {c: s.variable.quantity.unit for s in picture.signals for c in s.columns}
    contents = [entity("difference", name, column) for name in names[1:]]
    return screen.Series(f"{column} [{units[column]}] less that of {names[0]}", contents)


def _usual(pictures: Sequence[RunPicture], tables: Sequence[RunRows]) -> list[str]:
    """Place across the road and speed, as far as all runs have them."""
    plant = pictures[0].who.plant
    wanted = [f"{plant}.state.y", f"{plant}.state.v_x"]
    return [column for column in wanted if all(column in table for table in tables)]


def _problems(chosen: Sequence[str], runs: Sequence[KeptRun], tables: Sequence[RunRows]) -> Iterator[Problem]:
    for column in chosen:
        for run, table in zip(runs, tables, strict=True):
            numbers = [name for name in table if name != "time" and np.asarray(table[name]).dtype.kind in "fiub"]
            if column not in numbers:
                found = f"no such signal in {run.where}"
                valid = choices(numbers) if len(numbers) <= _LISTED else "a recorded signal, such as plant.state.y"
                first = [name for name in numbers if name.startswith(f"{column}[")][:1]  # of an array
                remedy = did_you_mean(column, first or numbers)
                yield Problem(f"--difference {column}", found, valid if numbers else "a run that recorded it", remedy)


_LISTED = 20
"""signals; more are not read by anybody"""


def _groups(run: KeptRun, table: RunRows) -> list[RunRows]:
    """The rows as they were recorded: the columns that come at the same ticks, without the ticks in between."""
    pace, ticks = paces(run.scenario.system, run.scenario.record), _ticks(table, run.scenario.h)
    found: list[RunRows] = []
    for every in sorted({pace.get(column, 0) for column in table} - {0}):
        at = ticks % every == 0
        found.append({name: table[name][at] for name in table if name == "time" or pace.get(name) == every})
    return found


def _batches(picture: RunPicture, groups: Sequence[RunRows], h: float) -> list[ShapeBatch]:
    return [ShapeBatch(_ticks(rows, h), h, picture.shapes(rows, None)) for rows in groups]


def _fault(picture: RunPicture, run: KeptRun, table: RunRows) -> Iterator[ShapeBatch]:
    """Why a run ended before its time, at its last tick."""
    last, told = _ticks(table, run.scenario.h)[-1:], pages.facts(run.summary)
    if "fault" in told and len(last):
        yield ShapeBatch(last, run.scenario.h, [picture.fault(told["fault"])])


def _names(runs: Sequence[KeptRun]) -> list[str]:
    """The runs' names, with as much of their folders as it takes to tell them apart."""
    names = [run.name for run in runs]
    if len(set(names)) == len(names):
        return names
    return [str(Path(run.where)) for run in runs]


def _ticks(table: RunRows, h: float) -> NDArray[np.int64]:
    return np.rint(np.asarray(table["time"], dtype=float) / h).astype(np.int64)
