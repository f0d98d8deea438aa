"""Values that are infinite or not a number: which of them end a run, and which are only told.

Such a value of a signal that another unit reads, or of a bus of the unit's socket, ends the run, as it would spoil what
follows: unless the signal is allowed to be so by the system, or by the file of its unit or of those that read it, which
declare a start value or a limit that is not finite. All else is recorded as it is, and told at the end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.problem import listed
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from orchestrator.stepping.signal_table import RecordedElement, SignalTable
from orchestrator.system.patterns import fits
from orchestrator.system.system import Connection, System

ALL: Final = "*"
"""The pattern that allows every signal, as files are run that break rules; what it allows is told."""
_is_finite = np.isfinite
_LISTED: Final = 12
"""The signals that a remark lists."""


class NotFinite(NamedTuple):
    """An element whose value was not finite."""

    element: RecordedElement
    value: float
    """The first value that was not finite."""
    time: float
    """[s] When that was."""


class Watched:
    """The values of one type of floating-point numbers."""

    def __init__(self, values: NDArray[Any], elements: Sequence[RecordedElement], fatal: NDArray[np.bool_]) -> None:
        self.values, self.elements, self.fatal = values, elements, fatal
        self.finite = np.ones(values.shape, dtype=np.bool_)
        self.expected = self.finite.copy()
        """What is finite, as it was when that changed last; the native stepper has its address."""
        self.usual = self.expected.tobytes()
        """The same, because bytes are compared three times faster than by `all`."""
        self.seen = np.zeros(values.shape, dtype=np.bool_)

    def begin_anew(self) -> None:
        """Forget what was not finite."""
        self.expected[:], self.seen[:] = True, False
        self.usual = self.expected.tobytes()


class Finiteness:
    """Watches all floating-point numbers that units show.

    Args:
        table: The signal table.
        times: The time of each tick [s], (ticks,).
    """

    def __init__(self, table: SignalTable, times: NDArray[np.float64]) -> None:
        self._system, self._times = table.system, times
        self._found: list[NotFinite] = []
        readers = _readers(table.system)
        allowed = _Allowed(table.system)
        self.watched: list[Watched] = []
        for kind, n in table.recorded.items():
            if kind.is_float and n:
                elements = [element for element in table.elements() if element.type is kind]
                fatal = np.array(
                    [_matters(table.system, e, readers) and not allowed.passes(e, readers) for e in elements]
                )
                self.watched.append(Watched(table.columns[kind][:n], elements, fatal))

    def begin_anew(self) -> None:
        """Forget all that was found."""
        self._found = []
        for watched in self.watched:
            watched.begin_anew()

    def go_to(self, time: float) -> None:
        """Forget what was found after a time [s]."""
        if not self._found and all(watched.expected.all() for watched in self.watched):
            return
        found = [one for one in self._found if one.time <= time]
        self.begin_anew()
        self._found = found
        known = {one.element.path for one in found}
        for watched in self.watched:
            watched.seen[:] = [element.path in known for element in watched.elements] if known else False

    def holds(self, tick: int) -> bool:
        """Whether the run may go on with the values of a tick, the present ones."""
        good = True
        for watched in self.watched:
            _is_finite(watched.values, finite := watched.finite)
            if finite.tobytes() != watched.usual and not self._is_harmless(watched, float(self._times[tick])):
                good = False
        return good

    def _is_harmless(self, watched: Watched, time: float) -> bool:
        """Note what is not finite now and never was before; return whether the run may go on with it."""
        watched.expected[:] = watched.finite
        watched.usual = watched.finite.tobytes()
        others = ~watched.finite
        for i in np.flatnonzero(others & ~watched.seen & ~watched.fatal).tolist():
            self._found.append(NotFinite(watched.elements[i], float(watched.values[i]), time))
        watched.seen |= others
        return not (others & watched.fatal).any()

    def fault(self) -> tuple[str, str]:
        """The unit whose value ends the run, and the reason in words. Raises `StopIteration` where there is none."""
        element, value = next(
            (element, float(watched.values[i]))
            for watched in self.watched
            for i, element in enumerate(watched.elements)
            if watched.fatal[i] and not np.isfinite(watched.values[i])
        )
        targets = ", ".join(f"`{wire.target}`" for wire in _readers(self._system).get(element.path, ()))
        reader = f", which {targets} would receive" if targets else ""
        reason = f"the signal `{element.path}` is {value}{reader}; --allow-nonfinite '{element.path}' lets it pass"
        return element.unit, reason

    @property
    def found(self) -> list[NotFinite]:
        """The elements that were not finite and did not end the run, each with its first such value."""
        return self._found

    def remarks(self) -> Iterator[str]:
        """What a person should know of values that were not finite, beyond what was allowed for them by name."""
        allowed = _Allowed(self._system, by_name=True)
        told = [one for one in self._found if not allowed.signal(one.element)]
        if told:
            texts = [f"`{o.element.path}` ({o.value} first at {o.time:g} s)" for o in told]
            yield f"values that are not finite: {listed(texts, _LISTED, 'others')}"


class _Allowed:
    """Which signals may be infinite or not a number.

    Args:
        system: The system.
        by_name: Whether the pattern that allows all signals is left out.
    """

    def __init__(self, system: System, *, by_name: bool = False) -> None:
        self._patterns = [p for p in system.allow_nonfinite if not (by_name and p == ALL)]
        self._declared = {
            (name, variable.name)
            for name, source in system.units.items()
            for variable in (*source.interface.recorded, *source.interface.inputs)
            if _declares(source.interface, variable)
        }

    def signal(self, element: RecordedElement) -> bool:
        """Whether an element is allowed for itself."""
        unit, _, name = element.path.partition(".")
        whole = name.rpartition("[")[0]
        return (
            (unit, name) in self._declared
            or (unit, whole) in self._declared
            or any(fits(path, p) for p in self._patterns for path in (element.path, f"{unit}.{whole}"))
        )

    def passes(self, element: RecordedElement, readers: Mapping[str, Sequence[Connection]]) -> bool:
        """Whether an element is allowed for itself, or by all inputs that it drives."""
        wires = readers.get(element.path, ())
        return self.signal(element) or (bool(wires) and all((w.unit, w.input) in self._declared for w in wires))


def _matters(system: System, element: RecordedElement, readers: Mapping[str, object]) -> bool:
    """Whether a unit reads an element, or metrics and pictures do, as they do with the buses of sockets."""
    socket = system.sockets.get(element.unit)
    bus = element.path.split(".")[1]
    return element.path in readers or (socket is not None and bus in socket.buses)


def _declares(interface: Interface, variable: Variable) -> bool:
    """Whether a file declares a start value or a limit of a variable that is not finite."""
    q = variable.quantity
    if not q.type.is_float:
        return False
    declared = [interface.starts.get(variable.name), q.min, q.max]
    return not all(np.isfinite(value).all() for value in declared if value is not None)


def _readers(system: System) -> Mapping[str, list[Connection]]:
    """The connections that each element of an output drives, by its full path."""
    readers: dict[str, list[Connection]] = {}
    for wire in system.connections:
        elements = system.variable(f"{wire.source}.{wire.output}").elements
        for name in elements if wire.output_element is None else [elements[wire.output_element.at]]:
            readers.setdefault(f"{wire.source}.{name}", []).append(wire)
    return readers
