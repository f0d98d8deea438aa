"""A single FMU as a system: its inputs are held at their start values, or at values that a person sets."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from components.interfaces.problem import choices, raise_if_any, refuse
from fmus.unit_interface import SuggestedExperiment
from orchestrator.scenario.interface_choice import interface_choice
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Options
from orchestrator.scenario.resolution import Setting, resolve_unit, with_lengths
from orchestrator.scenario.suggested_times import suggested_step, whole_steps
from orchestrator.system.experiment import Scenario, macro_step
from orchestrator.system.named_variables import own_values
from orchestrator.system.source import Fmu
from orchestrator.system.system import System


def single_fmu(path: Path, settings: Mapping[str, Sequence[Setting]], options: Options) -> Scenario:
    """Make an FMU the only unit of a system, named `fmu`, with the experiment that the FMU suggests.

    Args:
        path: The FMU.
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
    fmu = with_lengths(unit, Fmu(path, lenient=options.lenient, interface_type=choice.of(unit)), settings=mine)
    resolved = resolve_unit(unit, fmu, settings=mine)
    raise_if_any(resolved.problems)
    fmu = fmu.with_parameters(resolved.of_role("parameters", "initials"))
    archive, inputs = fmu.archive, {v.name for v in fmu.interface.inputs}
    held = {name: _plain(start) for name, start in fmu.interface.starts.items() if name in inputs}
    held |= resolved.of_role("inputs")
    start, h, until, remarks = _times(archive.suggested, options)
    unset = sorted(inputs - held.keys())
    if unset:
        remarks += (f"nothing drives or sets the inputs {choices(unset)}: they keep the values inside the FMU",)
    if held:
        inputs_text = ", ".join(f"{resolved.path(name)} = {value}" for name, value in held.items())
        remarks += (f"nothing drives the inputs {inputs_text}",)
    remarks += (*own_values(unit, fmu),)
    return Scenario(
        name=re.sub(r"[^\w-]+", "_", path.stem),
        title=archive.title,
        system=System(
            isolated({unit: fmu}, options.isolate),
            {},
            {resolved.path(name): value for name, value in held.items()},
            unset={f"{unit}.{name}" for name in unset},
        ),
        scene=None,
        h=h,
        until=until,
        start=start,
        sources={path: told for path, told in resolved.sources.items() if path.partition(".")[2] not in held},
        remarks=(*archive.remarks, *remarks),
    )


def _times(wished: SuggestedExperiment, options: Options) -> tuple[float, float, float, tuple[str, ...]]:
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
    if wished.stop is None or not math.isfinite(wished.stop):
        raise refuse("stop time", "none in the FMU", "a number of seconds", "Say how long with --stop-time.")
    until, cut = whole_steps(start, h, wished.stop)
    return start, h, until, (*remarks, *cut)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value
