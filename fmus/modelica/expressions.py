"""Expressions of a flat Modelica model as CasADi expressions; each variable is a column."""
# pyright: basic
# CasADi carries no types, and rumoca's trees are plain dictionaries; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import casadi as ca

from components.interfaces.problem import choices, refuse
from fmus.modelica.flat import EXPLICIT, Tree, nodes
from fmus.toolchain.limits import MOST_UNKNOWNS


def _length(given: Any) -> int:
    """The length of an array. Raises `NotImplementedError` where it is too large."""
    if not 0 <= (length := int(given)) <= MOST_UNKNOWNS:
        raise NotImplementedError(length)
    return length


_OPERATORS: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    **dict.fromkeys(("Add", "AddElem"), lambda a, b: a + b),
    **dict.fromkeys(("Sub", "SubElem"), lambda a, b: a - b),
    **dict.fromkeys(("Mul", "MulElem"), lambda a, b: a * b),
    **dict.fromkeys(("Div", "DivElem"), lambda a, b: a / b),
    **dict.fromkeys(("Exp", "ExpElem"), lambda a, b: a**b),
    "Lt": lambda a, b: a < b,
    "Le": lambda a, b: a <= b,
    "Gt": lambda a, b: a > b,
    "Ge": lambda a, b: a >= b,
    "Eq": lambda a, b: a == b,
    "Neq": lambda a, b: a != b,
    "And": ca.logic_and,
    "Or": ca.logic_or,
}
_OF_SCALARS: Final = ("Mul", "Div", "Exp")
"""Operators that have another meaning, or none, between two arrays."""
_SIGNS: Final[Mapping[str, Callable[[Any], Any]]] = {"Plus": lambda a: a, "Minus": lambda a: -a, "Not": ca.logic_not}
_FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
    **{
        name.capitalize(): getattr(ca, name)
        for name in (
            *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh"),
            *("exp", "log", "log10", "sqrt", "sign"),
        )
    },
    "Abs": ca.fabs,
    "Min": ca.fmin,
    "Max": ca.fmax,
    "NoEvent": lambda a: a,
    "Smooth": lambda _, a: a,
    "Zeros": lambda n: ca.SX.zeros(_length(n)),
    "Ones": lambda n: ca.SX.ones(_length(n)),
    "Fill": lambda a, n: ca.repmat(a, _length(n), 1),
}
FUNCTIONS: Final = choices(sorted([*(name[0].lower() + name[1:] for name in _FUNCTIONS), "der"]))


class Expressions:
    """The values of expressions.

    Relations are evaluated as they are, without events, so that `noEvent` and `smooth` change nothing.

    Args:
        columns: The value of each variable, a column.
        derivatives: The derivative of each state, a column.
    """

    def __init__(self, columns: Mapping[str, Any], derivatives: Mapping[str, Any]) -> None:
        self._columns = columns
        self._derivatives = derivatives

    def value(self, tree: Tree, place: str) -> Any:
        """The value of an expression, a column.

        Args:
            tree: The expression.
            place: The file and line of its equation.

        Raises:
            RequestError: The expression is not supported, or has a name that is not known.
        """
        ((form, node),) = tree.items()
        known: Mapping[str, Callable[[Any, str], Any]] = {
            "Literal": _literal,
            "VarRef": lambda n, p: _element(n, p, self._columns),
            "Unary": lambda n, p: _SIGNS[n["op"]](self.value(n["rhs"], p)),
            "Binary": self._binary,
            "If": self._choice,
            "Array": lambda n, p: ca.vertcat(*(self.value(item, p) for item in n["elements"])),
            "BuiltinCall": self._call,
        }
        if form == "FunctionCall":
            raise refuse(place, f"the function `{node['name']['name']}`", FUNCTIONS, "Write its equations out.")
        if form not in known:
            raise refuse(place, f"an expression of the kind `{form}`", EXPLICIT)
        return known[form](node, place)

    def _binary(self, node: Any, place: str) -> Any:
        left, right = self.value(node["lhs"], place), self.value(node["rhs"], place)
        if node["op"] not in _OPERATORS or (node["op"] in _OF_SCALARS and min(left.numel(), right.numel()) > 1):
            raise refuse(place, f"the operator `{node['op']}` between arrays", EXPLICIT, "Try `.*`, `./` or `.^`.")
        return _OPERATORS[node["op"]](left, right)

    def _choice(self, node: Any, place: str) -> Any:
        value = self.value(node["else_branch"], place)
        for condition, then in reversed(node["branches"]):
            value = ca.if_else(self.value(condition, place), self.value(then, place), value)
        return value

    def _call(self, node: Any, place: str) -> Any:
        name = node["function"]
        if name == "Der":
            (argument,) = node["args"]
            if "VarRef" not in argument:
                raise refuse(place, "`der` of an expression", "der(x) of a variable x")
            return _element(argument["VarRef"], place, self._derivatives)
        arguments = [self.value(item, place) for item in node["args"]]
        of_array = name in {"Min", "Max"} and len(arguments) == 1
        called = name[0].lower() + name[1:]
        if name not in _FUNCTIONS or of_array:
            raise refuse(place, f"the function `{called}`" + (" of an array" if of_array else ""), FUNCTIONS)
        try:
            return _FUNCTIONS[name](*arguments)
        except (TypeError, ValueError, RuntimeError, NotImplementedError) as error:  # by CasADi
            valid = "scalars and one-dimensional arrays; a length that a number or a constant gives"
            raise refuse(place, f"arguments that `{called}` cannot take here", valid) from error


def _literal(node: Any, place: str) -> Any:
    ((form, value),) = node["value"].items()
    if form not in {"Real", "Integer", "Boolean"}:
        raise refuse(place, f"the {form} {value!r}", "numbers and Booleans")
    return ca.SX(float(value))


def _element(node: Any, place: str, columns: Mapping[str, Any]) -> Any:
    name = node["name"]["name"]
    if name == "time":
        raise refuse(place, "`time`", EXPLICIT, "Add a state t with der(t) = 1.")
    if name not in columns:
        raise refuse(place, f"the name `{name}`", "a variable, a parameter or a constant of the model")
    column = columns[name]
    if not node["subscripts"]:
        return column
    index = node["subscripts"][0].get("Index", {}).get("value")
    if not isinstance(index, int) or len(node["subscripts"]) > 1:
        raise refuse(place, f"an index of `{name}` that is no number", EXPLICIT)
    return column[index - 1]


def states_in(tree: Any) -> set[str]:
    """The names of all variables whose derivatives are in a tree."""
    calls = (node["BuiltinCall"] for node in nodes(tree) if "BuiltinCall" in node)
    derived = (call["args"][0] for call in calls if call["function"] == "Der")
    return {argument["VarRef"]["name"]["name"] for argument in derived if "VarRef" in argument}
