"""The fillings of a scenario's sockets: blocks with their values, or FMUs with their mappings and values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from components.interfaces.block import Block
from components.interfaces.problem import Problem, refuse
from components.interfaces.sockets import SOCKETS, standard_wiring
from fmus.modelica.build_modelica import file_of, is_modelica
from fmus.reading.archive import interface_type_named
from fmus.unit_interface import Interface
from orchestrator.mapping.mapped import fitted, holding
from orchestrator.mapping.mapping_file import MappingFile
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.scenario.interface_choice import NO_CHOICE, InterfaceChoice
from orchestrator.scenario.parameters import block_parameters
from orchestrator.scenario.requested_fmus import RequestedFmus
from orchestrator.scenario.resolution import Resolution, Setting, resolve, resolve_unit, with_lengths
from orchestrator.scenario.scenario_file import SocketFilling
from orchestrator.system.contents import is_file
from orchestrator.system.files import Given
from orchestrator.system.named_variables import own_values
from orchestrator.system.source import UnitSource
from orchestrator.system.value_texts import in_unit_of


@dataclass(frozen=True)
class Filled:
    """The filling of a socket with its values: a block that is not a source yet, or the source of an FMU."""

    resolution: Resolution
    block: type[Block[Any, Any, Any]] | None = None
    fmu: UnitSource | None = None
    problems: Sequence[Problem] = ()
    remarks: Sequence[str] = ()


def filled_by_block(
    socket: str, filling: SocketFilling, block: type[Block[Any, Any, Any]], settings: Sequence[Setting]
) -> Filled:
    """Fill a socket with a block of the catalogue.

    Args:
        socket: The name of the socket.
        filling: The filling of the scenario, whose values replace those of the block's parameter set.
        block: The block.
        settings: The values that a person sets, which replace all others.
    """
    resolved = resolve(socket, block.parameters(), block_parameters(block.name), filling.parameters, settings)
    problems = [*resolved.problems]
    if filling.interface is not None:
        problems.append(Problem(f"{socket}.interface", f"`{filling.interface}` for a block", "it for an FMU only"))
    return Filled(resolved, block, problems=problems, remarks=resolved.remarks)


def filled_by_fmu(  # noqa: PLR0913 - what a scenario and a person say of it
    socket: str,
    filling: SocketFilling,
    mapping: MappingFile | None,
    settings: Sequence[Setting],
    fmus: RequestedFmus,
    choice: InterfaceChoice = NO_CHOICE,
) -> Filled:
    """Fill a socket with an FMU, whose parameters are converted to its own units of measurement.

    Args:
        socket: The name of the socket.
        filling: The filling of the scenario, which names the FMU.
        mapping: The mapping of the FMU; without one, the names of its variables decide.
        settings: The values that a person sets, which replace those of the filling.
        fmus: Gives the FMU.
        choice: The interface types that a person chooses.

    Raises:
        RequestError: The FMU cannot be read; other problems are those of the result.
    """
    request = filling.fmu or ""
    of_file = filling.interface and interface_type_named(filling.interface, f"{socket}.interface")
    fmu = replace(fmus.fmu(request), interface_type=choice.of(socket, of_file or None))
    fmu = with_lengths(socket, fmu, filling.parameters, settings)
    remarks = [f"{socket}: {Path(request).name}: {remark}" for remark in fmu.archive.remarks]
    # Values that cannot be converted stay as they are, so that the resolution reports them.
    given = filling.parameters | in_units_of(filling.parameters, fmu.interface)[0]
    resolved = resolve_unit(socket, fmu, given, settings)
    fmu = fmu if resolved.problems else fmu.with_parameters(resolved.of_role("parameters", "initials"))
    if held := resolved.of_role("inputs"):
        mapping = holding(mapping or MappingFile(f"--set {socket}"), held, fmu.interface)
    source, misfits, decisions = fitted(socket, SOCKETS[socket], fmu, mapping)
    remarks += [*decisions, *own_values(socket, source)]
    return Filled(resolved, fmu=source, problems=[*resolved.problems, *misfits], remarks=remarks)


def wiring_of(units: Mapping[str, UnitSource]) -> dict[str, str]:
    """The standard wiring of the sockets that units fill, without the buses that a unit does not read."""
    read = {f"{name}.{v.name.partition('.')[0]}" for name, source in units.items() for v in source.interface.inputs}
    return {bus: source for bus, source in standard_wiring(units).items() if bus in read}


def is_foreign(request: str) -> bool:
    """Whether a request names a file in place of a block: an FMU, the mapping file of one, or a Modelica file."""
    return request.endswith((".fmu", ".toml")) or is_modelica(request)


def located(filling: SocketFilling, request: str) -> SocketFilling:
    """A filling whose files are found relative to the folder of the scenario file.

    Args:
        filling: The filling as the scenario has it.
        request: The path of the scenario file, or the name of a scenario that comes with macrostep.

    Returns:
        The filling, in which each file that exists relative to that folder has its path there.
    """
    given = {key: text for key in ("fmu", "mapping") if (text := getattr(filling, key)) is not None}
    beside = {key: Path(request).parent / text for key, text in given.items() if request.endswith(".toml")}
    return filling.model_copy(update={key: str(path) for key, path in beside.items() if is_file(file_of(str(path)))})


def chosen_fmu(
    socket: str, filling: SocketFilling, request: str, fmus: RequestedFmus, remarks: list[str]
) -> SocketFilling:
    """Replace a filling by an FMU, which takes over the parameters that it has too.

    Args:
        socket: The name of the socket.
        filling: The filling of the scenario.
        request: The FMU or the Modelica file, or the mapping file that names it.
        fmus: Gives the FMU.
        remarks: Receives a remark on the parameters that are taken over, and on those that are not.

    Raises:
        RequestError: The FMU or the mapping file cannot be read.
    """
    chosen, _ = with_mapping(SocketFilling(fmu=request), socket)
    interface = fmus.fmu(chosen.fmu or "").interface
    declared = {v.name for v in interface.parameters}
    # a start value of theirs that happens to have the name of a parameter of ours is none
    kept, other = in_units_of({n: g for n, g in filling.parameters.items() if n in declared}, interface)
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
    """Read the mapping file of a filling.

    `filling.fmu` may name the mapping file itself, which then names the FMU. Parameters of the scenario replace those
    of the mapping file.

    Args:
        filling: The filling.
        socket: The name of the socket.

    Returns:
        The filling with the path of the FMU and the parameters of both, and the mapping; the filling as it is and
        `None` where it has no mapping file.

    Raises:
        RequestError: The mapping file cannot be read, or no FMU is named.
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
    """Convert values to the units of measurement that an FMU declares for what can be set in it.

    A parameter without a unit of measurement takes the number as it is. A shorter array leaves the other elements of
    the FMU's array as they are.

    Args:
        given: The values by name; those that the FMU does not declare are left out.
        theirs: The interface of the FMU.

    Returns:
        The converted values, and for each value that does not fit the reason, both by name.
    """
    declared = {v.name: v.quantity for role in ("parameters", "initials", "inputs") for v in getattr(theirs, role)}
    converted: dict[str, Given] = {}
    misfits: dict[str, str] = {}
    for name in (name for name in given if name in declared):
        q = declared[name]
        value = in_unit_of(given[name], q)
        value = value and _lengthened(value, theirs.starts.get(name))
        if value is None or q.problems(name, value.value):
            misfits[name] = f"{given[name].value} [{given[name].unit}] against {q.range}"
        else:
            converted[name] = value
    return converted, misfits


def _lengthened(value: Given, start: Any) -> Given:
    items: Any = value.value
    if isinstance(items, list) and isinstance(start, np.ndarray) and start.ndim == 1:
        whole = [*items, *start.tolist()[len(items) :]]  # type: ignore[unknown]
        return value.model_copy(update={"value": whole})
    return value
