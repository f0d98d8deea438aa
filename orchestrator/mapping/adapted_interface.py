"""The interface of an FMU of another maker that is adapted to a socket."""

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
    """The interface of an FMU that is adapted to a socket.

    Args:
        theirs: The interface of the FMU.
        socket: The socket.
        signals: The signals of the socket by name, with the lengths that the FMU gives to open ones.
        adaptation: What stands between the two.
        feedthrough: Whether outputs may depend on inputs at the same instant where the FMU declares so.

    Returns:
        The interface of the socket, with what the FMU shows beyond it; and what was assumed, as texts that continue
        the FMU's name.
    """
    inputs = _read(socket, signals, adaptation)
    shown = {link.signal for link in adaptation.outputs} | set(adaptation.constants)
    own = {v.name: v for v in theirs.outputs}
    ours = [signals[s.name] for s in socket.signals("outputs") if s.name in shown]
    outputs = (*ours, *(own[name] for name in adaptation.passed_on))
    shows = [*adaptation.outputs, *(Link(name, ((name, 0),)) for name in adaptation.passed_on)]
    shown_by = _reach(shows, outputs, theirs.outputs, adaptation)
    through = shown_by @ theirs.feedthrough @ _reach(adaptation.inputs, inputs, theirs.inputs, adaptation).T
    assumed: list[str] = []
    if socket.acts_through_step and not feedthrough:
        through[: len(ours)] = False
    elif socket.acts_through_step:
        silent = [i for i, v in enumerate(ours) if _undeclared(v.name, theirs, adaptation) and through[i].any()]
        if silent:
            through[silent] = False
            text = f"says not what its outputs depend on; as in the socket `{socket.name}`, inputs act through the step"
            assumed.append(text)
    # rates are formed and integrated over whole macro steps, which an event would divide
    event_mode = theirs.event_mode and not (adaptation.rates or adaptation.integrated)
    return replace(theirs, inputs=inputs, outputs=outputs, feedthrough=through, event_mode=event_mode), assumed


def _read(socket: Socket, signals: Mapping[str, Variable], adaptation: Adaptation) -> tuple[Variable, ...]:
    """The input signals that reach the FMU, directly or by a convention of their bus."""
    read = {link.signal for link in adaptation.inputs} | {rate.rate.signal for rate in adaptation.rates}
    buses = {name.partition(".")[0] for name in read} & adaptation.conventions.keys()
    return tuple(
        signals[s.name] for s in socket.signals("inputs") if s.name in read or s.name.partition(".")[0] in buses
    )


def _undeclared(signal: str, theirs: Interface, adaptation: Adaptation) -> bool:
    """Whether the FMU leaves open what the variables behind a signal depend on."""
    names = {n for link in adaptation.outputs if link.signal == signal for n, _ in link.theirs}
    return names <= theirs.undeclared


def _reach(
    links: Iterable[Link], ours: tuple[Variable, ...], theirs: tuple[Variable, ...], adaptation: Adaptation
) -> NDArray[np.bool_]:
    """Which variables are linked, of shape (ours, theirs); rate inputs are left out, as they act through the step."""
    row, column = ({v.name: i for i, v in enumerate(variables)} for variables in (ours, theirs))
    linked = np.zeros((len(row), len(column)), dtype=bool)
    for link in links:
        for name, _ in link.theirs:
            linked[row[link.signal], column[name]] = True
    for bus in adaptation.conventions:  # makes every signal of its bus depend on all of them
        rows = [i for i, v in enumerate(ours) if v.name.startswith(f"{bus}.")]
        if rows:
            linked[rows] = linked[rows].any(axis=0)
    return linked


def is_same(theirs: Interface, ours: Interface, adaptation: Adaptation) -> bool:
    """Whether the FMU already is what `ours`, its adapted interface, says, so that nothing has to be adapted."""

    def units(variables: Sequence[Variable]) -> list[Any]:
        return sorted((v.name, v.quantity.unit) for v in variables)

    alike = units(theirs.inputs) == units(ours.inputs) and units(theirs.outputs) == units(ours.outputs)
    return alike and is_plain(theirs, ours, adaptation) and theirs.feedthrough.sum() == ours.feedthrough.sum()


def is_plain(theirs: Interface, ours: Interface, adaptation: Adaptation) -> bool:
    """Whether values pass as they are, under the same names, so that a tool without sockets can take the FMU itself."""

    def shown(variables: Sequence[Variable]) -> list[Any]:
        return sorted((v.name, v.quantity.type, v.shape) for v in variables)

    a = adaptation
    plain = all(link.relation == IDENTITY for link in (*a.inputs, *a.outputs))
    extra = a.constants or a.held or a.conventions or a.rates or a.integrated
    alike = shown(theirs.inputs) == shown(ours.inputs) and shown(theirs.outputs) == shown(ours.outputs)
    return plain and not extra and alike


def through_step_of(theirs: Interface, ours: Interface, adaptation: Adaptation) -> frozenset[str]:
    """The outputs of the FMU that follow inputs at once by its file, and through a step only by its place in a socket.

    Args:
        theirs: The interface of the FMU.
        ours: Its adapted interface.
        adaptation: What stands between the two.
    """
    links = (*adaptation.inputs, *(rate.rate for rate in adaptation.rates))
    driven = {name for link in links for name, _ in link.theirs}
    columns = [i for i, v in enumerate(theirs.inputs) if v.name in driven]
    follows = {v.name for v, row in zip(theirs.outputs, theirs.feedthrough, strict=True) if row[columns].any()}
    at_once = {v.name for v, row in zip(ours.outputs, ours.feedthrough, strict=True) if row.any()}
    shown = [*adaptation.outputs, *(Link(name, ((name, 0),)) for name in adaptation.passed_on)]
    kept = {name for link in shown if link.signal in at_once for name, _ in link.theirs}
    return frozenset(name for link in shown for name, _ in link.theirs if name in follows - kept)
