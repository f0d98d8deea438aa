"""The step size: what becomes of the results when the communication step is halved, and whether they blow up.

The same held inputs are given with the steps h, h/2 and h/4; where these do not agree, smaller ones are tried until two
of them do, which is the reference. An FMU whose own solver controls its error shows no difference.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fmus.reading.archive import Archive
from fmus.units.unit import EndRequested, UnitError, views
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.excitation import course, own_step, usual_steps
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic
from orchestrator.exchange.passport.running import Running, put
from orchestrator.exchange.passport.workplace import Workplace
from orchestrator.system.experiment import STEP

CONVERGENCE: Final = Topic("dynamics.convergence", "A smaller step brings the results together")
OWN_STEP: Final = Topic("dynamics.own_step", "It does not blow up with the step that it asks for")
MACRO: Final = Topic("dynamics.macro_step", f"It does not blow up with steps of {STEP:g} s")

_FACTORS: Final = (1, 2, 4)
_SMALLER: Final = (16, 64, 256)
_POINTS: Final = 50
"""The number of communication points that are compared."""
_TIME: Final = 3.0
"""[s] How long the steps of one factor may take."""
_AGREE: Final = 0.1
"""The largest difference, relative to the largest value, of two series that agree."""
_BLOWN: Final = 100.0
"""How many times the largest value of the reference is a blow-up."""
_GROWN: Final = 1e6
"""The same for the first row, where there is no reference."""
_SMALL: Final = 1e-9
"""The relative difference below which the step makes none."""
_LEAST_ORDER: Final = 0.5

Refinement = Mapping[int, NDArray[Any] | str]
"""The outputs at the common points, `(points, elements)`, or why there are none; by the divisor of the step."""


def refined(place: Workplace, h: float, points: int, factors: Sequence[int]) -> dict[int, Any]:
    """The continuous outputs with several steps, at common points."""
    return {factor: _with_step(place, h, points, factor) for factor in factors}


def _with_step(place: Workplace, h: float, points: int, factor: int) -> NDArray[Any] | str:
    place.tell(f"stepping by {h / factor:g} s")
    given = course(place.archive, h, 1, None)
    names = continuous_outputs(place.archive)
    rows: list[NDArray[Any]] = []
    ends = time.monotonic() + _TIME
    try:
        with Running(place.archive, h / factor) as running:
            put(running.inputs, {kind: table[0] for kind, table in given.inputs.items()})
            shown = views(running.interface.outputs, running.outputs)
            for _ in range(usual_steps(place.archive, h, points)):
                for _ in range(factor):
                    running.step()
                rows.append(np.concatenate([shown[name] for name in names]).astype(float))
                if time.monotonic() > ends:
                    return f"{points * factor} steps take longer than {_TIME:g} s"
    except EndRequested as end:
        if not rows:
            return str(end)
    except UnitError as error:
        return error.reason
    return np.array(rows)


def continuous_outputs(archive: Archive) -> list[str]:
    """The floating-point outputs that change between the steps, without those that the file declares as discrete."""
    scalar = {v.name: v.variability for v in archive.description.modelVariables}
    return [
        v.name
        for v in archive.interface.outputs
        if v.quantity.type.is_float and _variability(scalar, v.name, v.elements) in (None, "continuous")
    ]


def _variability(declared: Mapping[str, Any], name: str, elements: Sequence[str]) -> Any:
    return next((declared[n] for n in (name, *elements) if n in declared), None)


def elements(archive: Archive) -> list[str]:
    """The names of the elements of these outputs."""
    continuous = set(continuous_outputs(archive))
    return [element for v in archive.interface.outputs if v.name in continuous for element in v.elements]


def lines(bench: Bench) -> list[Line]:
    """The lines about the step."""
    if not continuous_outputs(bench.archive):
        why = "it has no continuous outputs"
        return [topic.does_not_apply(why) for topic in (CONVERGENCE, OWN_STEP, MACRO)]
    own = own_step(bench.archive)
    found: list[Line] = []
    series: Refinement | None
    try:
        series = _series(bench, own)
    except MeasurementError as error:
        series, found = None, [topic.fails(str(error)) for topic in (CONVERGENCE, OWN_STEP)]
    if series is not None:
        found = [convergence(series, own), blow_up(OWN_STEP, bench.archive, series, own)]
    return [*found, _macro(bench, own, found[1])]


def _series(bench: Bench, h: float) -> Refinement:
    """The outputs with h, h/2 and h/4, and with smaller steps until two agree."""
    series = common(bench.measure(refined, h, _POINTS, _FACTORS))
    for factor in _SMALLER:
        if reference(series) is not None:
            break
        series = common({**series, **bench.measure(refined, h, _POINTS, [factor])})
    return series


def common(series: Refinement) -> Refinement:
    """The series up to the end of the shortest; an FMU may ask for the end at an instant between two steps."""
    points = min((len(table) for table in series.values() if not isinstance(table, str)), default=0)
    return {factor: table if isinstance(table, str) else table[:points] for factor, table in series.items()}


def reference(series: Refinement) -> NDArray[Any] | None:
    """The series with the smallest step, if it agrees with the one before."""
    tables = [table for _, table in sorted(series.items()) if not isinstance(table, str)]
    if len(tables) < 2 or not np.isfinite(tables[-1]).all():  # noqa: PLR2004 - two agree, or none
        return None
    with np.errstate(all="ignore"):
        difference = np.abs(tables[-1] - tables[-2]).max(axis=0)
        agree = difference <= _AGREE * np.maximum(_peaks(tables[-1]), _floor(tables[-1]))
    return tables[-1] if agree.all() else None


def _peaks(table: NDArray[Any]) -> NDArray[Any]:
    return np.abs(table).max(axis=0)


def _floor(table: NDArray[Any]) -> float:
    """What is small beside the largest value of all outputs."""
    return max(1e-3 * float(_peaks(table).max(initial=0.0)), 1e-9)


def convergence(series: Refinement, h: float) -> Line:
    """The line about the order of convergence: the mean differences of h and h/2, and of h/2 and h/4.

    Args:
        series: The outputs by divisor of the step.
        h: The step [s].
    """
    tables = [series[factor] for factor in _FACTORS]
    refusals = [f"with {h / f:g} s: {t}" for f, t in zip(_FACTORS, tables, strict=True) if isinstance(t, str)]
    if refusals:
        return CONVERGENCE.does_not_apply(refusals[0])
    whole, half, quarter = (np.asarray(table) for table in tables)
    if not all(np.isfinite(table).all() for table in (whole, half, quarter)):
        return CONVERGENCE.does_not_apply("its outputs are not all finite")
    scale = np.maximum(_peaks(quarter), _floor(quarter))
    coarse, fine = (float((np.abs(a - b).mean(axis=0) / scale).max()) for a, b in ((whole, half), (half, quarter)))
    figures = {"difference_h_h2": Measured(coarse, "1"), "difference_h2_h4": Measured(fine, "1")}
    if max(coarse, fine) <= _SMALL:
        return CONVERGENCE.passes(f"the step makes no difference above {_SMALL:g}", figures)
    order = math.log2(coarse / fine) if fine > 0 and coarse > 0 else math.inf if coarse > 0 else -math.inf
    seen = f"differences of {coarse:.2g} from {h:g} s to {h / 2:g} s, and of {fine:.2g} to {h / 4:g} s"
    if math.isfinite(order):
        figures["order"] = Measured(order, "1")
        seen += f": order {order:.1f}"
    fine_enough = order >= _LEAST_ORDER or fine <= 1e3 * _SMALL
    return CONVERGENCE.passes(seen, figures) if fine_enough else CONVERGENCE.fails(seen, figures)


def blow_up(topic: Topic, archive: Archive, series: Refinement, h: float) -> Line:
    """The line about values that grow without bound with a step, and not with a smaller one.

    Args:
        topic: What it is about.
        archive: The FMU.
        series: The outputs by divisor of the step.
        h: The step [s].
    """
    largest = series[1]
    if isinstance(largest, str):
        return topic.fails(f"with {h:g} s: {largest}")
    tables = {factor: table for factor, table in sorted(series.items()) if not isinstance(table, str)}
    known = reference(series)
    smallest = h / max(tables)
    best, times = (largest[:1], _GROWN) if known is None else (known, _BLOWN)
    bad = blown(largest, best, times)
    if not bad.any():
        than = f"what it is with {smallest:g} s" if known is not None else "its first value"
        return topic.passes(f"with {h:g} s no output exceeds {times:g} times {than}")
    at = int(np.argmax(np.where(bad, np.nan_to_num(_peaks(largest), nan=np.inf), -1)))
    peak, bound = float(_peaks(largest)[at]), float(_peaks(best)[at])
    text = f"with {h:g} s `{elements(archive)[at]}` reaches {peak:.3g} in {len(largest)} steps"
    if known is None:
        return topic.fails(f"{text}, and with smaller steps down to {smallest:g} s it does not settle either")
    holds = h / next(factor for factor, table in tables.items() if not blown(table, best).any())
    text += f", with {smallest:g} s {bound:.3g} at most: it needs a step of {holds:g} s or less"
    figures = {
        "peak": Measured(peak, "1"),
        "peak_of_reference": Measured(bound, "1"),
        "step_that_holds": Measured(holds, "s"),
    }
    return topic.fails(text, {name: m for name, m in figures.items() if math.isfinite(m.value)})


def blown(table: NDArray[Any], best: NDArray[Any], times: float = _BLOWN) -> NDArray[np.bool_]:
    """Which outputs are not finite where the reference is, or more than so many times larger than it."""
    with np.errstate(all="ignore"):
        lost = (~np.isfinite(table) & np.isfinite(best)).any(axis=0)
        return lost | (_peaks(table) > times * np.maximum(_peaks(best), _floor(best)))


def _macro(bench: Bench, own: float, of_own: Line) -> Line:
    if own == STEP:
        return Line(MACRO.key, MACRO.title, of_own.mark, of_own.evidence, of_own.figures)
    inside = bench.archive.suggested.fixed_step
    if inside and not _is_multiple(STEP, inside):
        return MACRO.does_not_apply(f"its internal step of {inside:g} s does not divide {STEP:g} s")
    try:
        return blow_up(MACRO, bench.archive, _series(bench, STEP), STEP)
    except MeasurementError as error:
        return MACRO.fails(str(error))


def _is_multiple(h: float, inside: float) -> bool:
    return math.isclose(h / inside, round(h / inside), rel_tol=1e-9)
