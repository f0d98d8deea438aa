"""What fills the sockets of a scenario: a block with its values, or an FMU, its mapping and the values it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.block import Block
from components.interfaces.conversion import unit_conversion
from components.interfaces.problem import Problem, refuse
from components.interfaces.quantity import Quantity
from components.interfaces.sockets import SOCKETS, standard_wiring
from fmus.unit_interface import Interface
from orchestrator.mapping.mapped import fitted
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.scenario.parameters import block_parameters
from orchestrator.scenario.resolution import Resolution, Setting, resolve
from orchestrator.scenario.scenario_file import SocketFilling
from orchestrator.system.files import Given
from orchestrator.system.source import Fmu, UnitSource

FOREIGN: Final = (".fmu", ".toml")
"""How the name of an FMU, or of its mapping file, ends."""


@dataclass(frozen=True)
class Filled:
    """What fills a socket: a block that is still to be made a source of, or the source of an FMU."""

    resolution: Resolution
    block: type[Block[Any, Any, Any]] | None = None
    fmu: UnitSource | None = None
    problems: Sequence[Problem] = ()
    remarks: Sequence[str] = ()


def filled_by_block(
    socket: str, filling: SocketFilling, block: type[Block[Any, Any, Any]], settings: Sequence[Setting]
) -> Filled:
    """A block of the catalogue, with the values of its parameter set under those of the scenario."""
    found = resolve(socket, block.parameters(), block_parameters(block.name), filling.parameters, settings)
    return Filled(found, block, problems=found.problems)


def filled_by_fmu(
    socket: str, filling: SocketFilling, mapping: MappingFile | None, settings: Sequence[Setting], *, lenient: bool
) -> Filled:
    """An FMU, with its parameters in its own units of measurement, and how it fits the socket."""
    path = Path(filling.fmu or "")
    fmu = Fmu(path, lenient=lenient)
    remarks = [f"{socket}: {path.name}: {remark}" for remark in fmu.archive.remarks]
    # values in other units of measurement stay as they are: the resolution tells of them
    given = filling.parameters | in_units_of(filling.parameters, fmu.interface)[0]
    found = resolve(socket, fmu.interface.parameters, given=given, settings=settings)
    fmu = fmu if found.problems else fmu.with_parameters(found.values)
    source, misfits, decisions = fitted(socket, SOCKETS[socket], fmu, mapping)
    return Filled(found, fmu=source, problems=[*found.problems, *misfits], remarks=[*remarks, *decisions])


def wiring_of(units: Mapping[str, UnitSource]) -> dict[str, str]:
    """How the sockets are connected, as their descriptions say; a bus that a unit does not read is left out."""
    read = {f"{name}.{v.name.partition('.')[0]}" for name, source in units.items() for v in source.interface.inputs}
    return {bus: source for bus, source in standard_wiring(units).items() if bus in read}


def located(filling: SocketFilling, request: str) -> SocketFilling:
    """The filling with its files where they are: beside the scenario's file `request`, if they are there."""
    given = {key: text for key in ("fmu", "mapping") if (text := getattr(filling, key)) is not None}
    beside = {key: Path(request).parent / text for key, text in given.items() if request.endswith(".toml")}
    return filling.model_copy(update={key: str(path) for key, path in beside.items() if path.is_file()})


def chosen_fmu(
    socket: str, filling: SocketFilling, request: str, remarks: list[str], *, lenient: bool = False
) -> SocketFilling:
    """The FMU (or mapping file) `request` in place of `filling`, whose parameters go along where they fit."""
    chosen, _ = with_mapping(SocketFilling(fmu=request), socket)
    interface = Fmu(Path(chosen.fmu or ""), lenient=lenient).interface
    declared = {v.name for v in interface.parameters}
    kept, other = in_units_of(filling.parameters, interface)
    dropped = sorted(filling.parameters.keys() - declared - chosen.parameters.keys())
    if dropped:
        remarks.append(f"{socket}: `{request}` has no parameters {', '.join(dropped)}; the scenario's are not used")
    if given := sorted(kept.keys() - chosen.parameters.keys()):
        remarks.append(f"{socket}: `{request}` is given the scenario's {', '.join(given)}")
    remarks += [
        f"{socket}: the scenario's {name} does not fit `{request}` ({other[name]}) and is not used"
        for name in sorted(other.keys() - chosen.parameters.keys())
    ]
    return chosen.model_copy(update={"parameters": {**kept, **chosen.parameters}, "step": filling.step})


def with_mapping(filling: SocketFilling, socket: str) -> tuple[SocketFilling, MappingFile | None]:
    """A filling that is an FMU, with its mapping file read. Raises `RequestError`.

    `filling.fmu` may name the mapping file itself, which then names the FMU; parameters that the scenario gives win
    over those of the mapping file.
    """
    request = filling.mapping
    if filling.fmu is not None and filling.fmu.endswith(".toml"):
        request, filling = filling.fmu, filling.model_copy(update={"fmu": None})
    if request is None:
        return filling, None
    mapping = read_mapping(Path(request), socket)
    path = mapping.fmu if filling.fmu is None else Path(filling.fmu)
    if path is None:
        raise refuse(f"{request}: fmu", "nothing", "the path of the FMU, relative to this file")
    own = {n: Given(value=a.value, unit=a.unit, source=Path(request).name) for n, a in mapping.parameters.items()}
    update = {"fmu": str(path), "mapping": request, "parameters": {**own, **filling.parameters}}
    return filling.model_copy(update=update), mapping


def in_units_of(given: Mapping[str, Given], theirs: Interface) -> tuple[dict[str, Given], dict[str, str]]:
    """Values in the units that an FMU declares for its parameters, and why others cannot be given to it.

    A parameter without a unit takes the number as it is; a shorter array leaves the FMU's other elements as they are.
    """
    declared = {v.name: v.quantity for v in theirs.parameters}
    found: dict[str, Given] = {}
    other: dict[str, str] = {}
    for name in (name for name in given if name in declared):
        q = declared[name]
        value = _converted(given[name], q)
        value = value and _lengthened(value, theirs.starts.get(name))
        if value is None or q.problems(name, value.value):
            other[name] = f"{given[name].value} [{given[name].unit}] against {q.range}"
        else:
            found[name] = value
    return found, other


def _lengthened(value: Given, start: Any) -> Given:
    items: Any = value.value
    if isinstance(items, list) and isinstance(start, np.ndarray) and start.ndim == 1:
        whole = [*items, *start.tolist()[len(items) :]]  # type: ignore[unknown]
        return value.model_copy(update={"value": whole})
    return value


def _converted(value: Given, q: Quantity) -> Given | None:
    """The value in the unit of `q`; None where it measures something else."""
    if value.unit == q.unit or not (q.unit and q.type.is_float):
        return value.model_copy(update={"unit": q.unit})
    relation = unit_conversion(Quantity(value.unit, ""), q)
    given: Any = value.value
    items: list[Any] = given if isinstance(given, list) else [given]  # type: ignore[unknown]
    if relation is None or any(isinstance(i, bool) or not isinstance(i, int | float) for i in items):
        return None
    numbers = [float(relation(item)) for item in items]
    return value.model_copy(update={"unit": q.unit, "value": numbers if items is given else numbers[0]})
