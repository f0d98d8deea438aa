"""The fit of a foreign FMU to a socket, by its mapping file and by names that leave no doubt."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from components.interfaces.problem import Problem
from components.interfaces.record import Variable
from components.interfaces.socket import ANY_LENGTH, Reading, Socket, describe
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link, RateInput
from orchestrator.mapping.adapted_interface import adapted, is_plain, is_same
from orchestrator.mapping.constants import held_inputs, signal_constant
from orchestrator.mapping.fitting_result import Direction, FittedSignal, Fitting, Remark
from orchestrator.mapping.mapping_file import Amount, Entry, MappingFile
from orchestrator.mapping.matching import match
from orchestrator.mapping.relations import EntryRelation, conventions
from orchestrator.mapping.roles import ROLES
from orchestrator.mapping.words import decision, decision_remark, listed, offer


def fit(name: str, socket: Socket, theirs: Interface, file: str, mapping: MappingFile | None = None) -> Fitting:
    """Fit an FMU to a socket.

    Args:
        name: The unit's name, for messages.
        socket: The socket that it is to fill.
        theirs: The interface of the FMU.
        file: The FMU's path, for messages.
        mapping: The mapping of the FMU; for signals without an entry, the names decide.
    """
    return _Fit(name, socket, theirs, file, mapping or MappingFile(name)).done()


@dataclass
class _Fit:
    """One FMU while it is fitted to a socket."""

    name: str
    socket: Socket
    theirs: Interface
    path: str
    mapping: MappingFile
    problems: list[Problem] = field(default_factory=list[Problem])
    noticed: list[Remark] = field(default_factory=list[Remark])
    rows: list[FittedSignal] = field(default_factory=list[FittedSignal])
    inputs: list[Link] = field(default_factory=list[Link])
    outputs: list[Link] = field(default_factory=list[Link])
    rates: list[RateInput] = field(default_factory=list[RateInput])
    integrated: list[str] = field(default_factory=list[str])
    constants: dict[str, Any] = field(default_factory=dict[str, Any])
    entries: dict[str, tuple[Entry, ...]] = field(default_factory=dict[str, tuple[Entry, ...]])
    """The entries by signal: those of the mapping file, and those that the names decided."""

    @property
    def file(self) -> str:
        """The FMU's name, for messages."""
        return Path(self.path).name

    def done(self) -> Fitting:
        self._fit_signals("inputs")
        self._fit_signals("outputs")
        self._number_slots()
        self._tell_left_open()
        self._tell_missing()
        driven = self._driven()
        held = held_inputs(self.theirs, driven, self.mapping, self.problems)
        if free := [v.name for v in self.theirs.inputs if v.name not in {*driven, *held}]:
            self._notice(f"{self.name}: nothing drives {listed(free)} of {self.file}; start values are kept")
        buses = {bus: tuple(conventions(bus, self.mapping, self.problems)) for bus in self.socket.buses}
        adaptation = Adaptation(
            tuple(self.inputs),
            tuple(self.outputs),
            self.constants,
            held,
            {bus: steps for bus, steps in buses.items() if steps},
            tuple(self.rates),
            tuple(self.integrated),
            self._passed_on(),
        )
        signals = {s.name: s for s in self._signals_with_lengths()}
        feedthrough = self.mapping.feedthrough
        interface, assumed = adapted(self.theirs, self.socket, signals, adaptation, feedthrough=feedthrough)
        for text in assumed:
            self._notice(f"{self.name}: {self.file} {text}")
        entries = {s.name: self.entries[s.name] for s in self.socket.signals() if s.name in self.entries}
        return Fitting(
            replace(self.mapping, socket=self.socket.name, signals=entries),
            adaptation,
            interface,
            tuple(self.rows),
            tuple(dict.fromkeys(self.problems)),
            tuple(self.noticed),
            needed=not is_same(self.theirs, interface, adaptation),
            plain=is_plain(self.theirs, interface, adaptation),
        )

    def _notice(self, text: str) -> None:
        self.noticed.append(Remark(text))

    def _fit_signals(self, direction: Direction) -> None:
        """Find what stands for all signals of one direction; what the file names is taken first."""
        signals = self.socket.signals(direction)
        offered: tuple[Variable, ...] = getattr(self.theirs, direction)
        given = self.mapping.signals
        named = {s.name: self._named(s, direction, given[s.name], offered) for s in signals if s.name in given}
        links = [*(self.inputs if direction == "inputs" else self.outputs), *(r.rate for r in self.rates)]
        taken = {name for link in links for name, _ in link.theirs}
        free = [v for v in offered if v.name not in taken]
        matches, doubtful = match(self.socket, [s for s in signals if s.name not in named], free)
        for signal in signals:
            if signal.name in named:
                self.rows.append(named[signal.name])
                continue
            several = tuple(doubtful.get(signal.name, ()))
            note = f"could be {', '.join(f'`{n}`' for n in several)}" if several else ""
            row = FittedSignal(signal, direction, self._is_needed(signal, direction), note=note, doubtful=several)
            matched = matches.get(signal.name)
            self.rows.append(self._matched(row, Entry(variables=matched.names), offered) if matched else row)

    def _named(
        self, signal: Variable, direction: Direction, entries: Sequence[Entry], offered: Sequence[Variable]
    ) -> FittedSignal:
        """A signal that the mapping file has entries for."""
        where = f"{self.mapping.where}: {signal.name}"
        needed = self._is_needed(signal, direction)
        texts: list[str] = []
        for entry in entries:
            if entry.constant is not None:
                unit = "" if entry.constant.unit == "1" else f" {entry.constant.unit}"
                texts.append(f"{entry.constant.value}{unit}")
                self._set_constant(signal, direction, entry.constant)
            elif entry.unused:
                texts.append("unused")
                if direction == "outputs" and needed:
                    valid = f"a variable or a constant: the socket `{self.socket.name}` asks for it"
                    self.problems.append(Problem(where, "unused", valid))
            elif not entry.missing:
                texts.append(listed(entry.variables))
                relation = EntryRelation(where, signal, entry, self.socket, self.mapping)
                self._link(relation, direction, offered)
                self.problems += relation.problems
        self.entries[signal.name] = tuple(entries)
        return FittedSignal(signal, direction, needed, "; ".join(texts))

    def _matched(self, row: FittedSignal, entry: Entry, offered: Sequence[Variable]) -> FittedSignal:
        """A signal whose variable has a name that leaves no doubt."""
        where = f"{self.name}.{row.signal.name}"
        relation = EntryRelation(where, row.signal, entry, self.socket, self.mapping)
        link = self._link(relation, row.direction, offered)
        if link is None:
            misfit = relation.problems[-1].found
            if row.needed:
                self.problems += relation.problems
                return replace(row, note=f"{misfit} does not fit", misfit=True)
            self._notice(f"{where}: {misfit} is not used")
            return row
        self.entries[row.signal.name] = (entry,)
        note = decision(row.signal, [v for v in offered if v.name in entry.variables], link)
        if note:
            self.noticed.append(decision_remark(self.name, row, entry.variables, note))
        return replace(row, theirs=listed(entry.variables), note=note)

    def _link(self, relation: EntryRelation, direction: Direction, offered: Sequence[Variable]) -> Link | None:
        """Link a signal by an entry; `None` where the entry is wrong, as the problems of `relation` say."""
        link = relation.link(offered)
        if link is None:
            return None
        role = ROLES.get(relation.entry.role or "")
        is_rate = role is not None and role.is_rate
        if direction == "outputs":
            self.outputs.append(link)
            self.integrated += [link.signal] if is_rate else []
        elif is_rate:
            rate_input = relation.rate_input(link, self.theirs.outputs)
            self.rates += [rate_input] if rate_input else []
        else:
            self.inputs.append(link)
        return link

    def _set_constant(self, signal: Variable, direction: Direction, amount: Amount) -> None:
        if direction == "inputs":
            key = f"{self.mapping.where}: {signal.name}.constant"
            self.problems.append(Problem(key, "a constant for a signal that the FMU reads", "{ unused = true }"))
            return
        value = signal_constant(signal, amount, self.mapping, self.problems)
        if value is not None:
            self.constants[signal.name] = value

    def _is_needed(self, signal: Variable, direction: Direction) -> bool:
        """Whether the socket cannot do without: all required outputs, and inputs of which everything must be read."""
        if direction == "outputs":
            return signal.name in {s.name for s in self.socket.required()}
        return self.socket.bus(signal.name).must_read is Reading.EVERYTHING

    def _tell_left_open(self) -> None:
        """Report what the mapping file leaves to be filled in, as one problem."""
        names = [name for name, entries in self.mapping.signals.items() if any(e.missing for e in entries)]
        if names:
            valid = f"a variable for each among {offer(self.theirs)}"
            self.problems.append(Problem(self.mapping.where, f"nothing filled in yet for {', '.join(names)}", valid))

    def _tell_missing(self) -> None:
        """Report the signals that the socket requires and that nothing stands for, as one problem."""
        unread = self._unread()
        required = [r for r in self.rows if r.needed or r in unread]
        missing = [r for r in required if not (r.theirs or r.signal.name in self.mapping.signals or r.misfit)]
        if missing:
            what = ", ".join(
                f"{r.signal.name} ({describe(r.signal.quantity)}{f'; {r.note}' if r.note else ''})" for r in missing
            )
            command = f"`macrostep check {shlex.quote(self.path)} --socket {self.socket.name} --out FILE.toml`"
            remedy = f"{command} writes a mapping to fill in."
            valid = f"a variable for each among {offer(self.theirs)}"
            self.problems.append(Problem(f"{self.name}: {self.file}", f"no variable for {what}", valid, remedy))

    def _unread(self) -> list[FittedSignal]:
        """The signals of input buses of which the FMU reads nothing, though the socket asks for something."""
        unread: list[FittedSignal] = []
        for bus in self.socket.inputs:
            rows = [r for r in self.rows if r.direction == "inputs" and r.signal.name.startswith(f"{bus}.")]
            if any(r.theirs for r in rows):
                continue
            if self.socket.bus(bus).must_read is Reading.SOMETHING:
                unread += rows
            elif self.socket.bus(bus).must_read is Reading.DESIRED:
                self._notice(f"{self.name}: {self.file} does not see the {bus}")
        return unread

    def _number_slots(self) -> None:
        """Number the elements of the arrays that the socket's description says may be numbered."""
        for bus in self.socket.outputs:
            numbered = self.socket.bus(bus).numbered
            if numbered is not None:
                self._number(*(f"{bus}.{leaf}" for leaf in numbered))

    def _number(self, signal: str, counted: str) -> None:
        """Give the elements of `signal` the numbers 1, 2, ..., as many as `counted` has; the others are 0."""
        row = next((r for r in self.rows if r.signal.name == signal and r.direction == "outputs"), None)
        others = next((link for link in self.outputs if link.signal == counted), None)
        if row is None or others is None or row.theirs or row.doubtful or row.misfit or signal in self.entries:
            return
        numbers = [i + 1 if i < len(others.theirs) else 0 for i in range(row.signal.size)]
        self.constants[signal] = numbers
        self.entries[signal] = (Entry(constant=Amount(numbers)),)
        self._notice(f"{self.name}.{signal}: not shown by {self.file}, numbered from 1")
        self.rows[self.rows.index(row)] = replace(row, theirs="1, 2, ...", note="numbered")

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
