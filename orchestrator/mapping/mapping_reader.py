"""Reading mapping files (see `mapping_file`); all problems of a file are reported at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

from components.interfaces.arguments import checked_arguments
from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, raise_if_any
from components.interfaces.socket import Position, Socket
from components.interfaces.sockets import SOCKETS
from orchestrator.mapping.mapping_file import (
    AXES,
    POINTS,
    POLAR_NAMES,
    REFERENCES,
    SPEED_AND_SLIP,
    VELOCITIES,
    Amount,
    Entry,
    MappingFile,
)
from orchestrator.mapping.roles import ROLE_NUMBERS, roles_of
from orchestrator.system.files import read_toml

_Table: TypeAlias = Mapping[str, Any]
_NUMBERS: Final = ("factor", "offset", "min", "max", *ROLE_NUMBERS)
_PLAIN_NUMBERS: Final = ("factor", *(name for name, number in ROLE_NUMBERS.items() if number.unit == "1"))
"""Numbers that may stand without a unit of measurement."""
_ENTRY: Final = ("variable", "unit", "as", "angle", "constant", "unused", *_NUMBERS)
_REFERENCE: Final = ("point", "distance")
_ABOUT_BUS: Final = ("reference", "velocity")
"""The entries in the table of a bus that are not signals."""
_EXAMPLE: Final = 'Write { variable = "...", unit = "..." }.'


@checked_arguments
def read_mapping(path: Path | str, socket: str | None = None) -> MappingFile:
    """Read a mapping file.

    Args:
        path: The TOML file.
        socket: The socket that the FMU is to fill; without it, the file must name one.

    Raises:
        RequestError: The file has problems; the error has all of them.
    """
    path = Path(path)
    return parse_mapping(read_toml(path), str(path), socket, path.parent)


def parse_mapping(content: Mapping[str, Any], where: str, socket: str | None, folder: Path) -> MappingFile:
    """Understand the content of a mapping file.

    Args:
        content: The parsed file.
        where: The name of the file, for messages.
        socket: The socket that the FMU is to fill; without it, the file must name one.
        folder: The folder that the FMU's path is relative to.

    Raises:
        RequestError: The content has problems; the error has all of them.
    """
    reader = _Reader(where)
    mapping = reader.mapping(content, reader.socket(content, socket), folder)
    raise_if_any(reader.problems)
    return mapping


class _Reader:
    """Reads the parts of a mapping and gathers what is wrong with them."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.problems: list[Problem] = []

    def wrong(self, key: str, found: str, valid: str, remedy: str = "") -> None:
        self.problems.append(Problem(f"{self.where}: {key}", found, valid, remedy))

    def unknown(self, key: str, name: str, known: Sequence[str]) -> None:
        self.wrong(key, "an unknown entry", choices(known), did_you_mean(name, known))

    def socket(self, content: _Table, given: str | None) -> Socket:
        """The socket that the file names, else the given one; without any the rest cannot be read."""
        name = self.chosen(content, "socket", tuple(SOCKETS), given)
        if given and name and name != given:
            self.wrong("socket", f"`{name}`", f"`{given}`, the socket that it is given for")
        socket = SOCKETS.get(name or "")
        if socket is None:
            if "socket" not in content:
                self.wrong("socket", "nothing", choices(SOCKETS), "Say which socket the FMU fills.")
            raise RequestError(self.problems)
        return socket

    def mapping(self, content: _Table, socket: Socket, folder: Path) -> MappingFile:
        keys = ("fmu", "socket", "axes", "feedthrough", "constants", "parameters", *socket.buses)
        for key in (key for key in content if key not in keys):
            self.unknown(key, key, keys)
        tables = {bus: self.table(content, bus) for bus in socket.buses}
        positions = {bus: socket.bus(bus).position for bus in socket.buses}
        fmu = self.text(content, "fmu", "the path of an FMU, relative to this file")
        feedthrough = content.get("feedthrough", True)
        if not isinstance(feedthrough, bool):
            self.wrong("feedthrough", f"`{feedthrough}`", "true or false")
        return MappingFile(
            self.where,
            folder / fmu if fmu else None,
            socket.name,
            self.chosen(content, "axes", AXES, AXES[0]) or AXES[0],
            bool(feedthrough),
            {name: entries for bus, table in tables.items() for name, entries in self.signals(bus, table, socket)},
            {bus: found for bus, table in tables.items() if (found := self.reference(bus, positions[bus], table))},
            {bus: found for bus, table in tables.items() if (found := self.velocity(bus, positions[bus], table))},
            self.amounts(content, "constants"),
            self.amounts(content, "parameters"),
        )

    def table(self, content: _Table, key: str) -> _Table:
        table = content.get(key, {})
        if not isinstance(table, dict):
            self.wrong(key, f"`{table}`", "a table")
            return {}
        return cast(_Table, table)

    def text(self, content: _Table, key: str, valid: str, where: str = "") -> str | None:
        text = content.get(key)
        if isinstance(text, str | None):
            return text
        self.wrong(where + key, f"`{text}`", valid)
        return None

    def chosen(
        self, content: _Table, key: str, known: Sequence[str], default: str | None, where: str = ""
    ) -> str | None:
        name = content.get(key, default)
        if name is None or name in known:
            return name
        remedy = did_you_mean(name, known) if isinstance(name, str) else ""
        self.wrong(f"{where}.{key}" if where else key, f"`{name}`", choices(known), remedy)
        return default

    def amounts(self, content: _Table, key: str) -> dict[str, Amount]:
        amounts = {name: self.amount(f"{key}.{name}", value) for name, value in self.table(content, key).items()}
        return {name: amount for name, amount in amounts.items() if amount is not None}

    def amount(self, key: str, value: Any, *, plain: bool = True) -> Amount | None:
        """A value with its unit of measurement; where `plain`, it may stand without one."""
        if isinstance(value, dict):
            table = cast(_Table, value)
            if (
                table.keys() <= {"value", "unit", "source"}
                and "value" in table
                and isinstance(table.get("unit", ""), str)
            ):
                return Amount(table["value"], table.get("unit", "1"))
        elif plain:
            return Amount(value)
        self.wrong(key, f"`{value}`", "a number with its unit", 'Write { value = ..., unit = "..." }.')
        return None

    def reference(self, bus: str, position: Position | None, table: _Table) -> tuple[str, Amount | None] | None:
        """What the positions on a bus refer to: a point of the vehicle with its distance, or an end of the boxes."""
        given = table.get("reference")
        if given is None:
            return None
        key = f"{bus}.reference"
        known = () if position is None else REFERENCES[position]
        content: _Table = cast(_Table, given) if isinstance(given, dict) else {"point": given}
        for name in (name for name in content if name not in _REFERENCE):
            self.unknown(f"{key}.{name}", name, _REFERENCE)
        point = self.chosen(content, "point", known, None, key)
        if "point" not in content:
            self.wrong(f"{key}.point", "nothing", choices(known))
        if point not in POINTS[1:]:
            return (point, None) if point else None
        if "distance" not in content:
            self.wrong(f"{key}.distance", "nothing", "the distance from the centre of gravity, with its unit")
            return None
        return point, self.amount(f"{key}.distance", content["distance"], plain=False)

    def velocity(self, bus: str, position: Position | None, table: _Table) -> str | None:
        """How a bus gives the velocity of a vehicle; what has no position of a vehicle has no such velocity either."""
        known = VELOCITIES if position is Position.VEHICLE else VELOCITIES[:1]
        return self.chosen(table, "velocity", known, None, bus)

    def signals(self, bus: str, table: _Table, socket: Socket) -> Iterator[tuple[str, tuple[Entry, ...]]]:
        """The entries of each signal of a bus, by its full name."""
        names: Mapping[str, str] = POLAR_NAMES if table.get("velocity") == SPEED_AND_SLIP else {}
        signals = {v.name.partition(".")[2]: v for v in socket.signals() if v.name.startswith(f"{bus}.")}
        signals = {names.get(leaf, leaf): v for leaf, v in signals.items()}
        for leaf, value in table.items():
            if leaf in _ABOUT_BUS:
                continue
            if leaf not in signals:
                self.unknown(f"{bus}.{leaf}", leaf, (*signals, *_ABOUT_BUS))
                continue
            items = cast(list[Any], value) if isinstance(value, list) else [value]
            if signals[leaf].shape and all(isinstance(item, str) for item in items):
                yield signals[leaf].name, (Entry(variables=tuple(items)),)
            else:
                entries = [self.entry(f"{bus}.{leaf}", leaf, item) for item in items]
                yield signals[leaf].name, tuple(entry for entry in entries if entry is not None)

    def entry(self, key: str, leaf: str, value: Any) -> Entry | None:
        if isinstance(value, str):
            return Entry(variables=(value,))
        if not isinstance(value, dict):
            self.wrong(key, f"`{value}`", "the name of a variable, or a table", _EXAMPLE)
            return None
        table = cast(_Table, value)
        for part in (part for part in table if part not in _ENTRY):
            self.unknown(f"{key}.{part}", part, _ENTRY)
        if len(table.keys() & {"variable", "constant", "unused"}) != 1:
            self.wrong(key, f"`{value}`", "one of variable, constant, unused", _EXAMPLE)
            return None
        return Entry(
            self.variables(key, table),
            self.text(table, "unit", "the name of a unit", f"{key}."),
            self.role(key, leaf, table),
            self.text(table, "angle", "the name of a variable", f"{key}."),
            self.amount(f"{key}.constant", table["constant"]) if "constant" in table else None,
            "unused" in table,
            dict(self.numbers(key, table)),
        )

    def variables(self, key: str, table: _Table) -> tuple[str, ...]:
        names = table.get("variable", [])
        listed = cast(list[Any], names) if isinstance(names, list) else [names]
        if all(isinstance(name, str) for name in listed):
            return tuple(listed)
        self.wrong(f"{key}.variable", f"`{names}`", "the name of a variable, or a list of names")
        return ()

    def numbers(self, key: str, table: _Table) -> Iterator[tuple[str, Amount]]:
        for name in (name for name in _NUMBERS if name in table):
            amount = self.amount(f"{key}.{name}", table[name], plain=name in _PLAIN_NUMBERS)
            if amount is None:
                continue
            if isinstance(amount.value, bool) or not isinstance(amount.value, int | float):
                self.wrong(f"{key}.{name}", f"`{amount.value}`", "a number")
            else:
                yield name, amount

    def role(self, key: str, leaf: str, table: _Table) -> str | None:
        """The role of the variable; the table must have the numbers that the role requires, and no others."""
        known = roles_of(leaf)
        name = self.chosen(table, "as", tuple(known), None, key)
        role = known.get(name or "")
        numbers = role.numbers if role else ()
        parts = (*numbers, "angle") if role and role.is_rate else numbers
        for part in sorted(table.keys() & {*ROLE_NUMBERS, "angle"} - {*parts}):
            takers = choices(other for other, r in known.items() if part in r.numbers)
            valid = f"a part of {takers}" if known else "nothing of this name"
            self.wrong(f"{key}.{part}", f"`{table[part]}`, which `as` does not ask for", valid)
        for number in numbers:
            if number not in table and ROLE_NUMBERS[number].required:
                self.wrong(f"{key}.{number}", "nothing", f"a number with its unit, for `{name}`")
        return name
