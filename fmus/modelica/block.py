"""A Modelica model as a block, which is built, checked and run as every other block is."""
# pyright: basic
# CasADi carries no types, and the records of a model are made while it is read.

from __future__ import annotations

import dataclasses
import keyword
import re
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import casadi as ca
import numpy as np
from typing_extensions import override

from components.interfaces.block import Block, Continuous, block
from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable, pack, record, unpack
from components.interfaces.socket import Socket
from components.interfaces.sockets import SOCKETS
from components.interfaces.units_of_measurement import base_unit
from fmus.modelica.explicit import ExplicitModel, explicit
from fmus.modelica.expressions import Expressions
from fmus.modelica.flat import FlatModel, FlatVariable, Tree, read
from fmus.toolchain.door import reading


class _AnyNames(Socket):
    """A socket without buses, which any inputs and outputs fit."""

    @override
    def problems(self, unit: str, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> list[Problem]:
        return []


OWN_NAMES: Final = _AnyNames("names of its own", {}, {})
"""Stands for the socket of a model that fits none by its names; its FMU fills one behind a mapping."""


@dataclass(frozen=True)
class ModelicaBlock:
    """A block made of a Modelica model, with the values that the model gives its parameters."""

    block: type[Block[Any, Any, Any]]
    start: Mapping[str, Any]


def modelica_block(path: Path, model: str | None = None, socket: str | None = None) -> ModelicaBlock:
    """The block of a Modelica model.

    The block's name is the model's full name with underscores. It is integrated as all continuous blocks are.

    Args:
        path: The file.
        model: The model's name; None for the only model of the file.
        socket: The name of the socket that the block is for; None for the first that it fits.

    Returns:
        The block of that socket; one of `OWN_NAMES` where names, types or units of measurement are not the socket's.

    Raises:
        RequestError: The model has what a block cannot express.
    """
    with reading(str(path), "a model that a block can express"):
        return _of_flat(read(path, model), socket)


def _of_flat(flat: FlatModel, socket: str | None) -> ModelicaBlock:
    solved = explicit(flat)
    raise_if_any(dict.fromkeys(_problems(solved)))  # an output may be a state too
    parameters, states = ([_variable(v, _own(v)) for v in group] for group in (solved.parameters, solved.states))
    inputs, outputs = ([_variable(v, v.name) for v in group] for group in (solved.inputs, solved.outputs))
    asked = [SOCKETS[socket]] if socket else SOCKETS.values()
    chosen = next((s for s in asked if not s.problems("", inputs, outputs)), OWN_NAMES)
    cls = _block(flat, solved, chosen, (inputs, states, outputs), parameters)
    start = {_own(v): _number(v, v.binding) for v in solved.parameters if v.binding is not None}
    return ModelicaBlock(cls, start)


def _problems(solved: ExplicitModel) -> Iterator[Problem]:
    """Units of measurement that nobody knows, and names that the variables of a block cannot have."""
    parameters = [(v, _own(v)) for v in solved.parameters]
    states = [(v, _own(v)) for v in solved.states]
    signals = [(v, v.name) for v in (*solved.inputs, *solved.outputs)]
    for v, _ in (*parameters, *states, *signals):
        if v.unit and base_unit(v.unit) is None:
            yield Problem(v.place, f"`{v.name}` in `{v.unit}`", "a unit as Modelica writes it: kg, m/s2, N.m/rad")
    yield from _name_problems([*parameters, *signals])
    yield from _name_problems(states)
    yield from (_taken(v) for v, name in parameters if hasattr(Continuous, name))


def _name_problems(named: Sequence[tuple[FlatVariable, str]]) -> Iterator[Problem]:
    """The problems of variables that stand beside each other, each with its name in the block."""
    owner: dict[str, str] = {}
    for v, name in named:
        if owner.setdefault(name, v.name) != v.name:
            yield Problem(v.place, f"`{v.name}` beside `{owner[name]}`", "names that differ without dots")
        if any(keyword.iskeyword(part) or not part.isidentifier() for part in name.split(".")):
            yield _taken(v)


def _taken(v: FlatVariable) -> Problem:
    valid = "letters, digits and underscores that are no word of Python and no part of every block"
    remedy = "Write an array of each number in place of one of records." if "[" in v.name else "Rename it."
    return Problem(v.place, f"the name `{v.name}`", valid, remedy)


def _own(v: FlatVariable) -> str:
    """The name of a parameter or a state of the block, in which the dots of components become underscores."""
    return re.sub(r"\W+", "_", v.name).strip("_")


def _variable(v: FlatVariable, name: str) -> Variable:
    low, high = (None if bound is None else float(_number(v, bound, ())) for bound in (v.low, v.high))
    return Variable(name, Quantity(v.unit, v.description, v.type, v.shape, low, high))


def _number(v: FlatVariable, tree: Tree, shape: tuple[int, ...] | None = None) -> Any:
    """The value of an expression of plain numbers, as a value of the variable.

    Raises:
        RequestError: The expression has names in it.
    """
    numbers = np.asarray(ca.DM(Expressions({}, {}).value(tree, v.place)), dtype=float).ravel()
    shape = v.shape if shape is None else shape
    if shape:
        return np.resize(numbers, shape).tolist()
    return {Type.BOOLEAN: bool, Type.INT32: int}.get(v.type, float)(numbers[0])


def _block(
    flat: FlatModel,
    solved: ExplicitModel,
    socket: Socket,
    buses: tuple[list[Variable], list[Variable], list[Variable]],
    parameters: Sequence[Variable],
) -> type[Block[Any, Any, Any]]:
    """The class of the block, whose equations are the functions of the model."""
    inputs, states, outputs = (_record(f"{flat.name}_{n}", vs) for n, vs in zip(("u", "x", "y"), buses, strict=True))

    def evaluate(self: Any, x: Any, u: Any) -> tuple[Any, Any]:
        return solved.evaluate(*(_argument(part) for part in (x, u, self)))

    def start(self: Any) -> Any:
        return unpack(states, _result(solved.start(_argument(self))))

    def derivative(self: Any, x: Any, u: Any) -> Any:
        return unpack(states, _result(evaluate(self, x, u)[0]))

    def output(self: Any, x: Any, u: Any) -> Any:
        return unpack(outputs, _result(evaluate(self, x, u)[1]))

    name = flat.name.replace(".", "_")
    body = {
        "__doc__": f"{flat.summary}\n\nMade of the Modelica model {flat.name}.",
        "__module__": __name__,
        "definition": flat.definition,
        "start": start,
        "derivative": derivative,
        "output": output,
        **_fields(parameters),
    }
    cls: Any = types.new_class(name, (Continuous[inputs, states, outputs],), {}, lambda n: n.update(body))
    cls = block(socket)(cls)
    cls.name = name
    return cls


def _argument(value: Any) -> Any:
    """A record as a column, which may be empty."""
    column = pack(value)
    return ca.DM(column) if isinstance(column, np.ndarray) else column


def _result(column: Any) -> Any:
    return np.asarray(column, dtype=float).ravel() if isinstance(column, ca.DM) else column


def _record(name: str, variables: Sequence[Variable]) -> Any:
    """A record class with these variables, in which dots in names make nested records."""
    body = {"__doc__": name, "__module__": __name__, **_fields(variables)}
    return record(type(name.replace(".", "_"), (), body))


def _fields(variables: Sequence[Variable]) -> dict[str, Any]:
    """The fields of a class, with their annotations."""
    fields: dict[str, Any] = {}
    annotations: dict[str, Any] = {}
    groups: dict[str, list[Variable]] = {}
    for v in variables:
        first, _, rest = v.name.partition(".")
        groups.setdefault(first, []).append(Variable(rest, v.quantity))
    for name, members in groups.items():
        if members[0].name:
            annotations[name] = _record(name, members)
        else:
            annotations[name] = float
            fields[name] = dataclasses.field(metadata={"quantity": members[0].quantity})
    return {**fields, "__annotations__": annotations}
