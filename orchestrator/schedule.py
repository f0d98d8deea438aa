"""The schedule: in which order the units exchange data and step within one macro step, with no hidden delay.

A unit is *early* when its outputs show by stepping and one of its connected outputs depends on a connected input
(a controller): at t_k it must read and step before others can read it. So is one that nobody reads, if it depends on
its inputs. All other units are *late*: they show their outputs at t_k, and step to t_{k+1} once their inputs at t_k
are known. Outputs of a late unit that depend on its
inputs are shown again when these are known, if the unit can do that (`Interface.output_after_set`).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from graphlib import CycleError, TopologicalSorter

import numpy as np

from components.interfaces.problem import refuse
from orchestrator.system import Connection, System


class Act(StrEnum):
    """What a unit is told to do."""

    SET = "set"
    STEP = "step"
    GET = "get"


@dataclass(frozen=True)
class Schedule:
    """The acts of one macro step: `before` completes the instant t_k, `after` leads from t_k to t_{k+1}."""

    order: tuple[str, ...]
    """All units, each after those whose outputs at t_k it needs."""
    before: tuple[tuple[Act, str], ...]
    after: tuple[tuple[Act, str], ...]

    def __str__(self) -> str:
        return "; ".join(f"{act} {unit}" for act, unit in (*self.before, *self.after))


def sequential(system: System) -> Schedule:
    """The schedule without hidden delay. Raises `RequestError` for an algebraic loop, shown as its chain."""
    early = {name for name in system.units if _is_early(system, name)}
    again = {name for name in system.units if name not in early and _shows_again(system, name)}
    order = _order(system, early)

    before: list[tuple[Act, str]] = []
    for name in order:
        if name in early:
            before += [(Act.SET, name), (Act.STEP, name), (Act.GET, name)]
        elif name in again:
            before += [(Act.SET, name), (Act.GET, name)]
    late = [name for name in order if name not in early]
    after = [(Act.SET, name) for name in late if name not in again]
    after += [(Act.STEP, name) for name in late]
    after += [(Act.GET, name) for name in late]
    return Schedule(tuple(order), tuple(before), tuple(after))


def _is_early(system: System, name: str) -> bool:
    interface = system.units[name].interface
    if interface.output_after_set:
        return False
    read = {c.input for c in system.connections if c.unit == name}
    shown = {c.output for c in system.connections if c.source == name}
    rows = [i for i, y in enumerate(interface.outputs) if y.name in shown or not shown]
    columns = [j for j, u in enumerate(interface.inputs) if u.name in read]
    return bool(interface.feedthrough[np.ix_(rows, columns)].any())


def _shows_again(system: System, name: str) -> bool:
    interface = system.units[name].interface
    return interface.output_after_set and bool(interface.feedthrough.any())


def _order(system: System, early: set[str]) -> list[str]:
    """Units sorted so that each comes after the sources it needs at the same instant."""
    needs: dict[str, dict[str, Connection]] = {name: {} for name in system.units}
    for wire in system.connections:
        through = _needed_now(system, wire, early)
        if through:
            needs[wire.unit][wire.source] = wire
    try:
        return list(TopologicalSorter({name: list(sources) for name, sources in needs.items()}).static_order())
    except CycleError as error:
        raise _loop(error.args[1], needs) from error


def _needed_now(system: System, wire: Connection, early: set[str]) -> bool:
    """Whether the source has to act at t_k before the output on this wire is known."""
    interface = system.units[wire.source].interface
    if wire.source in early:
        return True
    row = [v.name for v in interface.outputs].index(wire.output)
    return interface.output_after_set and bool(interface.feedthrough[row].any())


def _loop(chain: list[str], needs: Mapping[str, Mapping[str, Connection]]) -> Exception:
    # graphlib lists each unit before the one that needs it, the first once more at the end
    wires = [needs[user][source] for source, user in itertools.pairwise(chain)]
    return refuse(
        "algebraic loop",
        ", ".join(str(wire) for wire in wires),
        "a chain of connections without a loop of direct feedthrough",
        "Break it with a unit whose output does not depend on its input at the same instant (a state, a delay).",
    )
