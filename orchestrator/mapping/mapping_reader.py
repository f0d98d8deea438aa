"""Reading mapping files (see `mapping_file`), with everything that is wrong with one told at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from components.interfaces.socket import Position, Socket
from components.interfaces.sockets import SOCKETS
from orchestrator.mapping.mapping_file import (
    AXES,
    POINTS,
    REFERENCES,
    ROLES,
    STEERING,
    VELOCITIES,
    Amount,
    Entry,
    MappingFile,
)
from orchestrator.system.files import read_toml

Table: TypeAlias = Mapping[str, Any]
_NUMBERS: Final = ("factor", "offset", "min", "max", "ratio", "R_w", "m", "limit")
_ENTRY: Final = ("variable", "unit", "as", "angle", "constant", "unused", *_NUMBERS)
_EXAMPLE: Final = 'Write { variable = "...", unit = "..." }.'


def read_mapping(path: Path, socket: str | None = None) -> MappingFile:
    """The mapping in a TOML file, for `socket` or the one that it names. Raises `RequestError` with all problems."""
    return parse_mapping(read_toml(path), str(path), socket, path.parent)


def parse_mapping(content: Mapping[str, Any], where: str, socket: str | None, folder: Path) -> MappingFile:
    """The mapping in `content`; the FMU's path is relative to `folder`. Raises `RequestError` with all problems."""
    reader = _Reader(where)
    named = reader.chosen(content, "socket", tuple(SOCKETS), socket)
    if socket and named and named != socket:
        reader.wrong("socket", f"`{named}`", f"`{socket}`, the socket that it is given for")
    found = SOCKETS.get(named or "")
    if found is None:
        if "socket" not in content:
            reader.wrong("socket", "nothing", choices(SOCKETS), "Say which socket the FMU fills.")
        raise_if_any(reader.problems)
        raise AssertionError("a socket that is neither known nor wrong")  # pragma: no cover
    made = reader.mapping(content, found, folder)
    raise_if_any(reader.problems)
    return made


class _Reader:
    """Reads the parts of a mapping and gathers what is wrong with them."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.problems: list[Problem] = []

    def wrong(self, key: str, found: str, valid: str, remedy: str = "") -> None:
        self.problems.append(Problem(f"{self.where}: {key}", found, valid, remedy))

    def unknown(self, key: str, name: str, known: Sequence[str]) -> None:
        self.wrong(key, "an unknown entry", choices(known), did_you_mean(name, known))

    def mapping(self, content: Table, socket: Socket, folder: Path) -> MappingFile:
        buses = tuple(socket.buses)
        keys = ("fmu", "socket", "axes", "feedthrough", "constants", "parameters", *buses)
        for key in (key for key in content if key not in keys):
            self.unknown(key, key, keys)
        tables = {bus: self.table(content, bus) for bus in buses}
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
            {name: entries for bus, table in tables.items() for name, entries in self.entries(bus, table, socket)},
            {bus: r for bus, table in tables.items() if (r := self.reference(bus, socket.bus(bus).position, table))},
            {bus: v for bus, table in tables.items() if (v := self.chosen(table, "velocity", VELOCITIES, None, bus))},
            self.amounts(content, "constants"),
            self.amounts(content, "parameters"),
        )

    def table(self, content: Table, key: str) -> Table:
        found = content.get(key, {})
        if not isinstance(found, dict):
            self.wrong(key, f"`{found}`", "a table")
            return {}
        return cast(Table, found)

    def text(self, content: Table, key: str, valid: str, where: str = "") -> str | None:
        found = content.get(key)
        if isinstance(found, str | None):
            return found
        self.wrong(where + key, f"`{found}`", valid)
        return None

    def chosen(
        self, content: Table, key: str, known: tuple[str, ...], default: str | None, where: str = ""
    ) -> str | None:
        found = content.get(key, default)
        if found is None or found in known:
            return found
        remedy = did_you_mean(found, known) if isinstance(found, str) else ""
        self.wrong(f"{where}.{key}" if where else key, f"`{found}`", choices(known), remedy)
        return default

    def amounts(self, content: Table, key: str) -> dict[str, Amount]:
        found = {name: self.amount(f"{key}.{name}", value) for name, value in self.table(content, key).items()}
        return {name: amount for name, amount in found.items() if amount is not None}

    def amount(self, key: str, value: Any, *, plain: bool = True) -> Amount | None:
        """A number with its unit; a `plain` one may stand alone where it has none (booleans, counts, factors)."""
        if isinstance(value, dict):
            told = cast(Table, value)
            if told.keys() <= {"value", "unit", "source"} and "value" in told and isinstance(told.get("unit", ""), str):
                return Amount(told["value"], told.get("unit", "1"))
        elif plain:
            return Amount(value)
        self.wrong(key, f"`{value}`", "a number with its unit", 'Write { value = ..., unit = "..." }.')
        return None

    def reference(self, bus: str, position: Position | None, table: Table) -> tuple[str, Amount | None] | None:
        """The point of the vehicle or the end of the boxes that positions are those of."""
        given = table.get("reference")
        if given is None:
            return None
        key = f"{bus}.reference"
        known = () if position is None else REFERENCES[position]
        content: Table = cast(Table, given) if isinstance(given, dict) else {"point": given}
        for name in (name for name in content if name not in {"point", "distance"}):
            self.unknown(f"{key}.{name}", name, ("point", "distance"))
        point = self.chosen(content, "point", known, None, key)
        if "point" not in content:
            self.wrong(f"{key}.point", "nothing", choices(known))
        if point not in POINTS[1:]:
            return (point, None) if point else None
        if "distance" not in content:
            self.wrong(f"{key}.distance", "nothing", "the distance from the centre of gravity, with its unit")
            return None
        return point, self.amount(f"{key}.distance", content["distance"], plain=False)

    def entries(self, bus: str, table: Table, socket: Socket) -> Iterator[tuple[str, tuple[Entry, ...]]]:
        signals = {v.name.partition(".")[2]: v for v in socket.signals() if v.name.startswith(f"{bus}.")}
        if table.get("velocity") == "speed_and_slip":
            signals |= {"v": signals.pop("v_x"), "beta": signals.pop("v_y")}
        for leaf, value in table.items():
            if leaf in {"reference", "velocity"}:
                continue
            if leaf not in signals:
                self.unknown(f"{bus}.{leaf}", leaf, (*signals, "reference", "velocity"))
                continue
            items = cast(list[Any], value) if isinstance(value, list) else [value]
            if signals[leaf].shape and all(isinstance(item, str) for item in items):
                yield signals[leaf].name, (Entry(variables=tuple(items)),)
            else:
                found = [self.entry(f"{bus}.{leaf}", leaf, item) for item in items]
                yield signals[leaf].name, tuple(e for e in found if e is not None)

    def entry(self, key: str, leaf: str, value: Any) -> Entry | None:
        if isinstance(value, str):
            return Entry(variables=(value,))
        if not isinstance(value, dict):
            self.wrong(key, f"`{value}`", "the name of a variable, or a table", _EXAMPLE)
            return None
        told = cast(Table, value)
        for part in (part for part in told if part not in _ENTRY):
            self.unknown(f"{key}.{part}", part, _ENTRY)
        if len(told.keys() & {"variable", "constant", "unused"}) != 1:
            self.wrong(key, f"`{value}`", "one of variable, constant, unused", _EXAMPLE)
            return None
        names = told.get("variable", [])
        listed = cast(list[Any], names) if isinstance(names, list) else [names]
        if not all(isinstance(name, str) for name in listed):
            self.wrong(f"{key}.variable", f"`{names}`", "the name of a variable, or a list of names")
            listed = []
        return Entry(
            tuple(listed),
            self.text(told, "unit", "the name of a unit", f"{key}."),
            self.role(key, leaf, told),
            self.text(told, "angle", "the name of a variable", f"{key}."),
            self.amount(f"{key}.constant", told["constant"]) if "constant" in told else None,
            "unused" in told,
            dict(self.numbers(key, told)),
        )

    def numbers(self, key: str, told: Table) -> Iterator[tuple[str, Amount]]:
        for name in _NUMBERS:
            if name not in told:
                continue
            amount = self.amount(f"{key}.{name}", told[name], plain=name in {"factor", "ratio"})
            if amount is None:
                continue
            if isinstance(amount.value, bool) or not isinstance(amount.value, int | float):
                self.wrong(f"{key}.{name}", f"`{amount.value}`", "a number")
            else:
                yield name, amount

    def role(self, key: str, leaf: str, told: Table) -> str | None:
        """What the variable is in place of our signal, with the numbers that this takes."""
        own = {"ratio", "R_w", "m", "limit", "angle"}
        known = tuple(r for r in ROLES if (r in STEERING) == (leaf == "delta_f")) if leaf in {"delta_f", "T_r"} else ()
        role = self.chosen(told, "as", known, None, key)
        wanted = {*ROLES.get(role or "", ()), *(("angle",) if role == "steering_rate" else ())}
        for number in sorted(told.keys() & own - wanted):
            of = f"a part of {choices(r for r in known if number in ROLES[r])}" if known else "nothing of this name"
            self.wrong(f"{key}.{number}", f"`{told[number]}`, which `as` does not ask for", of)
        for number in ROLES.get(role or "", ()):
            if number not in told and number != "limit":
                self.wrong(f"{key}.{number}", "nothing", f"a number with its unit, for `{role}`")
        return role
