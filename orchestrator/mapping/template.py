"""Mapping templates: what is known of an FMU in a socket as a mapping file, with the rest marked to be filled in."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from components.interfaces.problem import refuse
from components.interfaces.record import Variable
from components.interfaces.socket import Position, Socket
from fmus.unit_interface import Interface
from orchestrator.mapping.fitting_result import FittedSignal, Fitting
from orchestrator.mapping.mapping_file import TO_FILL, entries_text, toml_value
from orchestrator.mapping.relations import conversion
from orchestrator.mapping.roles import roles_of

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
"""Candidates that are named"""


def template(fitting: Fitting, socket: Socket, theirs: Interface, fmu: str, mapping: str) -> str:
    """The mapping file called `mapping` for the FMU at `fmu` (relative to it)."""
    lines = [
        f"# How {Path(fmu).name} fills the socket `{socket.name}`.",
        f"# Use it in place of the FMU: macrostep run static --{socket.name} {mapping}",
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
    driven = {name for entries in fitting.mapping.signals.values() for e in entries for name in e.variables}
    free = [v for v in theirs.inputs if v.name not in driven]
    if free:
        lines += [
            "",
            "[constants]",
            "# Inputs of the FMU that no signal drives; they keep their start value if not given.",
        ]
        lines += [
            f"# {toml_value(v.name)} = {{ value = {_start(v, theirs)}, unit = {toml_value(v.quantity.unit)} }}"
            for v in free
        ]
    return "\n".join(lines) + "\n"


def write_template(text: str, path: Path) -> None:
    """Write a template to a new file. Raises `RequestError` rather than to overwrite one."""
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
    mark = "" if known or needed else "# "
    what = "what it shows" if shown else "what it reads"
    yield f"{mark}[{bus}]  # {what}{'' if needed else ', optional'}"
    if position is Position.VEHICLE and shown:
        yield _VEHICLE_HINT
    elif position is Position.BOX:
        yield _BOX_HINT
    for row in rows:
        open_and_optional = not (row.needed or row.signal.name in fitting.mapping.signals)
        yield ("# " if mark or open_and_optional else "") + _line(row, fitting, theirs)


def _line(row: FittedSignal, fitting: Fitting, theirs: Interface) -> str:
    leaf = row.signal.name.partition(".")[2]
    q = row.signal.quantity
    told = f"{f'[{q.unit}] ' if q.type.is_float else ''}{q.description}"
    entries = fitting.mapping.signals.get(row.signal.name)
    if entries:
        return f"{leaf} = {entries_text(entries)}  # {told}{f' ({row.note})' if row.note else ''}"
    near = candidates(row.signal, theirs.outputs if row.direction == "outputs" else theirs.inputs, fitting)
    parts = [told, f"candidates: {', '.join(near)}" if near else "", *(_hints(leaf) if row.needed else ())]
    return f'{leaf} = "{TO_FILL}"  # {"; ".join(part for part in parts if part)}'


def _hints(leaf: str) -> Iterator[str]:
    """What else may be written for a signal."""
    if roles := roles_of(leaf):
        yield f"or {', '.join(role.hint for role in roles.values())}"
    yield _HINTS_OF_SIGNALS.get(leaf, "")


def candidates(signal: Variable, offered: Sequence[Variable], fitting: Fitting) -> list[str]:
    """Variables that nothing else stands for and that measure the same, the likeliest first."""
    taken = {name for entries in fitting.mapping.signals.values() for e in entries for name in e.variables}
    leaf = signal.name.rpartition(".")[2]
    words = [leaf, *_SYNONYMS.get(leaf, "").split()]

    def likeness(v: Variable) -> float:
        last = v.name.rpartition(".")[2].lower()
        return max(difflib.SequenceMatcher(None, word.lower(), last).ratio() for word in words)

    free = sorted((v for v in offered if v.name not in taken), key=likeness, reverse=True)
    told = [text for v in free if (text := _candidate(signal, leaf, v)) is not None]
    return told[:_MOST]


def _candidate(signal: Variable, leaf: str, theirs: Variable) -> str | None:
    """A variable that could stand for a signal, and as what; None if it measures something else."""
    q, found = signal.quantity, theirs.quantity
    if not found.type.is_number:
        return None
    if not (q.type.is_float and found.type.is_float):
        return theirs.name
    unit = f"{theirs.name} [{found.unit or 'no unit'}]"
    if conversion(found, q) is not None:
        return unit
    roles = [n for n, role in roles_of(leaf).items() if conversion(found, replace(q, unit=role.unit)) is not None]
    return f"{unit} as {' or '.join(map(toml_value, roles))}" if roles else None


def _start(variable: Variable, theirs: Interface) -> str:
    start = theirs.starts.get(variable.name, 0.0)
    return toml_value(start.tolist() if hasattr(start, "tolist") else start)
