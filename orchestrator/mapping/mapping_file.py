"""Mapping files: how the variables of an FMU stand for the signals of a socket, written down in TOML.

Each bus of the socket is a table with one entry per signal:

* ``x = "pos_x"``: the variable that stands for it; for an array a list of variables, or ``"obj[*].x"``;
* ``v_x = { variable = "speed", unit = "km/h", factor = 1, offset = { value = 0, unit = "m/s" } }``, which means
  ``v_x = factor * speed + offset``, in either direction; inputs may have limits `min` and `max`;
* ``delta_f = { variable = "wheel", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }``: see `roles`;
* ``v_y = { constant = { value = 0, unit = "m/s" } }`` for what the FMU does not show, ``{ unused = true }`` for what it
  does not read; ``"?"`` is still to be filled in.

`axes`, `feedthrough`, `constants` (other inputs of the FMU), `parameters` and, in a bus, `reference` and `velocity`
complete the mapping.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, cast

from components.interfaces.socket import Position

POINTS: Final = ("centre_of_gravity", "rear_axle", "front_axle", "ahead")
ENDS: Final = ("centre", "rear_bumper", "front_bumper")
REFERENCES: Final[Mapping[Position, tuple[str, ...]]] = {Position.VEHICLE: POINTS, Position.BOX: ENDS}
"""What the positions on a bus may refer to; the first of each is ours."""
SPEED_AND_SLIP: Final = "speed_and_slip"
VELOCITIES: Final = ("body", "road", SPEED_AND_SLIP)
"""How the velocity of a vehicle may be given; the first is ours."""
POLAR_NAMES: Final[Mapping[str, str]] = {"v_x": "v", "v_y": "beta"}
"""What a file with speed and slip angle calls what it gives in place of the components of the velocity."""
AXES: Final = ("iso8855", "y_right")
"""Systems of axes; the first is ours."""
TO_FILL: Final = "?"
"""What stands in a template in place of a variable."""


@dataclass(frozen=True)
class Amount:
    """A value with its unit of measurement."""

    value: Any
    unit: str = "1"


@dataclass(frozen=True)
class Entry:
    """What stands for one signal, or for some elements of an array; the module's text says how it is written."""

    variables: tuple[str, ...] = ()
    unit: str | None = None
    """Unit of measurement in place of the one that the FMU declares."""
    role: str | None = None
    """What the variable is in place of the signal: a name in `roles.ROLES`."""
    angle: str | None = None
    """For a rate: the output that shows the signal itself."""
    constant: Amount | None = None
    unused: bool = False
    numbers: Mapping[str, Amount] = field(default_factory=dict[str, Amount])
    """Factor, offset, limits, and the numbers of the role."""

    @property
    def missing(self) -> bool:
        """Whether it is still to be filled in."""
        return TO_FILL in self.variables


@dataclass(frozen=True)
class MappingFile:
    """A mapping as it stands in its file."""

    where: str
    """The file's name, for messages."""
    fmu: Path | None = None
    """The FMU, or the Modelica model (`FILE.mo` or `FILE.mo:MODEL`) that becomes one."""
    socket: str | None = None
    axes: str = "iso8855"
    feedthrough: bool = True
    """Whether the outputs may depend on the inputs at the same instant, where the FMU declares so."""
    signals: Mapping[str, tuple[Entry, ...]] = field(default_factory=dict[str, tuple[Entry, ...]])
    """The entries by signal; an input of ours may go to several of theirs."""
    references: Mapping[str, tuple[str, Amount | None]] = field(default_factory=dict[str, tuple[str, Amount | None]])
    """By bus: the point that positions refer to, and its distance from the centre of gravity where that is needed."""
    velocities: Mapping[str, str] = field(default_factory=dict[str, str])
    """By bus: how the velocity is given."""
    constants: Mapping[str, Amount] = field(default_factory=dict[str, Amount])
    """Values of inputs of the FMU that no signal drives."""
    parameters: Mapping[str, Amount] = field(default_factory=dict[str, Amount])


def written(mapping: MappingFile, fmu: str | None = None) -> str:
    """A mapping as TOML that reads back as the same mapping.

    Args:
        mapping: The mapping.
        fmu: The FMU's path, relative to where the text will stand; without it the text names no FMU.
    """
    lines = [f"fmu = {toml_value(fmu)}"] if fmu else []
    lines += [f"socket = {toml_value(mapping.socket or '')}"]
    lines += [f"axes = {toml_value(mapping.axes)}"] if mapping.axes != AXES[0] else []
    lines += [] if mapping.feedthrough else ["feedthrough = false"]
    buses = dict.fromkeys([*(s.partition(".")[0] for s in mapping.signals), *mapping.references, *mapping.velocities])
    for bus in buses:
        lines += ["", f"[{bus}]", *_bus_lines(bus, mapping)]
    for key, amounts in (("constants", mapping.constants), ("parameters", mapping.parameters)):
        lines += ["", f"[{key}]"] if amounts else []
        lines += [f"{toml_value(name)} = {toml_value(_amount_table(amount))}" for name, amount in amounts.items()]
    return "\n".join(lines) + "\n"


def _bus_lines(bus: str, mapping: MappingFile) -> Iterator[str]:
    if bus in mapping.references:
        point, distance = mapping.references[bus]
        far = {"distance": _amount_table(distance)} if distance else {}
        yield f"reference = {toml_value({'point': point, **far})}"
    velocity = mapping.velocities.get(bus, VELOCITIES[0])
    if velocity != VELOCITIES[0]:
        yield f"velocity = {toml_value(velocity)}"
    names = POLAR_NAMES if velocity == SPEED_AND_SLIP else {}
    for signal, entries in mapping.signals.items():
        of, _, leaf = signal.partition(".")
        if of == bus:
            yield f"{names.get(leaf, leaf)} = {entries_text(entries)}"


def entries_text(entries: Sequence[Entry]) -> str:
    """The entries of one signal as a TOML value."""
    values = [_entry_value(entry) for entry in entries]
    return toml_value(values[0] if len(values) == 1 else values)


def _entry_value(entry: Entry) -> Any:
    if entry.unused:
        return {"unused": True}
    if entry.constant is not None:
        return {"constant": _amount_table(entry.constant)}
    variable = entry.variables[0] if len(entry.variables) == 1 else entry.variables
    texts = {"unit": entry.unit, "as": entry.role, "angle": entry.angle}
    more = {key: text for key, text in texts.items() if text is not None}
    more |= {key: _amount_table(amount) for key, amount in entry.numbers.items()}
    return {"variable": variable, **more} if more else variable


def _amount_table(amount: Amount) -> dict[str, Any]:
    return {"value": amount.value, "unit": amount.unit}


def toml_value(value: Any) -> str:
    """A value as TOML spells it, lists and dictionaries in one line; the keys of a dictionary must be bare keys."""
    from tomlkit import item  # noqa: PLC0415 - takes 50 ms to import, and most runs write no mapping

    if isinstance(value, Mapping):
        table = cast(Mapping[str, Any], value)
        # tomlkit itself leaves no space inside the braces
        return f"{{ {', '.join(f'{key} = {toml_value(part)}' for key, part in table.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, cast(Sequence[Any], value)))}]"
    return item(value).as_string()  # type: ignore[unknown] - tomlkit leaves it open
