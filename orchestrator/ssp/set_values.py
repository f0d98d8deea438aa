"""The values of an SSP's units after a person's settings: parameters, start values, and inputs that nothing drives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from orchestrator.scenario.resolution import Resolution, Setting, resolve_unit, with_lengths
from orchestrator.ssp.assembly import Assembly
from orchestrator.ssp.parameter_values import ParameterValue
from orchestrator.ssp.ssp_units import SspUnit, compare, opened
from orchestrator.system.files import Given
from orchestrator.system.named_variables import FREE, own_values, settable
from orchestrator.system.source import UnitSource

ValueSources: TypeAlias = dict[str, Mapping[str, Any]]
"""Value, unit of measurement and source of values, by full path."""


def with_own_lengths(unit: SspUnit, settings: Sequence[Setting], assembly: Assembly) -> SspUnit:
    """A unit whose arrays have the lengths that the SSP and a person give them.

    Args:
        unit: The unit as its file has it.
        settings: What a person sets in it.
        assembly: The system, which has the values of the SSP.
    """
    if not unit.structural:
        compare(unit, assembly.findings)
        return unit
    of_file = _given(unit, assembly.parameters(unit, unit.structural))
    by_file = unit.opened_with(with_lengths(unit.name, unit.source, of_file), assembly.findings)
    compare(by_file, assembly.findings)
    chosen = unit.opened_with(with_lengths(unit.name, unit.source, of_file, settings), assembly.findings)
    outgrown = {
        name
        for name, found in by_file.variables.items()
        if (then := chosen.settable(found.variable.name)) and then.variable.shape != found.variable.shape
    }
    given = assembly.values.variables.get(unit.component.path, {})
    if unused := [name for name in given if name in outgrown]:
        text = "the values in the file are for arrays of other lengths, and are not used"
        assembly.findings.remarks.append(f"{unit.name}: {text}: {', '.join(unused)}")
    for name in unused:
        del given[name]
    assembly.outgrown |= {f"{unit.name}.{name}" for name in outgrown}
    return chosen


def with_values(unit: SspUnit, settings: Sequence[Setting], assembly: Assembly) -> tuple[UnitSource, ValueSources]:
    """The source of a unit with the values of the SSP and of a person, and where they come from.

    Args:
        unit: The unit, whose arrays have their lengths.
        settings: What a person sets in it; inputs are passed over.
        assembly: The system, which has the values of the SSP, and whose findings get the problems.
    """
    given, known = _given(unit, assembly.parameters(unit)), settable(unit.source) if settings else {}
    meant = [(setting, setting.means(known)) for setting in settings]
    for _, found in meant:
        if found is not None:  # what is wrong with it does not stand in the file
            assembly.places.pop(f"{unit.name}.{found[0].variable.name}", None)
    others = [setting for setting, found in meant if found is None or found[0].role != "inputs"]
    resolved = resolve_unit(unit.name, unit.source, given, others)
    assembly.findings.problems += [assembly.placed(p) for p in resolved.problems]
    source = unit.source.with_parameters(resolved.of_role("parameters", "initials"))
    if (free := resolved.of_role(FREE)) and not resolved.problems:
        source = source.holding(free)
    if unit.structural and opened(source, unit.component, assembly.findings) is None:
        source = unit.source
    assembly.findings.remarks += own_values(unit.name, source)
    return source, resolved.sources


def held_values(
    units: Iterable[SspUnit],
    settings: Mapping[str, Sequence[Setting]],
    assembly: Assembly,
    of_annotation: Mapping[str, Any],
) -> tuple[dict[str, Any], ValueSources]:
    """The values that inputs hold which nothing drives, and where those of a person come from.

    Args:
        units: The units, which are connected already.
        settings: What a person sets, by unit; all but inputs is passed over.
        assembly: The system, which has the values of the SSP, and whose findings get the problems.
        of_annotation: The values in the annotation of this program, which replace those.

    Returns:
        The values and the sources, by full path.
    """
    held = assembly.held | {path: v for path, v in of_annotation.items() if path not in assembly.outgrown}
    sources: ValueSources = {}
    for unit in units:
        if not settings.get(unit.name):
            continue
        resolved = _inputs(unit, settings[unit.name], assembly, held)
        held |= {resolved.path(name): value for name, value in resolved.values.items()}
        sources |= resolved.sources
    assembly.unset -= sources.keys()
    assembly.undriven = [one for one in assembly.undriven if one.path not in sources]
    return held, sources


def _inputs(unit: SspUnit, settings: Sequence[Setting], assembly: Assembly, held: Mapping[str, Any]) -> Resolution:
    """The inputs of a unit that a person sets."""
    known = settable(unit.source)
    chosen: dict[Setting, str] = {}
    for setting in settings:
        found = setting.means(known)
        if found is None or found[0].role != "inputs":
            continue
        if (driver := assembly.driver(unit, found[0])) is None:
            chosen[setting] = found[0].variable.name
        else:
            assembly.findings.add_problem(
                f"--set {unit.name}.{setting.assignment}",
                f"a value for an input that `{driver}` drives",
                "an input that nothing drives",
            )
    given = {
        v.name: Given(value=np.array(held[path], dtype=object).tolist(), unit=v.quantity.unit, source="")
        for v in unit.source.interface.inputs
        if (path := f"{unit.name}.{v.name}") in held and v.name in chosen.values()
    }
    resolved = resolve_unit(unit.name, unit.source, given, [*chosen], ["inputs"])
    assembly.findings.problems += resolved.problems
    return resolved


def _given(unit: SspUnit, values: Mapping[str, tuple[Any, ParameterValue]]) -> dict[str, Given]:
    """The values of the SSP, in the units of measurement of the unit's variables."""
    interface = unit.source.interface
    units = {v.name: v.quantity.unit for v in (*interface.parameters, *interface.initials)}
    return {n: Given(value=v, unit=units[n], source=value.origin) for n, (v, value) in values.items()}
