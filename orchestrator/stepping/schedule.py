"""The schedule: in which order the units exchange data and step within one macro step.

`sequential` (the default) has no hidden delay, as the sorted order of a fixed-step Simulink model. A unit is *early*
when its outputs show by stepping and one of its connected outputs depends on a connected input (a controller): at t_k
it must read and step before others can read it. So is one that no unit reads, if it depends on its inputs. All other
units are *late*: they show their outputs at t_k, and step to t_{k+1} once their inputs at t_k are known. Outputs of a
late unit that depend on its inputs are shown again when these are known, if the unit can do that
(`Interface.output_after_set`).

`jacobi` is what most other masters do: at t_k every unit's inputs are set from the outputs shown at t_k, then all step
to t_{k+1}, then all show their outputs. A controller acts one macro step late.

`clocked` is `sequential` with FMI 3.0 Event Mode: a unit that has it is not stepped early but activated at t_k: in
Event Mode it takes its inputs, its periodic input clocks that are due and the triggered clocks that reach it, and shows
its outputs at t_k; it steps with the late ones. Units without Event Mode are treated as in `sequential`.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from graphlib import CycleError, TopologicalSorter
from typing import Any, TypeAlias

import numpy as np
from typing_extensions import override

from components.interfaces.problem import Problem, RequestError, refuse
from fmus.unit_interface import Interface
from fmus.units.unit import Unit
from orchestrator.system.experiment import Algorithm
from orchestrator.system.source import SourceDescription, UnitSource
from orchestrator.system.system import Connection, System


class Act(StrEnum):
    """What a unit does next; `SOLVE` is the act of all units of a loop together."""

    SET = "set"
    STEP = "step"
    GET = "get"
    ACTIVATE = "activate"
    UPDATE = "update"
    SOLVE = "solve"


Acts: TypeAlias = tuple[tuple[Act, tuple[str, ...]], ...]
"""Each act with the unit that does it, or with all units of a loop."""


@dataclass(frozen=True)
class Schedule:
    """The acts of one macro step: `before` completes the instant t_k, `after` leads from t_k to t_{k+1}."""

    order: tuple[str, ...]
    """All units, each after those whose outputs at t_k it needs."""
    before: Acts
    after: Acts
    early: frozenset[str] = frozenset()
    """Units that step before others can read their outputs at t_k."""
    loops: tuple[tuple[str, ...], ...] = ()
    """Groups of units that need each other's outputs at t_k."""
    events: frozenset[str] = frozenset()
    """Units that use Event Mode."""

    def __str__(self) -> str:
        return "; ".join(f"{act} {', '.join(units)}" for act, units in (*self.before, *self.after))


def schedule(system: System, algorithm: Algorithm = Algorithm.SEQUENTIAL, *, solve_loops: bool = False) -> Schedule:
    """The schedule of a system.

    Args:
        system: Units and connections.
        algorithm: How the units exchange data and step.
        solve_loops: Whether algebraic loops are solved by iteration instead of refused.

    Raises:
        RequestError: There is an algebraic loop, shown as its chain, that is not to be solved, or in which a unit
            cannot return to a saved state.
    """
    if algorithm is Algorithm.JACOBI:
        names = tuple(system.units)
        everybody = [(act, (name,)) for act in (Act.SET, Act.STEP, Act.GET) for name in names]
        return Schedule(_initial_order(system), before=(), after=tuple(everybody))
    events = {n for n, s in system.units.items() if algorithm is Algorithm.CLOCKED and s.interface.event_mode}
    early = {name for name in system.units if _is_early(system, name) or (name in events and _ticks(system, name))}
    needs = _needs(system, early)
    groups = _groups(needs)
    loops = tuple(tuple(group) for group in groups if len(group) > 1 or group[0] in needs[group[0]])
    if loops:
        _check_loops(system, needs, loops, early, events, solve_loops=solve_loops)
    return _assembled(system, groups, loops, early, events)


def _assembled(
    system: System, groups: list[list[str]], loops: tuple[tuple[str, ...], ...], early: set[str], events: set[str]
) -> Schedule:
    order = [name for group in groups for name in group]
    again = {name for name in order if name not in early and _shows_again(system, name)}
    before: list[tuple[Act, tuple[str, ...]]] = []
    for group in groups:
        name = group[0]
        if tuple(group) in loops:
            before.append((Act.SOLVE, tuple(group)))
        elif name in events & early:
            # clocked outputs can be read only until the update ends the tick, others may change with the update
            before += [(act, (name,)) for act in (Act.ACTIVATE, Act.SET, Act.GET, Act.UPDATE, Act.GET)]
        elif name in early:
            before += [(act, (name,)) for act in (Act.SET, Act.STEP, Act.GET)]
        elif name in again:
            before += [(act, (name,)) for act in (Act.SET, Act.GET)]
    late = [name for name in order if name not in early or name in events]
    after = [(Act.SET, (name,)) for name in late if name not in again and name not in events]
    # inputs that jump are an event, too, even where no output depends on them at once
    after += [(act, (name,)) for name in late if name in events - early for act in (Act.ACTIVATE, Act.SET, Act.UPDATE)]
    after += [(act, (name,)) for act in (Act.STEP, Act.GET) for name in late]
    return Schedule(tuple(order), tuple(before), tuple(after), frozenset(early), loops, frozenset(events))


def _is_early(system: System, name: str) -> bool:
    interface = system.units[name].interface
    if interface.output_after_set:
        return False
    read = {c.input for c in system.connections_to(name)}
    shown = {c.output for c in system.connections_from(name)}
    rows = [i for i, y in enumerate(interface.outputs) if y.name in shown or not shown]
    columns = [j for j, u in enumerate(interface.inputs) if u.name in read]
    return bool(interface.feedthrough[np.ix_(rows, columns)].any())


def _ticks(system: System, name: str) -> bool:
    """Whether a unit has clocks that make it act at an instant."""
    return any(clock.causality == "input" for clock in system.units[name].interface.clocks)


def open_dependencies_close_a_loop(system: System) -> bool:
    """Whether there is an algebraic loop only because some units do not declare what their outputs depend on."""
    declared = {name: _AsDeclared(source) for name, source in system.units.items()}
    try:
        schedule(system)
    except RequestError:
        try:
            schedule(dataclasses.replace(system, units=declared))
        except RequestError:
            return False
        return True
    return False


@dataclass(frozen=True)
class _AsDeclared(UnitSource):
    """A unit with the dependencies that its file declares, and no others; it is inspected, but never opened."""

    source: UnitSource

    @property
    @override
    def interface(self) -> Interface:
        found = self.source.interface
        return found.acting_through_step(found.undeclared)

    @property
    def parameters(self) -> Mapping[str, Any]:  # type: ignore[override] - those of the unit
        return self.source.parameters

    @override
    def with_parameters(self, parameters: Mapping[str, Any]) -> UnitSource:
        return _AsDeclared(self.source.with_parameters(parameters))

    @override
    def describe(self) -> SourceDescription:
        return self.source.describe()

    @override
    def foreign_problem(self, unit: str) -> Problem | None:
        return self.source.foreign_problem(unit)

    @override
    def open(self, name: str) -> Unit:
        return self.source.open(name)


def _shows_again(system: System, name: str) -> bool:
    interface = system.units[name].interface
    # what is observed may depend on any input, which the file does not say
    return interface.output_after_set and bool(interface.feedthrough.any() or (interface.observed and interface.inputs))


Needs: TypeAlias = Mapping[str, Mapping[str, Connection]]
"""For every unit the sources that it needs at the same instant, each with one of the wires."""


def _needs(system: System, early: set[str]) -> Needs:
    needs: dict[str, dict[str, Connection]] = {name: {} for name in system.units}
    following = {name: follows_inputs(source.interface) for name, source in system.units.items()}
    for wire in system.connections:
        # the source has to act at t_k before the output on this wire is known
        if wire.source in early or wire.output in following[wire.source]:
            needs[wire.unit][wire.source] = wire
    for wire in system.clock_connections:
        if wire.source in early:
            needs[wire.unit].setdefault(wire.source, wire)
    return needs


def follows_inputs(interface: Interface) -> frozenset[str]:
    """The outputs that change with the inputs of a unit at one instant, without a step."""
    if not interface.output_after_set:
        return frozenset()
    rows = np.flatnonzero(interface.feedthrough.any(axis=1))
    return frozenset(interface.outputs[row].name for row in rows.tolist())


def _initial_order(system: System) -> tuple[str, ...]:
    """The order in which outputs get known when nothing has been stepped: whatever depends on an input comes later."""
    through = {name for name, source in system.units.items() if source.interface.feedthrough.any()}
    return tuple(name for group in _groups(_needs(system, through)) for name in group)


def _groups(needs: Needs) -> list[list[str]]:
    """Units sorted so that each comes after the sources it needs; those that need each other are one group."""
    try:
        return [[name] for name in TopologicalSorter(needs).static_order()]
    except CycleError:
        group_of = _need_each_other(needs)
    graph = {
        group: dict.fromkeys(group_of[source] for name in group for source in needs[name] if source not in group)
        for group in dict.fromkeys(group_of.values())
    }
    return [list(group) for group in TopologicalSorter(graph).static_order()]


def _need_each_other(needs: Needs) -> dict[str, tuple[str, ...]]:
    """For every unit all units that need it and that it needs, through others too, with itself among them."""
    from scipy.sparse import csgraph, csr_array  # noqa: PLC0415 - slow to import, and most systems have no loop

    at = {name: i for i, name in enumerate(needs)}
    ends = [(at[name], at[source]) for name, sources in needs.items() for source in sources]
    rows, columns = np.array(ends).T
    graph = csr_array((np.ones(len(ends)), (rows, columns)), shape=(len(at), len(at)))
    _, labels = csgraph.connected_components(graph, connection="strong")
    groups: dict[int, list[str]] = {}
    for name, label in zip(needs, labels.tolist(), strict=True):
        groups.setdefault(label, []).append(name)
    return {name: tuple(group) for group in groups.values() for name in group}


def _check_loops(  # noqa: PLR0913 - what is known of a loop
    system: System,
    needs: Needs,
    loops: Iterable[tuple[str, ...]],
    early: set[str],
    events: set[str],
    *,
    solve_loops: bool,
) -> None:
    chain = _chain(needs)
    valid = "a chain of connections without a loop of direct feedthrough"
    if not solve_loops:
        raise refuse("algebraic loop", chain, valid, _remedy(system, itertools.chain(*loops)))
    problems: list[Problem] = []
    for name in itertools.chain(*loops):
        where = f"algebraic loop {chain}"
        if name in events or (name in early and not system.units[name].interface.rolls_back):
            found = f"`{name}`, which cannot go back to where it was"
            valid = "units that save and restore their state (canGetAndSetFMUState)"
            problems.append(Problem(where, found, valid, "Exchange values one step late: --algorithm jacobi."))
        if name in system.steps:
            problems.append(Problem(where, f"`{name}`, which has a step of its own", "units that step with the others"))
    if problems:
        raise RequestError(problems)


def _remedy(system: System, names: Iterable[str]) -> str:
    # many FMUs declare no dependencies, though their outputs follow from the state: the loop is then in the file only
    silent = [f"`{name}`" for name in names if system.units[name].interface.undeclared]
    unsure = f" It may be none: without declared dependencies, all inputs count as feedthrough: {', '.join(silent)}."
    return (
        "Break it with a unit whose output does not depend on its input at the same instant (a state, a delay),"
        " have it solved by iteration with --solve-loops, or exchange values one step late with --algorithm jacobi."
        + (unsure if silent else "")
    )


def _chain(needs: Needs) -> str:
    try:
        TopologicalSorter({name: list(sources) for name, sources in needs.items()}).prepare()
    except CycleError as error:
        # graphlib lists each unit before the one that needs it, the first once more at the end
        return ", ".join(str(needs[user][source]) for source, user in itertools.pairwise(error.args[1]))
    raise AssertionError("no loop")  # pragma: no cover - called only where there is one
