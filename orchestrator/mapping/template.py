"""Mapping templates: what is known of an FMU in a socket as a mapping file, with the rest marked to be filled in."""

from __future__ import annotations

import difflib
import os
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import refuse
from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from components.interfaces.socket import Position, Socket
from fmus.unit_interface import Interface
from orchestrator.mapping.fitting_result import FittedSignal, Fitting
from orchestrator.mapping.mapping_file import TO_FILL, entries_text, toml_value
from orchestrator.mapping.relations import conversion
from orchestrator.mapping.roles import roles_of
from orchestrator.system.value_texts import plain

_SYNONYMS: Final = {
    "x": "pos_x position_x east forward",
    "y": "pos_y position_y north lateral left",
    "psi": "yaw heading theta phi yaw_angle",
    "v_x": "speed velocity vel_x v longitudinal_speed",
    "v_y": "lateral_speed vel_y drift",
    "r": "yaw_rate omega psi_dot yawrate omega_z",
    "delta_f": "steer steering delta steering_angle wheel_angle",
    "T_r": "torque drive_torque throttle accel force",
    "valid": "exists active present",
    "v": "speed velocity",
}
_VEHICLE_HINT: Final = (
    '# reference = { point = "rear_axle", distance = { value = 1.4, unit = "m" } }  # else centre_of_gravity\n'
    '# velocity = "speed_and_slip"  # v and beta in place of v_x and v_y; or "road": along the road'
)
_BOX_HINT: Final = '# reference = "rear_bumper"  # ours: centre; for arrays of structures: x = "object[*].x"'
_HINTS_OF_SIGNALS: Final = {
    "T_r": "several: [{ ... }, { ... }]; not read: { unused = true }",
    "v_y": 'not shown: { constant = { value = 0, unit = "m/s" } }',
    "valid": "not shown: { constant = true }",
    "length": 'not shown: { constant = { value = 4.5, unit = "m" } }',
    "width": 'not shown: { constant = { value = 1.8, unit = "m" } }',
}
_MOST: Final = 5
"""The number of candidates that are named."""


def template(fitting: Fitting, socket: Socket, theirs: Interface, fmu: str, mapping: str) -> str:
    """A mapping file with what is known of an FMU, to be completed by a person.

    Args:
        fitting: How the FMU fits the socket without a mapping file.
        socket: The socket that the FMU is to fill.
        theirs: The interface of the FMU.
        fmu: The FMU's path, relative to the mapping file.
        mapping: The path that the mapping file will have.

    Returns:
        The text of the file.
    """
    lines = [
        f"# How {Path(fmu).name} fills the socket `{socket.name}`.",
        f"# Use it in place of the FMU: macrostep run static --{socket.name} {shlex.quote(str(mapping))}",
        "#",
        '# SIGNAL = "VARIABLE", or SIGNAL = { variable = "VARIABLE", unit = "km/h", factor = 1, offset = ... }:',
        "#   signal = factor * variable + offset. Units are converted; `unit` is for FMUs that are wrong or silent.",
        f'# "{TO_FILL}" is to be filled in.',
        f"fmu = {toml_value(fmu)}",
        f'socket = "{socket.name}"',
        '# axes = "y_right"  # y to the right, z down; ours: iso8855, y to the left',
        "# feedthrough = false  # its outputs show by stepping, though it declares that they depend on its inputs",
    ]
    for bus in socket.buses:
        rows = [r for r in fitting.rows if r.signal.name.startswith(f"{bus}.")]
        lines += ["", *_bus(bus, socket.bus(bus).position, rows, fitting, theirs)]
    free = [v for v in theirs.inputs if v.name not in _taken(fitting)]
    if free:
        what = "# Inputs of the FMU that no signal drives; they keep their start value if not given."
        starts = [{"value": _start(v, theirs), "unit": v.quantity.unit} for v in free]
        lines += ["", "[constants]", what]
        lines += [f"# {toml_value(v.name)} = {toml_value(start)}" for v, start in zip(free, starts, strict=True)]
    return "\n".join(lines) + "\n"


def write_template(text: str, path: Path) -> None:
    """Write a template to a new file.

    Args:
        text: The text of the template.
        path: The file, which must not exist.

    Raises:
        RequestError: The file exists already, or cannot be written.
    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise refuse(str(path), "a file", "a new file", "Choose another name, or remove it.") from error
    except OSError as error:
        raise refuse(str(path), f"a place that cannot be written to ({error.strerror})", "a new file") from error


def relative(fmu: Path, folder: Path) -> str:
    """The FMU's path as the mapping file in `folder` names it."""
    return Path(os.path.relpath(fmu.resolve(), folder.resolve())).as_posix()


def _bus(
    bus: str, position: Position | None, rows: Sequence[FittedSignal], fitting: Fitting, theirs: Interface
) -> Iterator[str]:
    shown = rows[0].direction == "outputs"
    known = any(row.signal.name in fitting.mapping.signals for row in rows)
    needed = any(row.needed for row in rows)
    what = "what it shows" if shown else "what it reads"
    yield f"{'' if known or needed else '# '}[{bus}]  # {what}{'' if needed else ', optional'}"
    if position is Position.VEHICLE and shown:
        yield _VEHICLE_HINT
    elif position is Position.BOX:
        yield _BOX_HINT
    for row in rows:
        yield _line(row, fitting, theirs)


def _line(row: FittedSignal, fitting: Fitting, theirs: Interface) -> str:
    leaf = row.signal.name.partition(".")[2]
    q = row.signal.quantity
    about = f"{f'[{q.unit}] ' if q.type.is_float else ''}{q.description}"
    entries = fitting.mapping.signals.get(row.signal.name)
    if entries:
        return f"{leaf} = {entries_text(entries)}  # {about}{f' ({row.note})' if row.note else ''}"
    near = candidates(row.signal, theirs.outputs if row.direction == "outputs" else theirs.inputs, fitting)
    parts = [about, f"candidates: {', '.join(near)}" if near else "", *(_hints(leaf) if row.needed else ())]
    return f'{"" if row.needed else "# "}{leaf} = "{TO_FILL}"  # {"; ".join(part for part in parts if part)}'


def _hints(leaf: str) -> Iterator[str]:
    """What else may be written for a signal."""
    if roles := roles_of(leaf):
        yield f"or {', '.join(role.hint for role in roles.values())}"
    yield _HINTS_OF_SIGNALS.get(leaf, "")


def candidates(signal: Variable, offered: Sequence[Variable], fitting: Fitting) -> list[str]:
    """The variables that could stand for a signal, as a template names them.

    Args:
        signal: The signal of the socket.
        offered: The inputs or outputs of the FMU.
        fitting: What is decided already; variables that stand for other signals are no candidates.

    Returns:
        The few likeliest with their units of measurement, the likeliest first.
    """
    leaf = signal.name.rpartition(".")[2]
    words = [leaf, *_SYNONYMS.get(leaf, "").split()]

    def likeness(v: Variable) -> float:
        last = v.name.rpartition(".")[2].lower()
        return max(difflib.SequenceMatcher(None, word.lower(), last).ratio() for word in words)

    taken = _taken(fitting)
    free = sorted((v for v in offered if v.name not in taken), key=likeness, reverse=True)
    return [text for v in free if (text := _candidate(signal, leaf, v)) is not None][:_MOST]


def _taken(fitting: Fitting) -> set[str]:
    """The variables that stand for signals."""
    return {name for entries in fitting.mapping.signals.values() for entry in entries for name in entry.variables}


def _candidate(signal: Variable, leaf: str, theirs: Variable) -> str | None:
    """A variable that could stand for a signal, and as what; `None` if it measures something else."""
    ours, offered = signal.quantity, theirs.quantity
    if not _type_fits(offered.type, ours.type):
        return None
    if not (ours.type.is_float and offered.type.is_float):
        return theirs.name
    text = f"{theirs.name} [{offered.unit or 'no unit'}]"
    if conversion(offered, ours) is not None:
        return text
    roles = [n for n, role in roles_of(leaf).items() if conversion(offered, replace(ours, unit=role.unit)) is not None]
    return f"{text} as {' or '.join(map(toml_value, roles))}" if roles else None


def _type_fits(offered: Type, ours: Type) -> bool:
    """Whether a variable of a type is likely to mean a signal of a type: a flag is no number, nor a number a flag."""
    if offered.is_integer or offered is ours:
        return True
    return offered.is_float and (ours.is_float or ours.is_integer)


def _start(variable: Variable, theirs: Interface) -> Any:
    return plain(theirs.starts.get(variable.name, 0.0))
