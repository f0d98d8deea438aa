"""One run as shapes: its signals, its world, its use of friction and its events, in batches of rows.

Entities: `/world/...` is geometry in the road frame, z up; `/signals/<unit>/<bus>/<signal>` holds every recorded
signal, an array as one entity with a series per element; `/states/...` shows modes and texts, `/derived/...` what is
computed from signals, `/limits/...` known limits, `/friction/...` the friction circles, `/events` the log. In a
comparison the name of the run follows the first part, `/world/<run>/ego`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.pictures import drawing, events, friction, palette, plots, present_values, world
from orchestrator.pictures.driven import driven_styles, driven_values
from orchestrator.pictures.shapes import (
    LogLines,
    Memory,
    Page,
    SeriesStyle,
    SeriesValues,
    Shape,
    States,
    StateStyle,
    Style,
    Texts,
    entity,
)
from orchestrator.pictures.signals import Recorded, SignalColumns
from orchestrator.results.provenance import NO
from orchestrator.system.scene import Scene
from orchestrator.system.shown import shown
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

_LOG_WIDTH = 34
"""Characters of a line of the log that the viewer shows in a window of 1280 pixels."""
MICROSECONDS = "\N{MICRO SIGN}s"


class RunPicture:
    """What is drawn of one run.

    Args:
        system: The system that runs.
        scene: The scene that it is drawn in; None for a system without one.
        run: The name that distinguishes it from other runs in the same recording; empty for a run on its own.
        number: Its place in a comparison; None for a run on its own.
        timed: Whether the wall time of its steps is known, which it is not where a run is read back from its rows.
        recorded: The columns of each group that is recorded at the same ticks; every column at every tick if not
            given. What is not recorded is not drawn.
    """

    def __init__(  # noqa: PLR0913 - what a run is, and what distinguishes it from others
        self,
        system: System,
        scene: Scene | None,
        run: str = "",
        number: int | None = None,
        *,
        timed: bool = True,
        recorded: Sequence[Collection[str]] | None = None,
    ) -> None:
        self.system, self.run, self.buses = system, run, shown(system)
        self._recorded = Recorded(system, recorded)
        self.signals = self._recorded.signals
        self.limits = plots.limits(system, self.signals)
        self.timed = timed and bool(self.signals)
        self._parts = world.recorded_parts(self._recorded, self.buses)
        self.scene = scene if self._parts else None
        colour = self._colour = None if number is None else palette.run(number)
        self._largest_forces = friction.plant_force_limits(system, self.buses)
        self._world = None if self.scene is None else world.World(self.buses, self.scene, run, colour, number or 0)
        self._log = events.EventLog(self.buses, self.scene, self.limits)
        self._memory = Memory()
        self._told = [] if colour is not None else present_values.shown_signals(system, self.signals)
        self._held = {name for name, source in system.units.items() if not source.interface.output_after_set}

    @cached_property
    def has_friction(self) -> bool:
        """Whether there are friction circles."""
        return friction.is_known(self._recorded, self.buses)

    @property
    def has_place(self) -> bool:
        """Whether the place of the vehicle is recorded, so that a view can follow it."""
        return "ego" in self._parts

    @cached_property
    def has_path_error(self) -> bool:
        """Whether the distance of the vehicle from the path is known."""
        return drawing.has_path_errors(self._recorded, self.buses)

    @cached_property
    def has_gap(self) -> bool:
        """Whether the gap to the nearest obstacle is known."""
        return self.scene is not None and drawing.has_gaps(self._recorded, self.buses)

    @cached_property
    def has_states(self) -> bool:
        """Whether there is a timeline of states."""
        return self.has_path_error or any(signal.states or signal.is_text for signal in self.signals)

    @property
    def tells_values(self) -> bool:
        """Whether there is a table of the values at the time cursor; several runs have no room for theirs."""
        return bool(self._told)

    @cached_property
    def has_events(self) -> bool:
        """Whether there is a log."""
        return events.are_known(self._recorded, self.buses, self.scene, self.limits)

    @cached_property
    def series_names(self) -> dict[str, list[str]]:
        """The names of the elements of each signal, by its path; with their colours, unless the run has only one."""
        numbers = {signal.path: signal.names for signal in self.signals if signal.is_number}
        if self._colour is not None:
            return numbers
        return {
            path: [f"{name} {palette.series_name(i)}" for name, i in zip(names, self._places[path], strict=True)]
            for path, names in numbers.items()
        }

    @cached_property
    def _places(self) -> dict[str, range]:
        """The places of the elements of each signal among all numbers of its bus, which give them their colours."""
        places: dict[str, range] = {}
        counts: Counter[str] = Counter()
        for signal in (s for s in self.signals if s.is_number):
            first = counts[signal.bus]
            counts[signal.bus] += len(signal.columns)
            places[signal.path] = range(first, counts[signal.bus])
        return places

    def styles(self) -> Iterator[Style]:
        """What holds from the start."""
        yield from self._series_styles()
        yield from driven_styles(self.system, self.at)
        if self.has_path_error:
            yield self._states(self.at("states", "manoeuvre"), events.PHASES)
            yield self._lines(self.at("derived", "path_error"), ["path error [m]"])
        if self.has_gap:
            yield self._lines(self.at("derived", "gap_obstacle"), ["gap to the nearest obstacle [m]"])
        if self.timed:
            yield self._lines(self.at("performance", "step_time"), [f"time per step [{MICROSECONDS}]"])
        if self.has_friction:
            yield from friction.styles(self.run, self._colour or palette.SERIES[0])
        if self._world is not None:
            yield from self._world.styles(self._parts)
        if self.tells_values:
            yield Page(entity=self.at("now"), text="")

    def shapes(
        self, frame: pd.DataFrame | Mapping[str, Any], step_times: NDArray[np.float64] | None
    ) -> Iterator[Shape | Style]:
        """What is drawn of a batch of rows that follow those of the last call.

        Args:
            frame: The column `time` [s], and one column for each signal element.
            step_times: The wall time [s] that the step of each row took, `(n,)`; None where it is not known.
        """
        columns = SignalColumns(frame, self.signals)
        yield from self._signal_shapes(columns)
        if step_times is not None:
            times = np.asarray(step_times, dtype=float)[: len(columns.time)] * 1e6
            yield SeriesValues(entity=self.at("performance", "step_time"), values=times)
        error = drawing.path_errors(columns, self.buses)
        if error is not None:
            yield SeriesValues(entity=self.at("derived", "path_error"), values=error)
        yield from friction.shapes(columns, self.buses, self._largest_forces, self.run)
        boxes = drawing.obstacles(columns, self.buses)
        near = None
        if self.scene is not None and boxes is not None:
            near = drawing.nearest(columns, self.buses, self.scene, boxes[0])
        if near is not None:
            yield from self._gap(near.gap)
        if self._world is not None:
            yield from self._world.shapes(columns, error, boxes)
        yield from self._phases_and_events(columns, near)
        if any(columns.has(signal.path) for signal in self._told):
            derived = {"path error": error, "gap": None if near is None else near.gap}
            known = {name: values for name, values in derived.items() if values is not None}
            yield Texts(entity=self.at("now"), texts=present_values.tables(columns, self._told, known))

    def _gap(self, gap: NDArray[np.float64]) -> Iterator[Shape]:
        """The gap to the nearest obstacle; while nobody is near there is a hole in the line."""
        at = self.at("derived", "gap_obstacle")
        far = np.isinf(gap)
        rows = ~far | self._memory.news(at, far[:, None])
        if rows.any():
            yield SeriesValues(entity=at, rows=rows, values=np.where(far, np.nan, gap)[rows])

    def driven(self, times: NDArray[np.float64]) -> Iterator[Shape]:
        """The inputs that follow a table, at all times of the run [s], `(n,)`."""
        return driven_values(self.system, self.at, times)

    def ending(self, about: Mapping[str, str]) -> LogLines:
        """The lines of the log that say how the run ended and what came of it, for its last row.

        What is wrong stands first, because the viewer scrolls to the first line of the instant that it shows.

        Args:
            about: Its provenance; the entries `fault`, `verdicts`, `out of range` and `metrics` become lines.
        """
        verdicts, metrics, outside = (about.get(x, "").splitlines() for x in ("verdicts", "metrics", "out of range"))
        said = [(f"fault in {about['fault']}", "ERROR")] if "fault" in about else []
        said += [(text, "WARN") for text in [*(x for x in verdicts if NO in x), *outside]]
        said += [(text, "INFO") for text in [*(x for x in verdicts if NO not in x), *metrics]]
        return self._logged([events.Event(0, text, level) for text, level in said])

    def _logged(self, happened: Sequence[events.Event]) -> LogLines:
        """Events in the log, a long one in several lines, because the viewer cuts off what does not fit in one."""
        prefix = f"{self.run}: " if self.run else ""
        lines = [
            (event, line)
            for event in happened
            for line in wrap(f"{prefix}{event.text}", _LOG_WIDTH, subsequent_indent="  ", break_on_hyphens=False)
        ]
        return LogLines(
            entity=self.at("events"),
            rows=np.array([event.row for event, _ in lines], dtype=np.int64),
            texts=[line for _, line in lines],
            levels=[event.level for event, _ in lines],
        )

    def at(self, root: str, *parts: str) -> str:
        """The path of an entity of this run, by its first part and the parts that follow the name of the run."""
        return entity(root, self.run, *parts)

    def _lines(self, at: str, names: list[str], first: int = 0, *, held: bool = False) -> SeriesStyle:
        """The style of series; in a comparison they have the colour and the name of the run."""
        if self._colour is None:
            colours = [palette.SERIES[(first + i) % len(palette.SERIES)] for i in range(len(names))]
            return SeriesStyle(entity=at, names=names, colours=colours, held=held)
        legend = [self.run] if len(names) == 1 else [f"{self.run} {name}" for name in names]
        return SeriesStyle(entity=at, names=legend, colours=[self._colour] * len(names), held=held)

    def _states(self, at: str, names: Sequence[str]) -> StateStyle:
        return StateStyle(entity=at, names=names, colours=[palette.state(name, i) for i, name in enumerate(names)])

    def _series_styles(self) -> Iterator[Style]:
        for signal in (s for s in self.signals if s.is_number):
            at = self.at("signals", *signal.parts)
            held = signal.unit in self._held or not signal.variable.quantity.type.is_float
            yield self._lines(at, signal.labels, self._places[signal.path][0], held=held)
            if names := list(signal.states.values()):
                yield self._states(self.at("states", *signal.parts), names)
        for limit in (limit for limit in self.limits if limit.is_near):
            at = self.at(*plots.limit_parts(limit))
            yield SeriesStyle(entity=at, names=[limit.label], colours=[palette.LIMIT], width=1)

    def _signal_shapes(self, columns: SignalColumns) -> Iterator[Shape]:
        for signal in columns.signals:
            values = columns.of(signal.path)
            yield SeriesValues(entity=self.at("signals", *signal.parts), values=values)
            if names := signal.states:
                at = self.at("states", *signal.parts)
                rows = self._memory.news(at, values[:, None])
                yield States(entity=at, rows=rows, names=[names.get(v, f"{v:g}") for v in values[rows].tolist()])
        for path, elements in columns.texts.items():
            for i, values in enumerate(elements):
                index = f"[{i + 1}]" if len(elements) > 1 else ""
                at = self.at("states", *f"{path}{index}".split("."))
                rows = self._memory.news(at, np.array(values, dtype=object)[:, None])
                yield States(entity=at, rows=rows, names=[str(values[row]) for row in np.flatnonzero(rows)])
        ends = np.unique([0, len(columns.time) - 1])
        for limit in (x for x in self.limits if x.is_near and columns.has(x.signal.path)):
            at = self.at(*plots.limit_parts(limit))
            yield SeriesValues(entity=at, rows=ends, values=np.full(len(ends), limit.value))

    def _phases_and_events(self, columns: SignalColumns, near: drawing.Nearest | None) -> Iterator[Shape]:
        phase = events.phases(columns, self.buses, self.scene)
        if phase is not None:
            at = self.at("states", "manoeuvre")
            rows = self._memory.news(at, phase[:, None])
            yield States(entity=at, rows=rows, names=[events.PHASES[int(i)] for i in phase[rows]])
        if happened := self._log.of(columns, near):
            yield self._logged(happened)
