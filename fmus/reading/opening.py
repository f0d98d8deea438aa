"""Opening an FMU: what it says it is, checked before anything of it runs."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from components.interfaces.problem import RequestError, refuse
from components.interfaces.record import Variable
from fmus.clock import clocks
from fmus.reading.archive import VALID, Archive
from fmus.reading.description import Description, read_description
from fmus.reading.library import binary_remark
from fmus.reading.ports import Port, aliases, ports, whole_name
from fmus.reading.unpack import read
from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.fmpy_library import ModelDescription
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface


def open_fmu(path: Path, values: Mapping[str, Any] = MappingProxyType({}), *, lenient: bool = False) -> Archive:
    """Read an FMU's description. Raises `RequestError` when it is none, or none that can run here.

    `values` are those of its parameters that are given: the structural ones decide the lengths of arrays. A `lenient`
    reader overlooks broken rules that do not keep the FMU from running; they become remarks.
    """
    where = str(path)
    known, contents = read(path, {MODEL_DESCRIPTION}, where, VALID)
    if MODEL_DESCRIPTION not in contents:
        raise refuse(where, f"an archive without {MODEL_DESCRIPTION}", VALID)
    read_one = read_description(contents[MODEL_DESCRIPTION], where, lenient=lenient)
    found = _ports(read_one, values, where)
    archive = Archive(
        path,
        read_one.version,
        read_one.model,
        _interface(read_one, found),
        references={p.variable.name: p.references for p in found},
        structural=tuple(p.variable.name for p in found if p.structural),
        clocks_of={p.variable.name: frozenset(p.clocks) for p in found if p.clocks},
        remarks=read_one.remarks,
        files=known,
        root=read_one.root,
    )
    needs = ["needs the tool that made it to be installed"] if archive.kind.needsExecutionTool else []
    if told := binary_remark(archive):
        needs.append(told)
    return replace(archive, remarks=(*archive.remarks, *needs))


def _ports(description: Description, values: Mapping[str, Any], where: str) -> list[Port]:
    try:
        return ports(description.root, description.model, description.version, values)
    except RequestError:
        raise
    except (ValueError, LookupError, TypeError, AttributeError) as error:  # only what the schema refuses gets here
        found = f"a variable that cannot be understood ({error})"
        raise refuse(f"{where}, {MODEL_DESCRIPTION}", found, "what FMI allows") from error


def _interface(read_one: Description, found: list[Port]) -> Interface:
    description = read_one.model
    inputs, outputs, parameters = (
        [p.variable for p in found if p.causality == causality] for causality in ("input", "output", "parameter")
    )
    return Interface(
        kind=str(description.modelName),
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        parameters=tuple(parameters),
        feedthrough=_feedthrough(description, outputs, inputs),
        output_after_set=description.coSimulation is None or _output_after_set(read_one.root),
        starts={p.variable.name: p.start for p in found if p.start is not None},
        rolls_back=_rolls_back(description),
        event_mode=read_one.version == Version.FMI3 and bool(getattr(description.coSimulation, "hasEventMode", False)),
        clocks=clocks(read_one.root),
        aliases=aliases(description),
        undeclared=_undeclared(description, outputs),
        initials=tuple(p.variable for p in found if p.causality == "initial"),
    )


def _feedthrough(description: ModelDescription, outputs: list[Variable], inputs: list[Variable]) -> Any:
    """From the model structure; an output without declared dependencies is taken to depend on every input."""
    column = {v.name: i for i, v in enumerate(inputs)}
    row = {v.name: i for i, v in enumerate(outputs)}
    found = np.zeros((len(outputs), len(inputs)), dtype=bool)
    listed: set[str] = set()
    for unknown in description.outputs:
        name = whole_name(unknown.variable.name, row) if unknown.variable else None
        if name is None:
            continue
        listed.add(name)
        if unknown.dependencies is None:
            found[row[name], :] = True
        for source in unknown.dependencies or []:
            if (whole := whole_name(source.name, column)) is not None:
                found[row[name], column[whole]] = True
    for name in row.keys() - listed:
        found[row[name], :] = True
    return found


def _undeclared(description: ModelDescription, outputs: list[Variable]) -> frozenset[str]:
    """Outputs that the model structure lists without dependencies, or not at all."""
    known = {v.name: v for v in outputs}
    told = {
        whole_name(u.variable.name, known) for u in description.outputs if u.variable and u.dependencies is not None
    }
    return frozenset(known.keys() - told)


def _rolls_back(description: ModelDescription) -> bool:
    return bool(description.coSimulation and description.coSimulation.canGetAndSetFMUstate)


def _output_after_set(root: Any) -> bool:
    """Whether the FMU promises, by our vendor annotation, that its outputs follow its inputs before the step."""
    return bool(root.xpath("//*[local-name()='Outputs' and @afterSet='true']"))
