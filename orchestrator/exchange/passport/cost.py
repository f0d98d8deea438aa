"""What an FMU costs: time per step, and memory that it does not give back."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from fmus.units.unit import EndRequested, UnitError
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.determinism import SEED
from orchestrator.exchange.passport.excitation import course, own_step
from orchestrator.exchange.passport.memory_used import Used, release_free_memory, used
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic
from orchestrator.exchange.passport.running import Running, put
from orchestrator.exchange.passport.workplace import Workplace

STEP_TIME: Final = Topic("cost.time", "A step takes less time than it simulates")
MEMORY: Final = Topic("cost.memory", "Memory does not grow with the number of steps")

_STEPS: Final = 10_000
_WARM_UP: Final = 500
"""The number of steps before memory is first looked at."""
_LOOKS: Final = 5
_TIME: Final = 4.0
"""[s] How long the steps may take; a slow FMU makes fewer of them."""
_LEAK: Final = 128 * 1024
"""[byte] Growth that is no more than noise."""
_ENOUGH: Final = 512 * 1024 * 1024
"""[byte] Growth after which no more steps are made."""


@dataclass(frozen=True)
class Costs:
    """What some steps took."""

    times: tuple[float, ...]
    """[s] Median, 99th percentile and maximum of the time of a step, with its inputs set and its outputs fetched."""
    memory: tuple[Used, ...]
    """What the process used at several moments; empty where the system does not tell it."""
    steps: int
    """The number of steps between the first and the last of these moments."""


def costs(place: Workplace, h: float) -> Costs:
    """Make many steps, and note their times and the memory of the process."""
    place.tell(f"making {_STEPS} steps")
    given = course(place.archive, h, _WARM_UP, SEED)
    ends = time.monotonic() + _TIME
    times = np.zeros(_STEPS)
    memory: list[Used] = []
    with Running(place.archive, h) as running:
        done = 0
        release_free_memory()
        for k in range(_STEPS):
            put(running.inputs, {kind: table[k % _WARM_UP] for kind, table in given.inputs.items()})
            began = time.perf_counter()
            try:
                running.step()
            except EndRequested:
                if k == 0:
                    raise
                break
            except UnitError:
                if k == 0 or running.time < (place.archive.suggested.stop or math.inf) - h:
                    raise  # beyond its stop time it may refuse
                break
            times[k] = time.perf_counter() - began
            done = k + 1
            if done >= _WARM_UP and (done - _WARM_UP) % ((_STEPS - _WARM_UP) // _LOOKS) == 0:
                memory.append(used())
                if grown(memory) > _ENOUGH:
                    break
            if time.monotonic() > ends:
                break
        memory.append(used())
    made = times[:done]
    figures = (float(np.median(made)), float(np.percentile(made, 99)), float(made.max()))
    return Costs(figures, tuple(memory), max(0, done - _WARM_UP))


def grown(memory: Sequence[Used]) -> int:
    """How much memory has grown from the first to the last moment [byte], by whichever of both ways tells more."""
    return max((last - first for first, last in zip(memory[0], memory[-1], strict=True)), default=0)


def lines(bench: Bench) -> list[Line]:
    """The lines about time and memory."""
    h = own_step(bench.archive)
    try:
        measured = bench.measure(costs, h)
    except MeasurementError as error:
        return [topic.fails(str(error)) for topic in (STEP_TIME, MEMORY)]
    return [_time(measured, h), _memory(measured)]


def _time(measured: Costs, h: float) -> Line:
    median, late, longest = measured.times
    figures = {
        "median": Measured(median * 1e6, "us"),
        "p99": Measured(late * 1e6, "us"),
        "longest": Measured(longest * 1e6, "us"),
        "speed": Measured(h / median, "1"),
    }
    speed = round(h / median) if h > 10 * median else round(h / median, 2)
    text = f"{median * 1e6:.3g} us per step of {h:g} s (99 % within {late * 1e6:.3g} us): {speed:,} times real time"
    return STEP_TIME.passes(text, figures) if late < h else STEP_TIME.fails(text, figures)


def _memory(measured: Costs) -> Line:
    if not any(measured.memory):
        return MEMORY.does_not_apply("the system does not tell")
    if measured.steps < _WARM_UP:
        return MEMORY.does_not_apply(f"only {measured.steps} steps in {_TIME:g} s")
    growth = grown(measured.memory)
    each = growth / measured.steps
    figures = {"growth": Measured(growth, "byte"), "steps": Measured(measured.steps, "1")}
    text = f"{growth / 1024:.0f} KiB more after {measured.steps} steps"
    pairs = [*pairwise(measured.memory[:-1])] or [(measured.memory[0], measured.memory[-1])]
    usual = float(np.median([grown(pair) for pair in pairs]))
    if growth > _LEAK and usual * len(pairs) > growth / 2:  # what is taken once is no leak
        return MEMORY.fails(f"{text}, {each:.3g} bytes per step", figures | {"per_step": Measured(each, "byte")})
    return MEMORY.passes(text, figures)
