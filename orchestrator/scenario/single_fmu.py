"""A single FMU as a system: its inputs are held at their start values, or at values that a person sets."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Options
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.system.experiment import STEP, Scenario, macro_step
from orchestrator.system.files import Given
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
    fmu = Fmu(path, lenient=options.lenient)
    archive, interface = fmu.archive, fmu.interface
    if unknown := settings.keys() - {unit}:
        raise refuse(f"--set {min(unknown)}", "an unknown unit", unit, f"Write --set {unit}.NAME=VALUE.")
    mine = settings.get(unit, ())
    inputs = {v.name for v in interface.inputs}
    resolved = resolve(unit, interface.parameters, settings=[s for s in mine if s.name not in inputs])
    start_values = {
        v.name: Given(value=_start(v, interface.starts), unit=v.quantity.unit, source="its start value")
        for v in interface.inputs
    }
    held = resolve(unit, interface.inputs, given=start_values, settings=[s for s in mine if s.name in inputs])
    raise_if_any([*resolved.problems, *held.problems])
    h, until, remarks = _experiment(archive, options)
    if held.values:
        inputs_text = ", ".join(f"{held.path(name)} = {value}" for name, value in held.values.items())
        remarks.append(f"nothing drives the inputs {inputs_text}")
    return Scenario(
        name=re.sub(r"[^\w-]+", "_", path.stem),
        title=archive.title,
        system=System(
            isolated({unit: fmu.with_parameters(resolved.values)}, options.isolate),
            {},
            {held.path(name): value for name, value in held.values.items()},
        ),
        scene=None,
        h=h,
        until=until,
        sources=resolved.sources,
        remarks=(*archive.remarks, *remarks),
    )


def _start(variable: Variable, starts: Mapping[str, Any]) -> Any:
    value = starts.get(variable.name, zeros(variable.quantity.type, variable.shape))
    return value.tolist() if hasattr(value, "tolist") else value


def _experiment(archive: Archive, options: Options) -> tuple[float, float, list[str]]:
    """The macro step and the stop time [s], and what was decided because neither the FMU nor the user says it."""
    remarks: list[str] = []
    step, until = archive.default_step, archive.default_stop_time
    h = macro_step((STEP if step is None else step) if options.step is None else options.step)
    if options.step is None and step is None:
        remarks.append(f"the FMU says no step: {STEP:g} s is used; --step changes it")
    if options.stop_time is not None:
        return h, options.stop_time, remarks
    if until is None or not math.isfinite(until):
        raise refuse("stop time", "none in the FMU", "a number of seconds", "Say how long with --stop-time.")
    ticks = round(until / h)
    return h, until if abs(ticks * h - until) <= 1e-9 * max(1.0, until) else ticks * h, remarks
