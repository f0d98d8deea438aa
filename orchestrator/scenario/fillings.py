"""Parts of a scenario that are FMUs of other makers: where they are, what maps them, and which parameters they take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.block import Block
from components.interfaces.conversion import unit_conversion
from components.interfaces.problem import Problem, refuse
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from components.interfaces.sockets import SOCKETS
from fmus.unit_interface import Interface
from orchestrator.mapping.mapped import Mapped, fitted
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.scenario.parameters import Given, Part, Setting, parameter_set, values_of
from orchestrator.system.source import Fmu, UnitSource

WIRING: Final = {
    "plant.actuation": "controller.actuation",
    "traffic.ego": "plant.state",
    "controller.ego": "plant.state",
    "controller.obstacles": "traffic.obstacles",
}
"""How the three sockets are connected, in every scenario."""

FOREIGN: Final = (".fmu", ".toml")
"""How the name of an FMU, or of its mapping file, ends"""


@dataclass
class Gathered:
    """What the parts of a scenario give, what is wrong with it, and what is to be said."""

    mappings: dict[str, MappingFile | None] = field(default_factory=dict[str, MappingFile | None])
    values: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    sources: dict[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    foreign: dict[str, UnitSource] = field(default_factory=dict[str, UnitSource])
    problems: list[Problem] = field(default_factory=list[Problem])
    remarks: list[str] = field(default_factory=list[str])

    def of_block(self, socket: str, part: Part, kind: type[Block[Any, Any, Any]], settings: Sequence[Setting]) -> None:
        """The parameters of a block."""
        defaults = parameter_set(kind.name)
        self.values[socket], found = values_of(socket, kind.parameters(), defaults, part.parameters, settings)
        self.problems += found
        given = {**defaults, **part.parameters}
        self.sources |= sources_of(socket, kind.parameters(), self.values[socket], given, settings)

    def of_fmu(self, socket: str, part: Part, settings: Sequence[Setting], *, lenient: bool) -> None:
        """The parameters of an FMU, in its own units, and how it fills its socket."""
        path = Path(part.fmu or "")
        fmu = Fmu(path, lenient=lenient)
        self.remarks += [f"{socket}: {path.name}: {told}" for told in fmu.archive.remarks]
        # those in other units are told when they are checked
        given = part.parameters | in_units_of(part.parameters, fmu.interface)[0]
        declared = fmu.interface.parameters
        values, found = values_of(socket, declared, {}, given, settings)
        fmu = fmu if found else fmu.with_parameters(values)
        self.foreign[socket], wrong, told = fitted(socket, SOCKETS[socket], fmu, self.mappings.get(socket))
        self.problems += [*found, *wrong]
        self.remarks += told
        self.values[socket] = values
        self.sources |= sources_of(socket, declared, values, given, settings)


def sources_of(
    where: str,
    declared: Sequence[Variable],
    values: Mapping[str, Any],
    given: Mapping[str, Given],
    settings: Sequence[Setting],
) -> dict[str, Mapping[str, Any]]:
    """Value, unit and source of each parameter of a unit, by full path."""
    units = {v.name: v.quantity.unit for v in declared}
    origin = {name: g.source for name, g in given.items()} | {s.name: "--set" for s in settings}
    return {f"{where}.{n}": {"value": v, "unit": units[n], "source": origin[n]} for n, v in values.items()}


def wiring_of(units: Mapping[str, UnitSource]) -> dict[str, str]:
    """How the three sockets are connected; a bus that an FMU does not read is left out."""
    foreign = {name for name, source in units.items() if isinstance(source, Mapped)}
    read = {f"{name}.{v.name.partition('.')[0]}" for name in foreign for v in units[name].interface.inputs}
    return {bus: source for bus, source in WIRING.items() if bus in read or bus.partition(".")[0] not in foreign}


def located(part: Part, request: str) -> Part:
    """The part with its files where they are: beside the scenario's file `request`, if they are there."""
    given = {key: text for key in ("fmu", "mapping") if (text := getattr(part, key)) is not None}
    beside = {key: Path(request).parent / text for key, text in given.items() if request.endswith(".toml")}
    return part.model_copy(update={key: str(path) for key, path in beside.items() if path.is_file()})


def chosen_fmu(socket: str, part: Part, request: str, remarks: list[str], *, lenient: bool = False) -> Part:
    """The FMU (or mapping file) `request` in place of `part`, whose parameters go along where they fit."""
    chosen, _ = foreign_part(Part(fmu=request), socket)
    interface = Fmu(Path(chosen.fmu or ""), lenient=lenient).interface
    declared = {v.name for v in interface.parameters}
    kept, other = in_units_of(part.parameters, interface)
    dropped = sorted(part.parameters.keys() - declared - chosen.parameters.keys())
    if dropped:
        remarks.append(f"{socket}: `{request}` has no parameters {', '.join(dropped)}; the scenario's are not used")
    if given := sorted(kept.keys() - chosen.parameters.keys()):
        remarks.append(f"{socket}: `{request}` is given the scenario's {', '.join(given)}")
    remarks += [
        f"{socket}: the scenario's {name} does not fit `{request}` ({other[name]}) and is not used"
        for name in sorted(other.keys() - chosen.parameters.keys())
    ]
    return chosen.model_copy(update={"parameters": {**kept, **chosen.parameters}, "step": part.step})


def foreign_part(part: Part, socket: str) -> tuple[Part, MappingFile | None]:
    """A part that is an FMU, with its mapping file read. Raises `RequestError`.

    `part.fmu` may name the mapping file itself, which then names the FMU; parameters that the scenario gives win over
    those of the mapping file.
    """
    request = part.mapping
    if part.fmu is not None and part.fmu.endswith(".toml"):
        request, part = part.fmu, part.model_copy(update={"fmu": None})
    if request is None:
        return part, None
    mapping = read_mapping(Path(request), socket)
    path = mapping.fmu if part.fmu is None else Path(part.fmu)
    if path is None:
        raise refuse(f"{request}: fmu", "nothing", "the path of the FMU, relative to this file")
    own = {n: Given(value=a.value, unit=a.unit, source=Path(request).name) for n, a in mapping.parameters.items()}
    update = {"fmu": str(path), "mapping": request, "parameters": {**own, **part.parameters}}
    return part.model_copy(update=update), mapping


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
