"""The other side of `IsolatedUnit`: one FMU in a process of its own, which does what it is asked, one thing at a time.

Numbers lie in memory that both processes see; requests and answers go through a pipe, and with them texts and bytes.
"""

from __future__ import annotations

import itertools
import mmap
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from components.interfaces.problem import Problem, RequestError
from components.interfaces.quantity import DTYPES, Type, zeros
from fmus.reading.opening import open_fmu
from fmus.unit_interface import Interface
from fmus.units.make import fmu_unit
from fmus.units.unit import FMI_WARNING, Column, Unit, UnitError, carry_out, widths

ALIGNMENT = 8


@dataclass(frozen=True)
class Request:
    """One call of a method of the unit."""

    method: str
    arguments: tuple[Any, ...] = ()
    take: bool = False
    """Whether the inputs have changed and are to be taken in first"""
    show: bool = False
    """Whether the outputs are to be shown after it"""
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    """The inputs that are texts or bytes, type by type"""


@dataclass(frozen=True)
class Answer:
    """What came of it."""

    value: Any = None
    messages: tuple[str, ...] = ()
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    problems: tuple[Problem, ...] = ()
    """Those of a wrong request"""
    fault: tuple[str, tuple[str, ...]] | None = None
    """The action and the words of a `UnitError`"""


def size(interface: Interface) -> int:
    """Bytes of memory that both sides see."""
    return ALIGNMENT + sum(_bytes(k, n) for role in _roles(interface) for k, n in role.items() if k.is_number)


def columns(interface: Interface, memory: mmap.mmap) -> list[dict[Type, Column]]:
    """The columns of all inputs and of all outputs; numbers lie in `memory`."""
    found: list[dict[Type, Column]] = []
    at = 0
    for role in _roles(interface):
        found.append({})
        for kind, n in role.items():
            if kind.is_number:
                found[-1][kind] = np.frombuffer(memory, DTYPES[kind], n, at)
                at += _bytes(kind, n)
            else:
                found[-1][kind] = zeros(kind, n)
    return found


def texts(role: Mapping[Type, Column]) -> list[list[Any]]:
    """The values of a role that are no numbers."""
    return [column.tolist() for kind, column in role.items() if not kind.is_number]


def put_texts(role: Mapping[Type, Column], values: list[list[Any]]) -> None:
    """The opposite of `texts`."""
    for column, found in zip([c for kind, c in role.items() if not kind.is_number], values, strict=False):
        column[:] = found


def _roles(interface: Interface) -> list[dict[Type, int]]:
    return [widths(interface.inputs), widths(interface.outputs)]


def _bytes(kind: Type, n: int) -> int:
    return -(-n * np.dtype(DTYPES[kind]).itemsize // ALIGNMENT) * ALIGNMENT


class _Host:
    """The unit, and what has been saved of it."""

    def __init__(self, pipe: Connection, descriptor: int) -> None:
        self._pipe = pipe
        self._descriptor = descriptor
        self._unit: Unit | None = None
        self._saved: dict[int, Any] = {}
        self._tokens = itertools.count(1)
        self._inputs: dict[Type, Column] = {}
        self._outputs: dict[Type, Column] = {}

    def serve(self) -> None:
        """Answer until the unit is closed, or nobody asks any more."""
        while True:
            try:
                request: Request = pickle.loads(self._pipe.recv_bytes())  # noqa: S301 - from our own process
            except EOFError:
                return
            try:
                answer = self._answered(request)
            except RequestError as error:
                answer = Answer(problems=error.problems)
            except UnitError as error:
                answer = Answer(fault=(error.action, error.said))
            self._pipe.send_bytes(pickle.dumps(answer))
            if request.method == "close":
                return

    def _answered(self, request: Request) -> Answer:
        if self._unit is None:
            if request.method == "instantiate":
                self._instantiate(*request.arguments)
            return Answer()
        unit = self._unit
        put_texts(self._inputs, request.texts)
        status = carry_out(unit.setters()) if request.take else 0
        value = None if status > FMI_WARNING else self._called(unit, request)
        if request.show and status <= FMI_WARNING:
            status = carry_out(unit.getters())
        if status > FMI_WARNING and not value:
            value = status
        messages = tuple(unit.messages)
        unit.messages.clear()
        return Answer(value, messages, texts(self._outputs))

    def _instantiate(self, name: str, path: Path, parameters: Mapping[str, Any], lenient: bool) -> None:  # noqa: FBT001
        self._unit = fmu_unit(name, open_fmu(path, parameters, lenient=lenient))
        interface = self._unit.interface
        memory = mmap.mmap(self._descriptor, size(interface))
        self._inputs, self._outputs = columns(interface, memory)

    def _called(self, unit: Unit, request: Request) -> Any:
        if request.method == "bind":
            unit.bind(self._inputs, self._outputs)
            return None
        if request.method == "save":
            token = next(self._tokens)
            self._saved[token] = unit.save()
            return token
        if request.method == "restore":
            return unit.restore(self._saved[request.arguments[0]])
        if request.method == "forget":
            return unit.forget(self._saved.pop(request.arguments[0]))
        if request.method == "get":  # all that is wanted is what is shown
            return None
        call: Callable[..., Any] = getattr(unit, request.method)
        return call(*request.arguments)


def serve(pipe: int, descriptor: int) -> None:
    """Answer what comes through the pipe until the unit is closed."""
    _Host(Connection(pipe), descriptor).serve()
