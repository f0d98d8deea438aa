"""How a foreign FMU fits a socket: what its mapping file says, and what its names leave no doubt about."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from components.interfaces.problem import Problem, choices, did_you_mean
from components.interfaces.record import Variable
from components.interfaces.socket import ANY_LENGTH, Reading, Socket, describe
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link, RateInput
from orchestrator.mapping.adapted_interface import adapted, is_plain, is_same
from orchestrator.mapping.mapping_file import Amount, Entry, MappingFile
from orchestrator.mapping.matching import match
from orchestrator.mapping.relations import Relations
from orchestrator.mapping.words import decision, listed, offer, remark


@dataclass(frozen=True)
class Row:
    """One signal of the socket, and what stands for it."""

    signal: Variable
    role: str
    """`inputs` or `outputs`"""
    needed: bool
    theirs: str = ""
    """Variables and constants as text; empty where there is nothing"""
    note: str = ""
    """What was decided without being told"""
    remark: str = ""
    """The remark of the fitting that tells of this decision"""
    misfit: bool = False
    """Whether there is a variable of this name that cannot stand for the signal; a problem says why"""


@dataclass(frozen=True)
class Fitting:
    """An FMU in a socket: all that was decided, and what is wrong."""

    mapping: MappingFile
    """Complete: with an entry for every signal that something stands for"""
    adaptation: Adaptation
    interface: Interface
    rows: tuple[Row, ...]
    problems: tuple[Problem, ...]
    remarks: tuple[str, ...]
    needed: bool
    """Whether there is anything to translate at all"""
    plain: bool
    """Whether values pass as they are, under the same names"""


def fit(name: str, socket: Socket, theirs: Interface, file: str, mapping: MappingFile | None = None) -> Fitting:
    """Fit what `theirs` shows and reads to `socket`, as `mapping` says and its names suggest.

    `name` is the unit's, `file` the FMU's path, both for messages.
    """
    return _Fit(name, socket, theirs, Path(file).name, file, mapping).done()


@dataclass
class _Fit:
    name: str
    socket: Socket
    theirs: Interface
    file: str
    path: str
    given: MappingFile | None
    problems: list[Problem] = field(default_factory=list[Problem])
    remarks: list[str] = field(default_factory=list[str])
    rows: list[Row] = field(default_factory=list[Row])
    inputs: list[Link] = field(default_factory=list[Link])
    outputs: list[Link] = field(default_factory=list[Link])
    rates: list[RateInput] = field(default_factory=list[RateInput])
    integrated: list[str] = field(default_factory=list[str])
    constants: dict[str, Any] = field(default_factory=dict[str, Any])
    found: dict[str, tuple[Entry, ...]] = field(default_factory=dict[str, tuple[Entry, ...]])

    def __post_init__(self) -> None:
        self.mapping = self.given or MappingFile(self.name)
        polar = [bus for bus, velocity in self.mapping.velocities.items() if velocity == "speed_and_slip"]
        mirrored = self.mapping.axes == "y_right"
        slips = {f"{bus}.v_y": "rad" for bus in polar}
        self.relations = Relations(self.socket, self.mapping.where, slips, mirrored, self.problems)

    def done(self) -> Fitting:
        self._entries("inputs")
        self._entries("outputs")
        self._number_slots()
        self._missing()
        driven = self._driven()
        held = self._held(driven)
        if free := [v.name for v in self.theirs.inputs if v.name not in {*driven, *held}]:
            self.remarks.append(f"{self.name}: nothing drives {listed(free)} of {self.file}; start values are kept")
        adaptation = Adaptation(
            tuple(self.inputs),
            tuple(self.outputs),
            self.constants,
            held,
            {
                bus: steps
                for bus in self.socket.buses
                if (steps := tuple(self.relations.conventions(bus, self.mapping)))
            },
            tuple(self.rates),
            tuple(self.integrated),
            self._passed_on(),
        )
        signals = {s.name: s for s in self._signals_with_lengths()}
        feedthrough = self.mapping.feedthrough
        interface, told = adapted(self.theirs, self.socket, signals, adaptation, feedthrough=feedthrough)
        self.remarks += [f"{self.name}: {self.file} {text}" for text in told]
        found = {s.name: self.found[s.name] for s in self.socket.signals() if s.name in self.found}
        return Fitting(
            replace(self.mapping, socket=self.socket.name, signals=found),
            adaptation,
            interface,
            tuple(self.rows),
            tuple(dict.fromkeys(self.problems)),
            tuple(self.remarks),
            needed=not is_same(self.theirs, interface, adaptation),
            plain=is_plain(self.theirs, interface, adaptation),
        )

    def _entries(self, role: str) -> None:
        """Links for all signals of one direction: those that the file names first."""
        signals = self.socket.signals(role)
        offered: tuple[Variable, ...] = getattr(self.theirs, role)
        given = self.mapping.signals
        rows = {s.name: self._told(s, role, given[s.name], offered) for s in signals if s.name in given}
        links = [*(self.inputs if role == "inputs" else self.outputs), *(r.rate for r in self.rates)]
        taken = {name for link in links for name, _ in link.theirs}
        free = [v for v in offered if v.name not in taken]
        matches, doubtful = match(self.socket, [s for s in signals if s.name not in rows], free)
        for signal in signals:
            if signal.name in rows:
                self.rows.append(rows[signal.name])
                continue
            several = ", ".join(f"`{n}`" for n in doubtful.get(signal.name, ()))
            row = Row(signal, role, self._needed(signal, role), note=several and f"could be {several}")
            found = matches.get(signal.name)
            self.rows.append(self._guessed(row, Entry(variables=found.names), offered) if found else row)

    def _told(self, signal: Variable, role: str, entries: Sequence[Entry], offered: Sequence[Variable]) -> Row:
        """A signal that the mapping file has something to say about."""
        where = f"{self.mapping.where}: {signal.name}"
        texts: list[str] = []
        for entry in entries:
            if entry.constant is not None:
                texts.append(f"{entry.constant.value} {entry.constant.unit}".removesuffix(" 1"))
                self._constant(signal, role, entry.constant)
            elif entry.unused:
                texts.append("unused")
                if role == "outputs" and self._needed(signal, role):
                    valid = f"a variable or a constant: the socket `{self.socket.name}` asks for it"
                    self.problems.append(Problem(where, "unused", valid))
            elif not entry.missing:
                texts.append(listed(entry.variables))
                self._linked(where, signal, role, entry, offered)
        self.found[signal.name] = tuple(entries)
        return Row(signal, role, self._needed(signal, role), "; ".join(texts))

    def _linked(self, where: str, signal: Variable, role: str, entry: Entry, offered: Sequence[Variable]) -> bool:
        """Whether an entry that names variables could be made a link."""
        link = self.relations.link(where, signal, entry, offered)
        if link is None:
            return False
        if role == "outputs":
            self.outputs.append(link)
            self.integrated += [signal.name] if entry.role == "steering_rate" else []
        elif entry.role == "steering_rate":
            rate = self.relations.rate(where, signal, entry, link, self.theirs.outputs)
            self.rates += [rate] if rate else []
        else:
            self.inputs.append(link)
        return True

    def _guessed(self, row: Row, entry: Entry, offered: Sequence[Variable]) -> Row:
        """A signal whose variable has a name that leaves no doubt."""
        before = len(self.problems)
        where = f"{self.name}.{row.signal.name}"
        if not self._linked(where, row.signal, row.role, entry, offered):
            if row.needed:
                return replace(row, note=f"{self.problems[-1].found} does not fit", misfit=True)
            self.remarks.append(f"{where}: {self.problems[-1].found} is not used")
            del self.problems[before:]
            return row
        self.found[row.signal.name] = (entry,)
        links = self.outputs if row.role == "outputs" else self.inputs
        variables = [v for v in offered if v.name in entry.variables]
        note = decision(row.signal, variables, links[-1])
        told = remark(self.name, row.signal, row.role, entry.variables, note) if note else ""
        self.remarks += [told] if told else []
        return replace(row, theirs=listed(entry.variables), note=note, remark=told)

    def _constant(self, signal: Variable, role: str, amount: Amount) -> None:
        key = f"{self.mapping.where}: {signal.name}.constant"
        if role == "inputs":
            self.problems.append(Problem(key, "a constant for a signal that the FMU reads", "{ unused = true }"))
            return
        q = signal.quantity
        value: Any = amount.value
        if q.type.is_float and isinstance(value, int | float):
            unit = self.relations.unit_of.get(signal.name, q.unit)
            value = self.relations.amount(key, amount, unit)
        if value is None:
            return
        value = value if isinstance(value, list) else np.full(signal.shape, value).tolist()  # type: ignore[unknown]
        if problems := q.problems(key, value):
            self.problems += problems
        else:
            self.constants[signal.name] = value

    def _needed(self, signal: Variable, role: str) -> bool:
        """Whether the socket cannot do without: all required outputs, and what moves a plant."""
        if role == "outputs":
            return signal.name in {s.name for s in self.socket.required()}
        return self.socket.bus(signal.name).must_read is Reading.EVERYTHING

    def _missing(self) -> None:
        """What the socket asks for and nothing stands for, as one problem; what the file leaves open as another."""
        given = self.mapping.signals
        left_open = [name for name, entries in given.items() if any(e.missing for e in entries)]
        if left_open:
            found = f"nothing filled in yet for {', '.join(left_open)}"
            self.problems.append(Problem(self.mapping.where, found, f"a variable for each among {offer(self.theirs)}"))
        unread: list[Row] = []
        for bus in self.socket.inputs:
            rows = [r for r in self.rows if r.role == "inputs" and r.signal.name.startswith(f"{bus}.")]
            if any(r.theirs for r in rows):
                continue
            if self.socket.bus(bus).must_read is Reading.SOMETHING:
                unread += rows
            elif self.socket.bus(bus).must_read is Reading.DESIRED:
                self.remarks.append(f"{self.name}: {self.file} does not see the {bus}")
        wanted = [r for r in self.rows if r.needed or r in unread]
        missing = [r for r in wanted if not (r.theirs or r.signal.name in given or r.misfit)]
        if missing:
            what = ", ".join(
                f"{r.signal.name} ({describe(r.signal.quantity)}{f'; {r.note}' if r.note else ''})" for r in missing
            )
            command = f"`macrostep check {self.path} --socket {self.socket.name} --out FILE.toml`"
            remedy = f"{command} writes a mapping to fill in."
            valid = f"a variable for each among {offer(self.theirs)}"
            self.problems.append(Problem(f"{self.name}: {self.file}", f"no variable for {what}", valid, remedy))

    def _number_slots(self) -> None:
        """Number the elements of the arrays that the socket's description says may be numbered."""
        for bus in self.socket.outputs:
            numbered = self.socket.bus(bus).numbered
            if numbered is not None:
                self._number(*(f"{bus}.{leaf}" for leaf in numbered))

    def _number(self, signal: str, counted: str) -> None:
        """Give the elements of `signal` the numbers 1, 2, ..., as many as `counted` has; the others are 0."""
        row = next((r for r in self.rows if r.signal.name == signal and r.role == "outputs"), None)
        others = next((link for link in self.outputs if link.signal == counted), None)
        if row is None or others is None or row.theirs or row.note or signal in self.found:
            return
        numbers = [i + 1 if i < len(others.theirs) else 0 for i in range(row.signal.size)]
        self.constants[signal] = numbers
        self.found[signal] = (Entry(constant=Amount(numbers)),)
        self.remarks.append(f"{self.name}.{signal}: not shown by {self.file}, numbered from 1")
        self.rows[self.rows.index(row)] = replace(row, theirs="1, 2, ...", note="numbered")

    def _held(self, driven: set[str]) -> dict[str, Any]:
        """Values for inputs of the FMU that no signal drives."""
        known = {v.name: v for v in self.theirs.inputs}
        held: dict[str, Any] = {}
        for name, amount in self.mapping.constants.items():
            key = f"{self.mapping.where}: constants.{name}"
            if name not in known:
                self.problems.append(Problem(key, "an unknown input", choices(known), did_you_mean(name, known)))
            elif name in driven:
                self.problems.append(Problem(key, "a constant for an input that a signal drives", "one of the two"))
            else:
                held[name] = self._in_unit(key, amount, known[name])
        return held

    def _in_unit(self, key: str, amount: Amount, variable: Variable) -> Any:
        value: Any = amount.value
        q = variable.quantity
        if q.type.is_float and isinstance(value, int | float) and q.unit not in {"", amount.unit}:
            value = self.relations.amount(key, amount, q.unit)
        if value is not None:
            self.problems += q.problems(key, value)
        return value

    def _driven(self) -> set[str]:
        """Inputs of the FMU that signals drive, each of their elements once."""
        places = [*(p for link in self.inputs for p in link.theirs), *(p for r in self.rates for p in r.rate.theirs)]
        for place in dict.fromkeys(p for p in places if places.count(p) > 1):
            self.problems.append(Problem(f"{self.name}: {place[0]} of {self.file}", "two signals that drive it", "one"))
        return {name for name, _ in places}

    def _passed_on(self) -> tuple[str, ...]:
        """Outputs that stand for no signal keep their own names, unless a signal of the socket has it."""
        used = {name for link in self.outputs for name, _ in link.theirs}
        known = {s.name for s in self.socket.signals("outputs")}
        return tuple(v.name for v in self.theirs.outputs if v.name not in used | known)

    def _signals_with_lengths(self) -> Iterator[Variable]:
        """Signals of the socket, open lengths as the FMU has them."""
        lengths = {link.signal: len(link.theirs) for link in (*self.inputs, *self.outputs)}
        for signal in self.socket.signals():
            length = lengths.get(signal.name, ANY_LENGTH) if ANY_LENGTH in signal.shape else None
            shape = signal.quantity.shape if length is None else (length,)
            yield Variable(signal.name, replace(signal.quantity, shape=shape))
