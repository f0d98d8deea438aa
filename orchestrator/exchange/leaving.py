"""A system for other tools, which know no mappings: each mapped unit becomes its FMU, with the FMU's own variables.

What a mapping says becomes part of the connections where these can say it: names, units of measurement, factors, signs
and constants, as transformations. The rest (reference points, slip angles, rates, limits) becomes FMUs of ours beside
the foreign one: `plant_in` makes its inputs, `plant_out` the socket's signals. Two, because most tools sort whole units
and would see a loop in one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from components.interfaces.conversion import IDENTITY, type_fits
from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.progress import Progress
from components.interfaces.quantity import zeros
from components.interfaces.record import Variable
from fmus.export.build import build_all
from fmus.toolchain.version import Version
from fmus.units.adaptation import Adaptation, Link
from orchestrator.exchange.element_wiring import Feed, Place, Wiring, elements, flat, rewired, wiring_of
from orchestrator.mapping.adapter_block import Adapter, Part, input_adapter, output_adapter
from orchestrator.mapping.mapped import Mapped
from orchestrator.stepping.schedule import schedule
from orchestrator.system.experiment import Scenario
from orchestrator.system.patterns import fits
from orchestrator.system.source import Fmu, UnitSource
from orchestrator.system.system import System


def for_other_tools(scenario: Scenario, folder: Path, progress: Progress, *, conversions: bool) -> Scenario:
    """The scenario without mappings, whose signals are those of the FMUs themselves.

    Args:
        scenario: Any scenario.
        folder: Where FMUs of ours are built, which have to be there as long as the result is used.
        progress: Receives a report on each FMU that is built.
        conversions: Whether connections may convert values; if not, FMUs of ours do that too.

    Raises:
        RequestError: A mapping says what neither connections nor FMUs of ours can do.
        BuildError: The compiler fails.
    """
    system = scenario.system
    units = {name: source.for_other_tools() for name, source in system.units.items()}
    raise_if_any(_problems(system, units))
    if not any(isinstance(source, Mapped) for source in units.values()):
        return replace(scenario, system=replace(system, units=units))
    early = schedule(system, scenario.algorithm, solve_loops=scenario.solve_loops).early
    leaving = _Leaving({**units}, wiring_of(system), early, folder, progress, scenario.h, conversions)
    for name, source in units.items():
        if isinstance(source, Mapped):
            leaving.exchange(name, source)
    made = rewired(system, leaving.units, leaving.wiring, [*_patterns(system, leaving.units)])
    schedule(made, scenario.algorithm, solve_loops=scenario.solve_loops)
    return replace(scenario, system=made, remarks=(*scenario.remarks, *leaving.remarks))


def _problems(system: System, units: Mapping[str, UnitSource]) -> Iterator[Problem]:
    """The problems of units that no other tool runs, and of mapped ones that are asked for more than it can do."""
    for name, source in units.items():
        if not isinstance(source, Mapped):
            yield from [problem] if (problem := source.foreign_problem(name)) is not None else []
            continue
        followed = [c.path for c in system.table.columns if c.unit == name] if system.table else []
        if followed:
            valid = "inputs of FMUs without a mapping"
            yield Problem(followed[0], "an input behind a mapping that follows a table", valid, "Leave --input out.")
        adaptation = source.fitting.adaptation
        if name in system.steps and (adaptation.rates or adaptation.integrated):
            found = f"{system.steps[name]} macro steps, over which its mapping forms rates or integrates them"
            yield Problem(f"step of `{name}`", found, "the macro step", "Leave out the step of its own.")


def _patterns(system: System, units: Mapping[str, UnitSource]) -> Iterator[str]:
    """The patterns of signals that may be infinite, for what stands behind the signals of a mapped unit too."""
    shown = [f"{n}.{path}" for n, s in units.items() for v in s.interface.outputs for path in (v.name, *v.elements)]
    for pattern in system.allow_nonfinite:
        if pattern == "*" or any(fits(path, pattern) for path in shown):
            yield pattern
        for name, source in system.units.items():
            if isinstance(source, Mapped):
                links = [k for k in source.fitting.adaptation.outputs if fits(f"{name}.{k.signal}", pattern)]
                yield from dict.fromkeys(f"{name}.{theirs}" for link in links for theirs, _ in link.theirs)
                yield from (path for link in links if (path := f"{name}_out.{link.signal}") in shown)


@dataclass
class _Leaving:
    """A system while its mapped units are exchanged one by one."""

    units: dict[str, UnitSource]
    wiring: Wiring
    early: frozenset[str]
    """The units that have made a step when their outputs are first read."""
    folder: Path
    progress: Progress
    h: float
    conversions: bool
    remarks: tuple[str, ...] = ()

    def exchange(self, name: str, source: Mapped) -> None:
        """Put the FMU itself in the place of a mapped unit, with FMUs of ours beside it where it needs them."""
        self.units[name] = source.bare
        given, shown = self._reading(name, source), self._showing(name, source)
        at_work = [self._behind(name, source, shown)] if shown else []
        at_work += [self._before(name, source, given)] if given else []
        if at_work:
            late = "; a tool that exchanges values one step late delays signals by one step more in each"
            text = f"{name}: its mapping goes along as {' and '.join(at_work)}{late if self.conversions else ''}"
            self.remarks += (text,)
        held = {v.name: v for v in source.fmu.interface.inputs}
        for variable, value in source.fitting.adaptation.held.items():
            places = elements(name, held[variable])
            self.wiring |= {place: Feed(None, one) for place, one in zip(places, flat(value), strict=True)}

    def _reading(self, name: str, source: Mapped) -> Part | None:
        """What reaches the FMU: rewired where connections can say it, else the part of an FMU of ours."""
        whole, ours = source.fitting.adaptation, {v.name: v for v in source.interface.inputs}
        driven = {end.variable for end in self.wiring if end.unit == name}
        inputs = tuple(link for link in whole.inputs if link.signal in driven)
        rates = tuple(rate for rate in whole.rates if rate.rate.signal in driven)
        own = _of_buses(whole, driven)
        if own or rates or not all(self._is_said(link, source, ours[link.signal], back=True) for link in inputs):
            part = Adaptation(inputs=inputs, rates=rates, conventions=own)
            return Part(part, [v for n, v in ours.items() if n in driven], source.fmu.interface, self.h)
        wires = {end: self.wiring.pop(end) for end in [*self.wiring] if end.unit == name}
        for link in inputs:
            for i, theirs in enumerate(link.theirs):
                drive = wires.get(Place(name, link.signal, i))
                if drive is not None:
                    self.wiring[Place(name, *theirs)] = (
                        drive if link.relation == IDENTITY else drive.then(link.relation.inverse)
                    )
        return None

    def _showing(self, name: str, source: Mapped) -> Part | None:
        """What other units read of the FMU: rewired where connections can say it, else the part of an FMU of ours."""
        whole = source.fitting.adaptation
        ours = {v.name: v for v in source.interface.outputs if v.name not in whole.passed_on}
        read = {d.origin.variable for d in self.wiring.values() if d.origin and d.origin.unit == name} & ours.keys()
        own = _of_buses(whole, read)
        read |= {n for n in ours if n.partition(".")[0] in own}
        outputs = tuple(link for link in whole.outputs if link.signal in read)
        integrated = tuple(n for n in whole.integrated if n in read)
        constants = {n: value for n, value in whole.constants.items() if n in read}
        if own or integrated or not all(self._is_said(link, source, ours[link.signal]) for link in outputs):
            part = Adaptation(outputs=outputs, constants=constants, conventions=own, integrated=integrated)
            made = [v for n, v in ours.items() if n in read]
            return Part(part, made, source.fmu.interface, self.h, early=name in self.early)
        links = {(link.signal, i): (link, theirs) for link in outputs for i, theirs in enumerate(link.theirs)}
        for end, drive in self.wiring.items():
            if drive.origin is None or drive.origin.unit != name or drive.origin.variable not in read:
                continue
            signal, i = drive.origin.variable, drive.origin.element
            if (signal, i) in links:
                link, theirs = links[signal, i]
                self.wiring[end] = drive.after(Place(name, *theirs), link.relation)
            else:
                empty = zeros(ours[signal].quantity.type, ours[signal].size).tolist()
                self.wiring[end] = drive.constant(flat(constants.get(signal, empty))[i])
        return None

    def _is_said(self, link: Link, source: Mapped, ours: Variable, *, back: bool = False) -> bool:
        """Whether connections can say what a link does."""
        theirs = {v.name: v.quantity for v in (source.fmu.interface.inputs if back else source.fmu.interface.outputs)}
        for name, _ in link.theirs:
            ends = (ours.quantity, theirs[name]) if back else (theirs[name], ours.quantity)
            plain = link.relation == IDENTITY and type_fits(*ends)
            converted = self.conversions and all(q.type.is_float for q in ends)
            if not (plain or converted) or math.isfinite(link.low) or math.isfinite(link.high):
                return False
        return True

    def _before(self, name: str, source: Mapped, part: Part) -> str:
        """Lead what the FMU reads over an FMU of ours; the result is its name."""
        unit = self._unused(f"{name}_in")
        adapter = input_adapter(unit, part)
        self.units[unit] = self._built(adapter, source)
        for end in [end for end in self.wiring if end.unit == name]:
            self.wiring[end._replace(unit=unit)] = self.wiring.pop(end)
        self._connect(name, unit, adapter)
        return unit

    def _behind(self, name: str, source: Mapped, part: Part) -> str:
        """Lead what others read of the FMU over an FMU of ours; the result is its name."""
        unit = self._unused(f"{name}_out")
        adapter = output_adapter(unit, part)
        self.units[unit] = self._built(adapter, source)
        made = {Place(name, v.name, i) for v in part.ours for i in range(v.size)}
        for end, drive in self.wiring.items():
            if drive.origin is not None and drive.origin in made:
                self.wiring[end] = replace(drive, origin=drive.origin._replace(unit=unit))
        self._connect(name, unit, adapter)
        return unit

    def _unused(self, unit: str) -> str:
        return unit if unit not in self.units else self._unused(f"{unit}_")

    def _built(self, adapter: Adapter, source: Mapped) -> Fmu:
        version = Version.FMI2 if source.fmu.is_fmi2 else Version.FMI3
        return Fmu(build_all([(adapter.block, version, {})], self.folder, self.progress)[0].path)

    def _connect(self, name: str, unit: str, adapter: Adapter) -> None:
        """Connect an FMU of ours with the one that it stands beside."""
        self.wiring |= {Place(unit, port): Feed(Place(name, *place)) for place, port in adapter.reads.items()}
        self.wiring |= {Place(name, *place): Feed(Place(unit, port)) for place, port in adapter.sets.items()}


def _of_buses(adaptation: Adaptation, signals: set[str]) -> dict[str, Any]:
    """The conventions of the buses of some signals."""
    buses = {name.partition(".")[0] for name in signals}
    return {bus: conventions for bus, conventions in adaptation.conventions.items() if bus in buses}
