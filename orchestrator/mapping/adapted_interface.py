"""What a foreign unit looks like once it is adapted to a socket."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY
from components.interfaces.record import Variable
from components.interfaces.socket import Socket
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link


def adapted(
    theirs: Interface, socket: Socket, signals: Mapping[str, Variable], adaptation: Adaptation, *, feedthrough: bool
) -> tuple[Interface, list[str]]:
    """The interface of the socket, with what the FMU shows beyond it; and what was assumed on the way."""
    inputs = _read(socket, signals, adaptation)
    shown = {link.signal for link in adaptation.outputs} | set(adaptation.constants)
    own = {v.name: v for v in theirs.outputs}
    ours = [signals[s.name] for s in socket.signals("outputs") if s.name in shown]
    outputs = (*ours, *(own[name] for name in adaptation.passed_on))
    shows = [*adaptation.outputs, *(Link(name, ((name, 0),)) for name in adaptation.passed_on)]
    made_of = _reach(shows, outputs, theirs.outputs, adaptation)
    through = made_of @ theirs.feedthrough @ _reach(adaptation.inputs, inputs, theirs.inputs, adaptation).T
    remarks: list[str] = []
    if socket.acts_through_step and not feedthrough:
        through[: len(ours)] = False
    elif socket.acts_through_step:
        silent = [i for i, v in enumerate(ours) if _undeclared(v.name, theirs, adaptation) and through[i].any()]
        if silent:
            through[silent] = False
            text = f"says not what its outputs depend on; as in the socket `{socket.name}`, inputs act through the step"
            remarks.append(text)
    whole = not (adaptation.rates or adaptation.integrated)
    made = replace(theirs, inputs=inputs, outputs=outputs, feedthrough=through, event_mode=theirs.event_mode and whole)
    return made, remarks


def _read(socket: Socket, signals: Mapping[str, Variable], adaptation: Adaptation) -> tuple[Variable, ...]:
    """Inputs of ours that reach the FMU, directly or by a convention of their bus."""
    read = {link.signal for link in adaptation.inputs} | {rate.rate.signal for rate in adaptation.rates}
    buses = {name.partition(".")[0] for name in read} & adaptation.conventions.keys()
    return tuple(
        signals[s.name] for s in socket.signals("inputs") if s.name in read or s.name.partition(".")[0] in buses
    )


def _undeclared(signal: str, theirs: Interface, adaptation: Adaptation) -> bool:
    names = {n for link in adaptation.outputs if link.signal == signal for n, _ in link.theirs}
    return names <= theirs.undeclared


def _reach(
    links: Iterable[Link], ours: tuple[Variable, ...], theirs: tuple[Variable, ...], adaptation: Adaptation
) -> NDArray[np.bool_]:
    """(ours, theirs): which variables are linked; a rate acts through the step."""
    row, column = _places(ours), _places(theirs)
    found = np.zeros((len(row), len(column)), dtype=bool)
    for link in links:
        for name, _ in link.theirs:
            found[row[link.signal], column[name]] = True
    return _mixed(found, ours, adaptation)


def _mixed(found: NDArray[np.bool_], variables: tuple[Variable, ...], adaptation: Adaptation) -> Any:
    """A convention makes every signal of its bus depend on all of it."""
    for bus in adaptation.conventions:
        rows = [i for i, v in enumerate(variables) if v.name.startswith(f"{bus}.")]
        if rows:
            found[rows] = found[rows].any(axis=0)
    return found


def _places(variables: tuple[Variable, ...]) -> dict[str, int]:
    return {v.name: i for i, v in enumerate(variables)}


def is_same(theirs: Interface, ours: Interface, adaptation: Adaptation) -> bool:
    """Whether the FMU is what the socket asks for, to the letter."""

    def units(variables: Sequence[Variable]) -> list[Any]:
        return sorted((v.name, v.quantity.unit) for v in variables)

    alike = units(theirs.inputs) == units(ours.inputs) and units(theirs.outputs) == units(ours.outputs)
    return alike and is_plain(theirs, ours, adaptation) and theirs.feedthrough.sum() == ours.feedthrough.sum()


def is_plain(theirs: Interface, ours: Interface, adaptation: Adaptation) -> bool:
    """Whether values pass as they are, under the same names: a tool without our sockets can take the FMU itself."""

    def shown(variables: Sequence[Variable]) -> list[Any]:
        return sorted((v.name, v.quantity.type, v.shape) for v in variables)

    a = adaptation
    plain = all(link.relation == IDENTITY for link in (*a.inputs, *a.outputs))
    extra = a.constants or a.held or a.conventions or a.rates or a.integrated
    alike = shown(theirs.inputs) == shown(ours.inputs) and shown(theirs.outputs) == shown(ours.outputs)
    return plain and not extra and alike
