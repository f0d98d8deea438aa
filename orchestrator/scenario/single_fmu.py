"""A single FMU as a system: its inputs are held at their start values, or at values that a person sets."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from components.interfaces.problem import Problem, choices, raise_if_any, refuse
from fmus.toolchain.version import Version
from fmus.unit_interface import SuggestedExperiment
from orchestrator.scenario.driven_inputs import with_table
from orchestrator.scenario.interface_choice import interface_choice
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Options
from orchestrator.scenario.resolution import Resolution, Setting, resolve_unit, with_lengths
from orchestrator.scenario.suggested_times import suggested_step, whole_steps
from orchestrator.scenario.table_file import read_table
from orchestrator.system.experiment import Scenario, macro_step
from orchestrator.system.named_variables import own_values
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from orchestrator.system.value_texts import plain


def single_fmu(fmu: Fmu, settings: Mapping[str, Sequence[Setting]], options: Options) -> Scenario:
    """Make an FMU the only unit of a system, named `fmu`, with the experiment that the FMU suggests.

    Args:
        fmu: The FMU, without values.
        settings: The values of parameters and inputs that a person sets, by unit.
        options: The changes to the experiment, and how the FMU is run.

    Raises:
        RequestError: The FMU cannot be used, or a setting or an option is wrong.
    """
    unit = "fmu"
    if unknown := settings.keys() - {unit}:
        raise refuse(f"--set {min(unknown)}", "an unknown unit", unit, f"Write --set {unit}.NAME=VALUE.")
    choice = interface_choice(options.interface, [unit])
    mine = settings.get(unit, ())
    fmu = replace(fmu, lenient=options.lenient, interface_type=choice.of(unit))
    fmu = with_lengths(unit, fmu, settings=mine)
    resolved = resolve_unit(unit, fmu, settings=mine)
    raise_if_any(_problems(fmu, resolved))
    fmu = fmu.with_parameters(resolved.of_role("parameters", "initials"))
    archive, inputs = fmu.archive, {v.name for v in fmu.interface.inputs}
    held = {name: plain(start) for name, start in fmu.interface.starts.items() if name in inputs}
    held |= resolved.of_role("inputs")
    table = None if options.input is None else read_table(Path(options.input))
    start, h, until, remarks = _times(archive.suggested, options, None if table is None else float(table.times[-1]))
    system = System(
        isolated({unit: fmu}, options.isolate, in_process=options.in_process),
        {},
        {resolved.path(name): value for name, value in held.items()},
        unset={f"{unit}.{name}" for name in inputs - held.keys()},
    )
    if table is not None:
        system, taken = with_table(system, table, hold=options.input_hold)
        remarks += tuple(taken)
    return Scenario(
        name=re.sub(r"[^\w-]+", "_", fmu.path.stem),
        title=archive.title,
        system=system,
        scene=None,
        h=h,
        until=until,
        start=start,
        sources={path: told for path, told in resolved.sources.items() if path.partition(".")[2] not in held},
        remarks=(*archive.remarks, *remarks, *_undriven(system), *own_values(unit, fmu)),
    )


def _undriven(system: System) -> Iterator[str]:
    """Remarks on the inputs that nothing drives."""
    if unset := sorted(path.partition(".")[2] for path in system.unset):
        yield f"nothing drives or sets the inputs {choices(unset)}: they keep the values inside the FMU"
    tabled = () if system.table is None else tuple(system.table.paths)
    if held := {path: value for path, value in system.held.items() if path not in tabled}:
        yield f"nothing drives the inputs {', '.join(f'{path} = {value}' for path, value in held.items())}"


def _problems(fmu: Fmu, resolved: Resolution) -> Iterator[Problem]:
    """The problems of values, with what to do about infinite ones and NaN; only FMI 3.0 has them."""
    starts = fmu.interface.starts
    own = {v.name: starts[v.name] for v in fmu.interface.inputs if v.name in starts and v.name not in resolved.values}
    quantities = {v.name: v.quantity for v in fmu.interface.inputs}
    problems = [p for name, start in own.items() for p in quantities[name].problems(resolved.path(name), start)]
    values = {resolved.path(name): value for name, value in {**own, **resolved.values}.items()}
    for problem in (*resolved.problems, *problems):
        special = _has_special(values.get(problem.where))
        lenient = special and fmu.archive.version is not Version.FMI3 and not problem.remedy
        yield replace(problem, remedy="Take it as it is with --lenient.") if lenient else problem


def _has_special(value: Any) -> bool:
    """Whether a number of a value is infinite or NaN; the value may have any form."""
    if isinstance(value, list):
        return any(map(_has_special, cast(list[Any], value)))
    numbers = np.asarray(value)
    return numbers.dtype.kind == "f" and not np.isfinite(numbers).all()


def _times(
    wished: SuggestedExperiment, options: Options, table_end: float | None
) -> tuple[float, float, float, tuple[str, ...]]:
    """The start time, the macro step and the stop time [s], and what was decided because nobody says it."""
    start = wished.start if options.start_time is None else options.start_time
    h, why = suggested_step({"fmu": wished})
    remarks: tuple[str, ...] = ()
    if options.step is not None:
        h = options.step
    elif wished.step is None:
        whole = f", {why}" if why else ""
        remarks = (f"the FMU says no step: {h:g} s is used{whole}; --step changes it",)
    macro_step(h)
    if options.stop_time is not None:
        return start, h, options.stop_time, remarks
    if (wished.stop is None or not math.isfinite(wished.stop)) and table_end is not None:
        until, _ = whole_steps(start, h, table_end)
        return start, h, until, (*remarks, f"the run ends with the input table, at {until:g} s; --stop-time changes it")
    if wished.stop is None or not math.isfinite(wished.stop):
        raise refuse("stop time", "none in the FMU", "a number of seconds", "Say how long with --stop-time.")
    until, cut = whole_steps(start, h, wished.stop)
    return start, h, until, (*remarks, *cut)
