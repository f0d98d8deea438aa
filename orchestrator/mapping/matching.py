"""Which variables of an FMU stand for the signals of a socket, where the names leave no doubt.

These are tried in order, and each decides only where exactly one variable fits:

1. the same name;
2. another spelling of the same structure: `state_v_x`, `State.vx`, `stateBus.v_x`, `In_actuation.delta_f`;
3. the last part of the name alone: `v_x`, `delta_f`;
4. the signals of a bus all together in a structure of another name: `chassis.x`, `chassis.y`, ..., `chassis.r`.

Arrays may be spread over elements or structures: `obstacles[3].x`, `obstacle_3_x`, counted from 0 or 1.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from components.interfaces.record import Variable
from components.interfaces.socket import ANY_LENGTH, Socket
from components.interfaces.sockets import SOCKETS

_INDEX: Final = re.compile(r"[\[(](\d+)[\])]|(?<=[A-Za-z])_?(\d+)(?=[._]|$)")
_DIRECTIONS: Final = ("in", "out", "input", "output")
"""Words that names of structures may begin with, besides the names of sockets."""


@dataclass(frozen=True)
class Match:
    """The variables whose elements stand for the first elements of a signal."""

    variables: tuple[Variable, ...]
    """One array, or one variable per element."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the variables."""
        return tuple(v.name for v in self.variables)


@dataclass(frozen=True)
class Candidate:
    """Variables that together have the shape of a signal, under a name without an index."""

    name: str
    match: Match
    shape: tuple[int, ...]


def match(
    socket: Socket, signals: Sequence[Variable], offered: Sequence[Variable]
) -> tuple[dict[str, Match], dict[str, list[str]]]:
    """Match signals of a socket with the variables that an FMU offers.

    Args:
        socket: The socket whose description says which arrays may be shorter, and what others call its buses.
        signals: The signals that are looked for.
        offered: The variables that none of the other signals has taken.

    Returns:
        The match of each signal that has one, and for the others the names that are equally good.
    """
    candidates = list(_candidates(offered))
    matches: dict[str, Match] = {}
    doubtful: dict[str, list[str]] = {}
    levels = (_same, partial(_same_structure, socket, _prefix()), _same_leaf)
    for level in levels:
        used = {name for m in matches.values() for name in m.names}
        free = [c for c in candidates if not used & set(c.match.names)]
        proposals = {s.name: [c for c in free if _fits(socket, s, c) and level(s.name, c.name)] for s in signals}
        proposals = {name: _preferred(name, options) for name, options in proposals.items() if name not in matches}
        takers: dict[str, int] = {}
        for option in (options[0] for options in proposals.values() if len(options) == 1):
            takers[option.name] = takers.get(option.name, 0) + 1
        for name, options in proposals.items():
            if len(options) == 1 and takers[options[0].name] == 1:
                matches[name] = options[0].match
                doubtful.pop(name, None)
            elif options:
                doubtful.setdefault(name, sorted(o.name for o in options))
    for name, candidate in _whole_buses(socket, signals, candidates, matches):
        matches[name] = candidate.match
        doubtful.pop(name, None)
    return matches, doubtful


def _candidates(offered: Sequence[Variable]) -> Iterator[Candidate]:
    """Every variable, and every group of variables that differ in one index."""
    groups: dict[str, dict[int, Variable]] = {}
    for variable in offered:
        yield Candidate(variable.name, Match((variable,)), variable.shape)
        indices = list(_INDEX.finditer(variable.name))
        if len(indices) == 1 and not variable.shape:
            at = indices[0]
            groups.setdefault(variable.name[: at.start()] + variable.name[at.end() :], {})[int(at[1] or at[2])] = (
                variable
            )
    for name, elements in groups.items():
        numbers = sorted(elements)
        if numbers == list(range(numbers[0], numbers[0] + len(numbers))) and numbers[0] in {0, 1}:
            yield Candidate(name, Match(tuple(elements[n] for n in numbers)), (len(numbers),))


def _fits(socket: Socket, signal: Variable, candidate: Candidate) -> bool:
    """Whether the shapes agree, and both are numbers; slots of a partial array may stay empty."""
    if len(signal.shape) != len(candidate.shape) or not all(
        v.quantity.type.is_number for v in candidate.match.variables
    ):
        return False
    partial_arrays = socket.bus(signal.name).partial
    return all(
        a in {ANY_LENGTH, b} or (partial_arrays and 0 < b <= a)
        for a, b in zip(signal.shape, candidate.shape, strict=True)
    )


def _preferred(signal: str, options: list[Candidate]) -> list[Candidate]:
    """Of names that differ in case only, the one that is spelled as ours."""
    leaf = signal.rpartition(".")[2]
    exact = [o for o in options if o.name.endswith(leaf)]
    return exact if len(exact) == 1 and len({o.name.lower() for o in options}) == 1 else options


def _same(signal: str, name: str) -> bool:
    return name == signal


def _same_structure(socket: Socket, prefix: re.Pattern[str], signal: str, name: str) -> bool:
    bus, _, leaf = signal.partition(".")
    plain = _plain(name)
    for variant in {plain, prefix.sub("", plain)}:
        for alias in socket.bus(bus).other_names or (bus,):
            if variant in {alias + _plain(leaf), alias + "bus" + _plain(leaf)}:
                return True
    return False


def _prefix() -> re.Pattern[str]:
    """What the name of a structure may begin with: a direction, or what a socket is called."""
    sockets = [word for known in SOCKETS.values() for word in (known.name, *known.other_names)]
    return re.compile(f"^({'|'.join(map(re.escape, (*_DIRECTIONS, *sockets)))})+(?=.)")


def _same_leaf(signal: str, name: str) -> bool:
    return _plain(name) == _plain(signal.rpartition(".")[2])


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _whole_buses(
    socket: Socket, signals: Sequence[Variable], candidates: Sequence[Candidate], found: Mapping[str, Match]
) -> Iterator[tuple[str, Candidate]]:
    """The signals of buses of which nothing is matched yet and exactly one structure of another name has them all."""
    buses: dict[str, list[Variable]] = {}
    for signal in signals:
        buses.setdefault(signal.name.partition(".")[0], []).append(signal)
    for members in buses.values():
        if len(members) < 2 or any(s.name in found for s in members):  # noqa: PLR2004 - one signal is no structure
            continue
        options: dict[str, dict[str, Candidate]] = {}
        for signal in members:
            leaf = _plain(signal.name.partition(".")[2])
            for c in candidates:
                structure, _, last = c.name.rpartition(".")
                if structure and _plain(last) == leaf and _fits(socket, signal, c):
                    options.setdefault(structure, {})[signal.name] = c
        whole = [option for option in options.values() if len(option) == len(members)]
        if len(whole) == 1:
            yield from whole[0].items()
