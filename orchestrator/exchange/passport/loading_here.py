"""Whether the library of an FMU loads here, has all functions of FMI, and makes its first step."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from typing import Final

from fmus.reading.library import missing_functions
from fmus.reading.needed_functions import all_functions
from fmus.units.make import fmu_unit
from fmus.units.unit import EndRequested
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.excitation import own_step
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic, named
from orchestrator.exchange.passport.running import Running
from orchestrator.exchange.passport.workplace import Workplace

LOADS: Final = Topic("library.loads", "Its library loads here and makes an instance")
EXPORTED: Final = Topic("library.functions", "It exports all functions of FMI")
FIRST_STEP: Final = Topic("library.first_step", "It initialises and makes its first step")


def instantiate(place: Workplace) -> float:
    """Load the library and make an instance; the time that it takes [s]."""
    place.tell("loading the library and making an instance")
    began = time.perf_counter()
    unit = fmu_unit("fmu", replace(place.archive, unpacked=None))
    took = time.perf_counter() - began
    unit.close()
    return took


def first_step(place: Workplace, h: float) -> float:
    """Initialise the FMU and make one step; the time that the step takes [s]."""
    place.tell("initialising")
    with Running(place.archive, h) as running:
        place.tell("its first step")
        began = time.perf_counter()
        with suppress(EndRequested):
            running.step()
        took = time.perf_counter() - began
        place.tell("ending")
    return took


def lines(bench: Bench) -> tuple[list[Line], bool]:
    """The lines about the library, and whether the FMU runs at all."""
    try:
        took = bench.measure(instantiate)
    except MeasurementError as error:
        why = f"it does not load: see {LOADS.key}"
        return [LOADS.fails(str(error)), _functions(bench), FIRST_STEP.does_not_apply(why)], False
    loads = LOADS.passes(f"in {took * 1e3:.3g} ms", {"time": Measured(took * 1e3, "ms")})
    try:
        h = own_step(bench.archive)
        step = bench.measure(first_step, h)
    except MeasurementError as error:
        return [loads, _functions(bench), FIRST_STEP.fails(str(error))], False
    fine = f"from 0 s to {h:g} s in {step * 1e3:.3g} ms"
    return [loads, _functions(bench), FIRST_STEP.passes(fine, {"time": Measured(step * 1e3, "ms")})], True


def _functions(bench: Bench) -> Line:
    archive = bench.archive
    if archive.library is None:
        return EXPORTED.does_not_apply("it is compiled here from its sources")
    if archive.code.exports is None:
        return EXPORTED.does_not_apply(f"its library does not tell: see {LOADS.key}")
    n, missing = len(all_functions(archive)), missing_functions(archive, archive.code.exports)
    if missing:
        return EXPORTED.fails(f"{len(missing)} of {n} are missing: {named(missing)}", details=missing)
    return EXPORTED.passes(f"all {n} of {archive.chosen.in_words}")
