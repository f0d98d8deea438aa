"""A flat Modelica model as explicit functions: initial state, derivatives and outputs."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from components.interfaces.problem import Problem, RequestError, raise_if_any, refuse
from fmus.modelica.expressions import Expressions, states_in
from fmus.modelica.flat import EXPLICIT, Equation, FlatModel, FlatVariable, names


@dataclass(frozen=True)
class ExplicitModel:
    """A model as functions of columns, each in the order of its variables."""

    parameters: tuple[FlatVariable, ...]
    states: tuple[FlatVariable, ...]
    inputs: tuple[FlatVariable, ...]
    outputs: tuple[FlatVariable, ...]
    start: ca.Function
    """`start(p) -> x`."""
    evaluate: ca.Function
    """`evaluate(x, u, p) -> (dx/dt, y)`."""


@dataclass(frozen=True)
class _Scalar:
    """One scalar equation."""

    left: Any
    right: Any
    place: str

    @property
    def symbols(self) -> set[int]:
        """The hashes of the symbols in it."""
        return {s.element_hash() for s in ca.symvar(ca.vertcat(self.left, self.right))}


SymbolValues = list[tuple[Any, Any]]
"""Symbols and their values, each in terms of known symbols and of the symbols before it."""


class _Model:
    """A symbol for every element of every variable and derivative, and the equations between them."""

    def __init__(self, flat: FlatModel) -> None:
        self.flat = flat
        named = set().union(*(states_in(side) for e in flat.equations for side in (e.left, e.right)))
        self.states = [v for v in flat.variables.values() if v.name in named]
        self.columns: dict[str, Any] = {}
        self.derivatives = {v.name: _symbols(f"der({v.name})", v.shape) for v in self.states}
        self.expressions = Expressions(self.columns, self.derivatives)
        for v in flat.variables.values():
            if v.role != "dependent":
                self.columns[v.name] = _symbols(v.name, v.shape)
        self._dependents()

    def of(self, *roles: str) -> list[FlatVariable]:
        """The variables that have one of some roles, in the order of the model."""
        return [v for v in self.flat.variables.values() if v.role in roles]

    def column(self, variables: Iterable[FlatVariable]) -> Any:
        """The columns of some variables, one below the other; also for none."""
        return ca.vertcat(ca.SX(0, 1), *(self.columns[v.name] for v in variables))

    def _dependents(self) -> None:
        """Evaluate constants, and parameters that others determine, whatever their order in the model is."""
        waiting = self.of("dependent")
        while waiting:
            ready = [v for v in waiting if v.binding is not None and not names(v.binding) & {w.name for w in waiting}]
            if not ready:
                valid = "a value, from parameters and constants"
                raise_if_any(Problem(v.place, f"no value for `{v.name}`", valid) for v in waiting)
            for v in ready:
                value = self.expressions.value(v.binding or {}, v.place)
                self.columns[v.name] = _repeated(value, v.shape[0] if v.shape else 1)
            waiting = [v for v in waiting if v not in ready]

    def scalars(self, equations: Sequence[Equation]) -> list[_Scalar]:
        """All equations, element by element.

        Raises:
            RequestError: Expressions are not supported; the error has all of them.
        """
        scalars: list[_Scalar] = []
        problems: list[Problem] = []
        for e in equations:
            try:
                left, right = self.expressions.value(e.left, e.place), self.expressions.value(e.right, e.place)
            except RequestError as error:
                problems += error.problems
                continue
            n = max(left.numel(), right.numel())
            sides = (ca.vertsplit(_repeated(side, n)) for side in (left, right))
            scalars += [_Scalar(a, b, e.place) for a, b in zip(*sides, strict=True)]
        raise_if_any(problems)
        return scalars


def explicit(flat: FlatModel) -> ExplicitModel:
    """Solve a model's equations one after the other.

    Raises:
        RequestError: The equations cannot be solved in this way, or are not supported.
    """
    model = _Model(flat)
    p, u = model.of("parameter"), model.of("input")
    y = model.of("output")
    named = {v.name for v in model.states}
    unknown = [v for v in model.of("output", "local") if v.name not in named]
    rates = ca.vertcat(ca.SX(0, 1), *model.derivatives.values())
    solved = _solved(model.scalars(flat.equations), ca.vertcat(rates, model.column(unknown)), flat.place)
    x, inputs, given = model.column(model.states), model.column(u), model.column(p)
    dx, outputs = _inserted(solved, [rates, model.column(y)])
    return ExplicitModel(
        parameters=tuple(p),
        states=tuple(model.states),
        inputs=tuple(u),
        outputs=tuple(y),
        start=ca.Function("start", [given], [_start(model, solved)]),
        evaluate=ca.Function("evaluate", [x, inputs, given], [dx, outputs]),
    )


def _start(model: _Model, solved: SymbolValues) -> Any:
    """The initial state: the solution of the initial equations, and start values where these leave it open."""
    free: list[Any] = []
    begin: SymbolValues = []
    for v in model.states:
        value = model.expressions.value(v.start, v.place) if v.start is not None else ca.SX(0.0)
        symbols = ca.vertsplit(model.columns[v.name])
        begin += zip(symbols, ca.vertsplit(_repeated(value, len(symbols))), strict=True)
        free += [] if v.fixed else symbols
    equations: list[_Scalar] = []
    for e in model.scalars(model.flat.initial):
        left, right = _inserted(solved, [e.left, e.right])
        equations.append(_Scalar(left, right, e.place))
    given = _solved(equations, ca.vertcat(ca.SX(0, 1), *free), model.flat.place, complete=False)
    taken = {symbol.element_hash() for symbol, _ in given}
    (x,) = _inserted([*(b for b in begin if b[0].element_hash() not in taken), *given], [model.column(model.states)])
    allowed = {s.element_hash() for s in ca.symvar(model.column(model.of("parameter")))}
    wrong = [s.name() for s in ca.symvar(x) if s.element_hash() not in allowed]
    if wrong:
        valid = "initial values that parameters and constants give"
        raise refuse(model.flat.place, f"an initial state that depends on `{wrong[0]}`", valid)
    return x


def _solved(equations: list[_Scalar], unknowns: Any, place: str, *, complete: bool = True) -> SymbolValues:
    """The unknowns, each from an equation in which it is the only one that is not solved yet."""
    remaining = {s.element_hash(): s for s in ca.symvar(unknowns)}
    waiting = [(e, e.symbols) for e in equations]
    solution: SymbolValues = []
    while waiting:
        lefts = [symbols & remaining.keys() for _, symbols in waiting]
        ready = next((i for i, left in enumerate(lefts) if len(left) <= 1), None)
        if ready is None:
            raise _loop([e for e, _ in waiting], list(remaining.values()))
        equation, _ = waiting.pop(ready)
        if not lefts[ready]:
            raise refuse(equation.place, "an equation without an unknown that is left to it", EXPLICIT)
        symbol = remaining.pop(lefts[ready].pop())
        solution.append((symbol, _isolated(equation, symbol)))
    if remaining and complete:
        missing = ", ".join(f"`{s.name()}`" for s in remaining.values())
        raise refuse(place, f"no equation for {missing}", "one equation per unknown")
    return solution


def _loop(equations: list[_Scalar], unknowns: list[Any]) -> RequestError:
    looped = ", ".join(f"`{s.name()}`" for s in unknowns)
    others = ", ".join(dict.fromkeys(e.place for e in equations[1:]))
    remedy = f"Its other equations: {others}. Solve them by hand." if others else "Solve it by hand."
    return refuse(equations[0].place, f"an algebraic loop between {looped}", EXPLICIT, remedy)


def _isolated(equation: _Scalar, symbol: Any) -> Any:
    """The value of a symbol, from an equation that is linear in it."""
    for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
        if ca.is_equal(side, symbol) and not ca.depends_on(other, symbol):
            return other
    rest = equation.left - equation.right
    slope = ca.simplify(ca.jacobian(rest, symbol))
    if ca.depends_on(slope, symbol) or slope.is_zero():
        raise refuse(equation.place, f"an equation that is not linear in its unknown `{symbol.name()}`", EXPLICIT)
    return -ca.substitute(rest, symbol, 0) / slope


def _inserted(solved: SymbolValues, expressions: list[Any]) -> list[Any]:
    """Expressions in which each solved symbol is replaced by its value."""
    if not solved:
        return expressions
    symbols, values = zip(*solved, strict=True)
    return ca.substitute_inplace(list(symbols), list(values), expressions, False)[1]  # noqa: FBT003 - CasADi's signature


def _repeated(value: Any, n: int) -> Any:
    """A column of `n` elements; a scalar is repeated."""
    return value if value.numel() == n else ca.repmat(value, n, 1)


def _symbols(name: str, shape: tuple[int, ...]) -> Any:
    if not shape:
        return ca.SX.sym(name)
    return ca.vertcat(ca.SX(0, 1), *(ca.SX.sym(f"{name}[{i + 1}]") for i in range(shape[0])))
