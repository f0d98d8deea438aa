"""How an FMU behaves at its declared limits, and when it is given a value that is no number."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.units.unit import EndRequested, UnitError, views
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.excitation import own_step
from orchestrator.exchange.passport.passport_line import Line, Topic
from orchestrator.exchange.passport.running import Running
from orchestrator.exchange.passport.workplace import Workplace

AT_LIMITS: Final = Topic("faults.limits", "At its declared limits it steps, or says that it cannot")
NOT_A_NUMBER: Final = Topic("faults.nan", "An input that is no number neither crashes nor hangs it")

_STEPS: Final = 3
_MOST: Final = 60
"""The number of limits that are tried."""
_MOST_CRASHES: Final = 3
_SILENT: Final = "not finite"


class Reaction(NamedTuple):
    """What an FMU does with a value."""

    kind: str
    """`goes on`, `error`, or `not finite` for outputs that are not, without an error."""
    text: str = ""


@dataclass(frozen=True)
class Extreme:
    """One input or parameter at a value that its file allows."""

    name: str
    value: float
    is_input: bool
    what: str
    """`minimum`, `maximum`, or `not a number`."""

    def __str__(self) -> str:
        return f"`{self.name}` = {self.value:g} ({self.what})"


def limits(archive: Archive) -> list[Extreme]:
    """The declared limits of inputs and parameters, without parameters that lengths depend on."""
    found: list[Extreme] = []
    for is_input, variables in ((True, archive.interface.inputs), (False, archive.interface.parameters)):
        for variable in variables:
            if variable.name not in archive.structural:
                found += _limits(variable, is_input=is_input)
    return found


def _limits(variable: Variable, *, is_input: bool) -> Iterator[Extreme]:
    q = variable.quantity
    if q.type.is_float or q.type.is_integer:
        for value, what in ((q.min, "minimum"), (q.max, "maximum")):
            if value is not None and np.isfinite(value):
                yield Extreme(variable.name, value, is_input, what)


def at_extremes(place: Workplace, extremes: list[Extreme], h: float) -> list[Reaction]:
    """What happens at each."""
    found: list[Reaction] = []
    for extreme in extremes:
        place.tell(str(extreme))
        found.append(_at(place.archive, extreme, h))
    return found


def _at(archive: Archive, extreme: Extreme, h: float) -> Reaction:
    parameters = {} if extreme.is_input else {extreme.name: _filled(archive, extreme)}
    try:
        with Running(archive, h, parameters) as running:
            usual = _finite(running)
            if extreme.is_input:
                views(running.interface.inputs, running.inputs)[extreme.name][:] = extreme.value
            for _ in range(_STEPS):
                running.step()
            lost = sorted(usual - _finite(running))
    except EndRequested:
        return Reaction("goes on")
    except UnitError as error:
        return Reaction("error", error.reason)
    return Reaction("not finite", f"`{lost[0]}` is not finite") if lost else Reaction("goes on")


def _filled(archive: Archive, extreme: Extreme) -> object:
    variable = next(v for v in archive.interface.parameters if v.name == extreme.name)
    value = extreme.value if variable.quantity.type.is_float else int(extreme.value)
    return np.full(variable.shape, value) if variable.shape else value


def _finite(running: Running) -> set[str]:
    """The outputs that are finite."""
    shown = views(running.interface.outputs, running.outputs)
    return {name for name, values in shown.items() if values.dtype.kind != "f" or np.isfinite(values).all()}


def lines(bench: Bench) -> list[Line]:
    """The lines about limits and values that are no numbers."""
    h = own_step(bench.archive)
    numbers = [
        Extreme(v.name, float("nan"), is_input=True, what="no number")
        for v in bench.archive.interface.inputs
        if v.quantity.type.is_float
    ]
    return [_at_limits(bench, limits(bench.archive), h), _not_numbers(bench, numbers, h)]


def _at_limits(bench: Bench, extremes: list[Extreme], h: float) -> Line:
    if not extremes:
        return AT_LIMITS.does_not_apply("it declares no limits of inputs or parameters")
    tried = extremes[:_MOST]
    results, crashes = _tried(bench, tried, h)
    silent = [
        f"{extreme}: {reaction.text}, without an error" for extreme, reaction in results if reaction.kind == _SILENT
    ]
    refused = [f"{extreme}: {reaction.text}" for extreme, reaction in results if reaction.kind == "error"]
    more = "" if len(tried) == len(extremes) else f", the first of {len(extremes)}"
    fine = f"{len(tried)} limits{more}, {_STEPS} steps each"
    if refused:
        fine += f"; {len(refused)} of them answered by an error: {refused[0]}"
    return AT_LIMITS.judged([*crashes, *silent], fine)


def _not_numbers(bench: Bench, extremes: list[Extreme], h: float) -> Line:
    if not extremes:
        return NOT_A_NUMBER.does_not_apply("it has no floating-point inputs")
    tried = extremes[:_MOST]
    results, crashes = _tried(bench, tried, h)
    if crashes:
        return NOT_A_NUMBER.judged(crashes, "")
    words = {"error": "returns an error", _SILENT: "passes it on", "goes on": "shows finite outputs all the same"}
    counts = Counter(words[reaction.kind] for _, reaction in results)
    return NOT_A_NUMBER.passes("; ".join(f"{text} ({n} of {len(tried)})" for text, n in counts.items()))


def _tried(bench: Bench, extremes: list[Extreme], h: float) -> tuple[list[tuple[Extreme, Reaction]], list[str]]:
    """What happens at each, and the crashes and hangs; after one of these, the rest is tried in another process."""
    done: list[tuple[Extreme, Reaction]] = []
    crashes: list[str] = []
    left = extremes
    while left and len(crashes) < _MOST_CRASHES:
        try:
            results = bench.measure(at_extremes, left, h)
        except MeasurementError as error:
            at = next((i for i, extreme in enumerate(left) if str(extreme) == error.stage), 0)
            crashes.append(f"{left[at]}: {error.reason}")
            before, left = left[:at], left[at + 1 :]
            with suppress(MeasurementError):  # they have not harmed it once already
                done += zip(before, bench.measure(at_extremes, before, h), strict=True)
        else:
            done += zip(left, results, strict=True)
            left = []
    return done, crashes
