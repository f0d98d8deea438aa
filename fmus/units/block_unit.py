"""A block as a unit in this process: its equations evaluated by CasADi, without a compiler."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from typing_extensions import override

from components.interfaces.block import Block
from components.interfaces.quantity import Type
from components.interfaces.record import Variable, pack, size
from fmus.lowering import LoweredBlock, lower
from fmus.unit_interface import Interface
from fmus.units.unit import Column, Operation, Unit, UnitError, positions


@lru_cache
def interface_of(kind: type[Block[Any, Any, Any]]) -> Interface:
    """What a block looks like from outside."""
    lowered = lower(kind)
    return Interface(
        kind=kind.name,
        inputs=kind.inputs(),
        outputs=kind.outputs(),
        parameters=kind.parameters(),
        feedthrough=by_variable(lowered, kind.outputs(), kind.inputs()),
        output_after_set=not lowered.sampled,
        starts={},
        rolls_back=True,
    )


def by_variable(lowered: LoweredBlock, outputs: tuple[Variable, ...], inputs: tuple[Variable, ...]) -> Any:
    """The feedthrough of whole variables: true where any element of an input reaches any element of an output."""
    if not (outputs and inputs):
        return np.zeros((len(outputs), len(inputs)), dtype=bool)
    rows = np.cumsum([0, *(v.size for v in outputs[:-1])])
    columns = np.cumsum([0, *(v.size for v in inputs[:-1])])
    return np.logical_or.reduceat(np.logical_or.reduceat(lowered.feedthrough, rows, axis=0), columns, axis=1)


class BlockUnit(Unit):
    """A block that runs here. Raises `RequestError` when parameter values are missing or out of range."""

    def __init__(self, name: str, kind: type[Block[Any, Any, Any]]) -> None:
        super().__init__(name, interface_of(kind))
        self._kind = kind
        self._lowered = lower(kind)
        dims = kind.dimensions()
        self._p = np.zeros(size(kind, dims))
        self._x = np.zeros(size(kind.state_type, dims))
        self._next = np.zeros_like(self._x)
        self._u = np.zeros(size(kind.input_type, dims))
        self._y = np.zeros(size(kind.output_type, dims))
        self._h = np.zeros(1)
        self._evaluate_output = _evaluation(self._lowered.output, [self._x, self._u, self._p], [self._y])
        results = [self._next, self._y][: self._lowered.step.n_out()]
        self._evaluate_step = _evaluation(self._lowered.step, [self._x, self._u, self._p, self._h], results)
        self._held = False  # a sampled block's outputs stand until its next sample
        self._set_copies: list[tuple[Column, Column]] = []
        self._get_copies: list[tuple[Column, Column]] = []

    @override
    def bind(self, inputs: Mapping[Type, Column], outputs: Mapping[Type, Column]) -> None:
        self._set_copies = [(mine, theirs) for mine, theirs in _pairs(self._kind.inputs(), self._u, inputs)]
        self._get_copies = [(theirs, mine) for mine, theirs in _pairs(self._kind.outputs(), self._y, outputs)]

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        self._p[:] = pack(self._kind(**parameters))
        start = _evaluation(self._lowered.start, [self._p], [self._x])
        start()
        self._held = False

    @override
    def exit_initialization(self) -> None:
        if not np.isfinite(self._x).all():
            raise UnitError(self.name, "its initial state is not finite", self.messages)

    @override
    def setters(self) -> list[Operation]:
        return [self._set]

    @override
    def getters(self) -> list[Operation]:
        return [self._get]

    def _set(self) -> None:
        for mine, theirs in self._set_copies:
            mine[:] = theirs

    def _get(self) -> None:
        if not self._held:
            self._evaluate_output()
        for theirs, mine in self._get_copies:
            theirs[:] = mine

    @override
    def step(self, t: float, h: float) -> None:
        parts = 1 if self._lowered.sampled else substeps(h, self._kind.max_step)
        self._h[0] = h / parts
        for _ in range(parts):
            self._evaluate_step()
            self._x[:] = self._next
        self._held = self._lowered.sampled

    @override
    def save(self) -> Any:
        return self._x.copy(), self._y.copy(), self._held

    @override
    def restore(self, state: Any) -> None:
        self._x[:], self._y[:], self._held = state

    @override
    def close(self) -> None:
        """Nothing to release."""


def substeps(h: float, max_step: float) -> int:
    """Into how many equal parts a macro step is divided; the C runtime does the same."""
    return max(1, int(np.ceil(h / max_step - 1e-9)))


def _evaluation(function: Any, arguments: list[Column], results: list[Column]) -> Operation:
    buffer, evaluate = function.buffer()
    for i, column in enumerate(arguments):
        if column.size:
            buffer.set_arg(i, memoryview(column.data))
    for i, column in enumerate(results):
        if column.size:
            buffer.set_res(i, memoryview(column.data))

    def call(_alive: Any = buffer) -> None:  # `evaluate` holds a bare address: the buffer has to live as long
        evaluate()

    return call


def _pairs(
    variables: tuple[Variable, ...], flat: Column, columns: Mapping[Type, Column]
) -> list[tuple[Column, Column]]:
    """Views of `flat` beside the views of the typed columns with the same elements, joined where neighbours stay so."""
    places = positions(variables)
    runs: list[tuple[Type, int, int, int]] = []
    at = 0
    for variable in variables:
        kind, there = places[variable.name]
        if runs and runs[-1][0] == kind and runs[-1][1] + runs[-1][3] == at and runs[-1][2] + runs[-1][3] == there:
            kind, start, first, n = runs.pop()
            runs.append((kind, start, first, n + variable.size))
        else:
            runs.append((kind, at, there, variable.size))
        at += variable.size
    return [(flat[a : a + n], columns[kind][b : b + n]) for kind, a, b, n in runs]
