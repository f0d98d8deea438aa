"""Opening an FMU: its description is read and checked before any of its code runs."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import gc
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from components.interfaces.problem import RequestError, choices, refuse
from components.interfaces.record import Variable
from fmus.clock import Clock, clock_of
from fmus.reading.archive import VALID_FMU, Archive, InterfaceType, interface_types
from fmus.reading.declared_variables import DeclaredVariable, aliases, declared_variables
from fmus.reading.description import Description, not_understood, read_description
from fmus.reading.joined_arrays import whole_name
from fmus.reading.known_archives import known_or_read
from fmus.reading.library import with_library
from fmus.reading.unpack import read
from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.door import reading
from fmus.toolchain.fmpy_library import ModelDescription
from fmus.toolchain.limits import LARGEST_FEEDTHROUGH
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface


def open_fmu(
    path: Path,
    values: Mapping[str, Any] = MappingProxyType({}),
    *,
    lenient: bool = False,
    interface_type: InterfaceType | None = None,
    where: str = "",
) -> Archive:
    """Read an FMU's description.

    Args:
        path: The FMU.
        values: The values of its parameters that are given; those of structural ones determine the lengths of arrays.
        lenient: Whether breaches of rules without which the FMU can be run become remarks.
        interface_type: The interface type that is used; Co-Simulation, where it has that, if not given.
        where: The FMU, as messages name it; its path, if not given.

    Raises:
        RequestError: The file is no FMU, or not one that can run here.
    """
    where = where or str(path)

    def read_all() -> Archive:
        with _without_garbage_collection(), reading(where, VALID_FMU):
            return _open(path, values, interface_type, where, lenient=lenient)

    return known_or_read(path, (where, interface_type, lenient), read_all)


@contextmanager
def _without_garbage_collection() -> Generator[None]:
    """Python's collector of cycles would look at the objects of a large description again and again, for nothing."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _open(
    path: Path, values: Mapping[str, Any], interface_type: InterfaceType | None, where: str, *, lenient: bool
) -> Archive:
    content = read(path, {MODEL_DESCRIPTION}, where, VALID_FMU)
    if MODEL_DESCRIPTION not in content.files:
        raise refuse(where, f"an archive without {MODEL_DESCRIPTION}", VALID_FMU)
    description = read_description(content.files[MODEL_DESCRIPTION], where, lenient=lenient)
    variables = _variables(description, values, where, lenient=lenient)
    if lenient or description.version is Version.FMI3:  # the other versions say nothing of infinite values and NaN
        variables = [_of_any_number(v) for v in variables]
    chosen = _chosen(description.model, interface_type, where)
    archive = Archive(
        path,
        description.version,
        description.model,
        _interface(description, variables, chosen, where),
        references={v.variable.name: v.references for v in variables},
        structural=tuple(v.variable.name for v in variables if v.structural),
        negated=frozenset(v.variable.name for v in variables if v.negated),
        clocks_of={v.variable.name: frozenset(v.clocks) for v in variables if v.clocks},
        remarks=(*content.remarks, *description.remarks),
        breaks_rules=description.breaks_rules,
        files=content.names,
        root=description.root,
        chosen=chosen,
        where=where,
    )
    _check_experiment(archive)
    if archive.interface_type.needsExecutionTool:
        archive = replace(archive, remarks=(*archive.remarks, "needs the tool that made it to be installed"))
    return with_library(archive, lenient=lenient)


def _check_experiment(archive: Archive) -> None:
    """Refuse an experiment whose times are no numbers."""
    element = archive.root.find("DefaultExperiment")
    line = "" if element is None else f", line {element.sourceline}"
    with reading(f"{archive.where}, {MODEL_DESCRIPTION}{line}", "times in seconds, as numbers"):
        _ = archive.suggested


def _of_any_number(declared: DeclaredVariable) -> DeclaredVariable:
    v = declared.variable
    return replace(declared, variable=replace(v, quantity=replace(v.quantity, finite=False)))


def _variables(
    description: Description, values: Mapping[str, Any], where: str, *, lenient: bool
) -> list[DeclaredVariable]:
    try:
        return declared_variables(description.root, description.model, description.version, values)
    except RequestError:
        raise
    except Exception as error:  # caused by content that the schema forbids
        raise not_understood(error, where, lenient=lenient) from error


def _chosen(model: ModelDescription, wanted: InterfaceType | None, where: str) -> InterfaceType:
    offered = interface_types(model)
    if wanted is not None and wanted not in offered:
        raise refuse(where, f"no {wanted}", choices(offered), "Export it with both, or choose what it has.")
    return wanted or offered[0]


def _interface(
    description: Description, variables: list[DeclaredVariable], chosen: InterfaceType, where: str
) -> Interface:
    model, is_integrated = description.model, chosen is InterfaceType.MODEL_EXCHANGE
    inputs, outputs, parameters, initials = (
        [v.variable for v in variables if v.causality == causality]
        for causality in ("input", "output", "parameter", "initial")
    )
    return Interface(
        kind=str(model.modelName),
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        parameters=tuple(parameters),
        feedthrough=_feedthrough(model, outputs, inputs, where),
        output_after_set=is_integrated or _output_after_set(description.root),
        starts={v.variable.name: v.start for v in variables if v.start is not None},
        rolls_back=not is_integrated and bool(getattr(model.coSimulation, "canGetAndSetFMUstate", False)),
        event_mode=description.version == Version.FMI3
        and not is_integrated
        and bool(getattr(model.coSimulation, "hasEventMode", False)),
        clocks=tuple(_clocks(description.root, where)),
        aliases=aliases(model, [v.variable.name for v in variables if v.negated]),
        undeclared=_undeclared(model, outputs),
        initials=tuple(initials),
        variability={v.variable.name: v.variability for v in variables if v.causality != "output"},
    )


def _clocks(root: Any, where: str) -> Iterator[Clock]:
    for element in root.iterfind("ModelVariables/Clock"):
        valid = "a clock as FMI 3.0 allows it"
        with reading(f"{where}, {MODEL_DESCRIPTION}, line {element.sourceline}", valid, what="a wrong clock"):
            yield clock_of(element)


def _feedthrough(model: ModelDescription, outputs: list[Variable], inputs: list[Variable], where: str) -> Any:
    """The feedthrough that the model structure declares; an output without dependencies is taken to depend on all.

    Returns:
        An array of shape `(outputs, inputs)`.
    """
    if (pairs := len(outputs) * len(inputs)) > LARGEST_FEEDTHROUGH:
        found = f"{len(outputs)} outputs and {len(inputs)} inputs, which are {pairs} pairs"
        raise refuse(f"{where}, {MODEL_DESCRIPTION}", found, f"at most {LARGEST_FEEDTHROUGH} pairs")
    column = {v.name: i for i, v in enumerate(inputs)}
    row = {v.name: i for i, v in enumerate(outputs)}
    feedthrough = np.zeros((len(outputs), len(inputs)), dtype=bool)
    listed: set[str] = set()
    for unknown in model.outputs:
        name = whole_name(unknown.variable.name, row) if unknown.variable else None
        if name is None:
            continue
        listed.add(name)
        if unknown.dependencies is None:
            feedthrough[row[name], :] = True
        for source in unknown.dependencies or []:
            if (whole := whole_name(source.name, column)) is not None:
                feedthrough[row[name], column[whole]] = True
    for name in row.keys() - listed:
        feedthrough[row[name], :] = True
    return feedthrough


def _undeclared(model: ModelDescription, outputs: list[Variable]) -> frozenset[str]:
    """The outputs that the model structure lists without dependencies, or not at all."""
    known = {v.name: v for v in outputs}
    declared = {whole_name(u.variable.name, known) for u in model.outputs if u.variable and u.dependencies is not None}
    return frozenset(known.keys() - declared)


def _output_after_set(root: Any) -> bool:
    """Whether our vendor annotation declares that the FMU's outputs follow its inputs before the step."""
    parts = "/*/VendorAnnotations//*", "/*/Annotations//*"
    return any(root.xpath(f"{part}[local-name()='Outputs' and @afterSet='true']") for part in parts)
