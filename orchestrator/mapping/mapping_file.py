"""Mapping files: how a foreign FMU stands for a socket, as a person writes it down in TOML.

Each bus of the socket is a table with one entry per signal:

* ``x = "pos_x"``: the foreign variable that stands for it; for an array a list of variables, or ``"obj[*].x"``;
* ``v_x = { variable = "speed", unit = "km/h", factor = 1, offset = { value = 0, unit = "m/s" } }``, which means
  ``v_x = factor * speed + offset``, in either direction; inputs may have limits `min` and `max`;
* ``delta_f = { variable = "wheel", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }``: see `ROLES`;
* ``v_y = { constant = { value = 0, unit = "m/s" } }`` for what the FMU does not show, ``{ unused = true }`` for what it
  does not read; ``"?"`` is still to be filled in.

`axes`, `feedthrough`, `constants` (other inputs of the FMU), `parameters` and, in a bus, `reference` and `velocity`
say the rest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from components.interfaces.socket import Position

ROLES: Final[Mapping[str, tuple[str, ...]]] = {
    "steering_wheel_angle": ("ratio",),
    "steering_rate": ("limit",),
    "axle_torque": (),
    "wheel_force": ("R_w",),
    "force": ("R_w",),
    "acceleration": ("R_w", "m"),
}
"""What the FMU may have in place of `delta_f` or `T_r`, and the numbers that say how much that is"""
STEERING: Final = frozenset({"steering_wheel_angle", "steering_rate"})
POINTS: Final = ("centre_of_gravity", "rear_axle", "front_axle", "ahead")
ENDS: Final = ("centre", "rear_bumper", "front_bumper")
REFERENCES: Final[Mapping[Position, tuple[str, ...]]] = {Position.VEHICLE: POINTS, Position.BOX: ENDS}
"""What the positions on a bus may refer to; the first of each is ours"""
VELOCITIES: Final = ("body", "road", "speed_and_slip")
AXES: Final = ("iso8855", "y_right")
TO_FILL: Final = "?"


@dataclass(frozen=True)
class Amount:
    """A number with its unit."""

    value: Any
    unit: str = "1"


@dataclass(frozen=True)
class Entry:
    """What stands for one signal; see the module."""

    variables: tuple[str, ...] = ()
    unit: str | None = None
    role: str | None = None
    angle: str | None = None
    constant: Amount | None = None
    unused: bool = False
    numbers: Mapping[str, Amount] = field(default_factory=dict[str, Amount])

    @property
    def missing(self) -> bool:
        """Whether it is still to be filled in."""
        return TO_FILL in self.variables


@dataclass(frozen=True)
class MappingFile:
    """A mapping as it stands in its file."""

    where: str
    """The file's name, for messages"""
    fmu: Path | None = None
    socket: str | None = None
    axes: str = "iso8855"
    feedthrough: bool = True
    """Whether the FMU's outputs may depend on its inputs at the same instant, as it declares"""
    signals: Mapping[str, tuple[Entry, ...]] = field(default_factory=dict[str, tuple[Entry, ...]])
    """By signal; an input of ours may go to several of theirs"""
    references: Mapping[str, tuple[str, Amount | None]] = field(default_factory=dict[str, tuple[str, Amount | None]])
    """By bus: point and distance"""
    velocities: Mapping[str, str] = field(default_factory=dict[str, str])
    constants: Mapping[str, Amount] = field(default_factory=dict[str, Amount])
    parameters: Mapping[str, Amount] = field(default_factory=dict[str, Amount])


def written(mapping: MappingFile, fmu: str | None = None) -> str:
    """The mapping as TOML that reads back as the same mapping; `fmu` names the file."""
    lines = [f"fmu = {quoted(fmu)}"] if fmu else []
    lines += [f"socket = {quoted(mapping.socket or '')}"]
    lines += [f"axes = {quoted(mapping.axes)}"] if mapping.axes != AXES[0] else []
    lines += [] if mapping.feedthrough else ["feedthrough = false"]
    buses = dict.fromkeys([*(s.partition(".")[0] for s in mapping.signals), *mapping.references, *mapping.velocities])
    for bus in buses:
        lines += ["", f"[{bus}]"]
        if bus in mapping.references:
            point, distance = mapping.references[bus]
            far = f", distance = {amount_text(distance)}" if distance else ""
            lines.append(f"reference = {{ point = {quoted(point)}{far} }}")
        velocity = mapping.velocities.get(bus, VELOCITIES[0])
        lines += [f"velocity = {quoted(velocity)}"] if velocity != VELOCITIES[0] else []
        names = {"v_x": "v", "v_y": "beta"} if velocity == VELOCITIES[2] else {}
        for signal, entries in mapping.signals.items():
            if signal.partition(".")[0] == bus:
                leaf = signal.partition(".")[2]
                lines.append(f"{names.get(leaf, leaf)} = {entries_text(entries)}")
    for key, amounts in (("constants", mapping.constants), ("parameters", mapping.parameters)):
        lines += ["", f"[{key}]"] if amounts else []
        lines += [f"{quoted(name)} = {amount_text(amount)}" for name, amount in amounts.items()]
    return "\n".join(lines) + "\n"


def entries_text(entries: tuple[Entry, ...]) -> str:
    """The entries of one signal as a TOML value."""
    texts = [_entry_text(entry) for entry in entries]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _entry_text(entry: Entry) -> str:
    if entry.unused:
        return "{ unused = true }"
    if entry.constant is not None:
        return f"{{ constant = {amount_text(entry.constant)} }}"
    names = [quoted(name) for name in entry.variables]
    variable = names[0] if len(names) == 1 else f"[{', '.join(names)}]"
    parts = {"unit": entry.unit, "as": entry.role, "angle": entry.angle}
    told = [f"{key} = {quoted(text)}" for key, text in parts.items() if text is not None]
    told += [f"{key} = {amount_text(amount)}" for key, amount in entry.numbers.items()]
    return f"{{ variable = {variable}, {', '.join(told)} }}" if told else variable


def amount_text(amount: Amount) -> str:
    """A number with its unit as a TOML value."""
    return f"{{ value = {quoted(amount.value)}, unit = {quoted(amount.unit)} }}"


def quoted(value: Any) -> str:
    """A text, number, truth value or list as TOML."""
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
