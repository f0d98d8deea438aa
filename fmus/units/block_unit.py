"""A block as a unit in this process: its equations evaluated by CasADi, without a compiler."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from typing_extensions import override

from components.interfaces.block import Block
from components.interfaces.quantity import Type
from components.interfaces.record import Variable, pack, size
from fmus.lowering import LoweredBlock, lower
from fmus.unit_interface import Interface, is_tunable
from fmus.units.capabilities import StateCapability
from fmus.units.state_bytes import array_of, joined, parted
from fmus.units.unit import DEFAULT_SETUP, Column, ExperimentSetup, Operation, TypedColumns, Unit, UnitError, positions


@lru_cache
def interface_of(block: type[Block[Any, Any, Any]]) -> Interface:
    """The interface of a block."""
    lowered = lower(block)
    return Interface(
        kind=block.name,
        inputs=block.inputs(),
        outputs=block.outputs(),
        parameters=block.parameters(),
        feedthrough=by_variable(lowered, block.outputs(), block.inputs()),
        output_after_set=not lowered.sampled,
        starts={},
        rolls_back=True,
        variability={v.name: "tunable" if is_tunable(v) else "fixed" for v in block.parameters()},
    )


def by_variable(lowered: LoweredBlock, outputs: tuple[Variable, ...], inputs: tuple[Variable, ...]) -> Any:
    """The feedthrough of whole variables: true where any element of an input reaches any element of an output.

    Args:
        lowered: The block's functions, with the feedthrough element by element.
        outputs: All outputs of the block.
        inputs: All inputs of the block.

    Returns:
        Booleans of shape (outputs, inputs).
    """
    if not (outputs and inputs):
        return np.zeros((len(outputs), len(inputs)), dtype=bool)
    rows = np.cumsum([0, *(v.size for v in outputs[:-1])])
    columns = np.cumsum([0, *(v.size for v in inputs[:-1])])
    return np.logical_or.reduceat(np.logical_or.reduceat(lowered.feedthrough, rows, axis=0), columns, axis=1)


class BlockState(StateCapability):
    """The memory of a running block, which can be copied out and in.

    Args:
        sizes: The numbers of its states, outputs, inputs and parameters.
    """

    serializes = True

    def __init__(self, *sizes: int) -> None:
        self.x, self.y, self.u, self.p = (np.zeros(n) for n in sizes)
        self.held = False
        """Whether the outputs are held until the next sample, as those of a sampled block are after its first step."""

    @property
    def _all(self) -> tuple[Column, ...]:
        return self.x, self.y, self.u, self.p

    @override
    def save(self) -> Any:
        return [column.copy() for column in self._all], self.held

    @override
    def restore(self, state: Any) -> None:
        columns, self.held = state
        for mine, saved in zip(self._all, columns, strict=True):
            mine[:] = saved

    @override
    def forget(self, state: Any) -> None:
        """Nothing to release."""

    @override
    def serialized(self, state: Any) -> bytes:
        columns, held = state
        return joined([*(column.tobytes() for column in columns), bytes([held])])

    @override
    def deserialized(self, content: bytes) -> Any:
        *parts, held = parted(content, 5)
        columns = [array_of(part, mine) for part, mine in zip(parts, self._all, strict=True)]
        return columns, held != b"\0"


class BlockUnit(Unit):
    """A block that runs in this process.

    Args:
        name: Name of the unit.
        block: The block's class.
    """

    def __init__(self, name: str, block: type[Block[Any, Any, Any]]) -> None:
        super().__init__(name, interface_of(block))
        self._block = block
        self._lowered = lower(block)
        dims = block.dimensions()
        self._h = np.zeros(1)
        kinds = block.state_type, block.output_type, block.input_type, block
        self._memory = memory = BlockState(*(size(kind, dims) for kind in kinds))
        self._u, self._p = memory.u, memory.p
        self.state = memory
        self._next = np.zeros_like(memory.x)
        self._evaluate_output = _evaluation(self._lowered.output, [memory.x, self._u, self._p], [memory.y])
        results = [self._next, memory.y][: self._lowered.step.n_out()]
        self._evaluate_step = _evaluation(self._lowered.step, [memory.x, self._u, self._p, self._h], results)
        self._set_copies: list[tuple[Column, Column]] = []
        self._get_copies: list[tuple[Column, Column]] = []

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        del unset  # a block has no values of its own for inputs
        self._set_copies = [(mine, theirs) for mine, theirs in _pairs(self._block.inputs(), self._u, inputs)]
        self._get_copies = [(theirs, mine) for mine, theirs in _pairs(self._block.outputs(), self._memory.y, outputs)]

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        """As `Unit.enter_initialization`. Raises `RequestError` when values are missing or out of range."""
        del setup  # no block depends on time itself
        self._p[:] = pack(self._block(**parameters))
        start = _evaluation(self._lowered.start, [self._p], [self._memory.x])
        start()
        self._memory.held = False

    @override
    def tune(self, parameter: str, value: Any) -> None:
        at = 0
        for variable in self.interface.parameters:
            if variable.name == parameter:
                self._p[at : at + variable.size] = np.ravel(value)
            at += variable.size

    @override
    def exit_initialization(self) -> None:
        if not np.isfinite(self._memory.x).all():
            raise UnitError(self.name, "its initial state is not finite", self.messages)

    @override
    def reset(self) -> None:
        for column in (self._p, self._u, self._memory.x, self._memory.y):
            column[:] = 0.0
        self._memory.held = False
        self._forget_calls()

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
        if not self._memory.held:
            self._evaluate_output()
        for theirs, mine in self._get_copies:
            theirs[:] = mine

    @override
    def step(self, t: float, h: float) -> None:
        parts = 1 if self._lowered.sampled else substeps(h, self._block.max_step)
        self._h[0] = h / parts
        memory = self._memory
        for _ in range(parts):
            self._evaluate_step()
            memory.x[:] = self._next
        memory.held = self._lowered.sampled

    @override
    def terminate(self) -> None:
        """Nothing to end."""

    @override
    def close(self) -> None:
        """Nothing to release."""


def substeps(h: float, max_step: float) -> int:
    """Into how many equal parts a macro step `h` [s] is divided, none longer than `max_step` [s].

    The C runtime computes the same.
    """
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


def _pairs(variables: tuple[Variable, ...], flat: Column, columns: TypedColumns) -> list[tuple[Column, Column]]:
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
