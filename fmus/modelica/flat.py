"""Flat Modelica models: what rumoca makes of a file, as variables and equations.

What a block cannot express is refused, with its file and line.
"""
# pyright: basic
# rumoca's trees are plain dictionaries; everything that leaves this file is annotated.

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from math import prod
from pathlib import Path
from typing import Any, Literal, TypeAlias

import components.interfaces
from components.interfaces.problem import Problem, raise_if_any, refuse
from components.interfaces.quantity import Type
from fmus.modelica.rumoca_library import CompiledModel, compiled_model
from fmus.toolchain.door import reading
from fmus.toolchain.limits import MOST_UNKNOWNS

Tree: TypeAlias = Mapping[str, Any]
"""An expression of rumoca: one key, which names its form, with its parts."""
VariableRole: TypeAlias = Literal["input", "output", "parameter", "dependent", "local"]

_TYPES = {"Real": Type.FLOAT64, "Integer": Type.INT32, "Boolean": Type.BOOLEAN}
_UNSUPPORTED = {
    "when_chains": "a `when` equation",
    "algorithms": "an `algorithm` section",
    "initial_algorithms": "an `initial algorithm` section",
    "assert_equations": "an `assert`",
    "initial_assert_equations": "an `assert`",
    "branches": "an overconstrained connection",
}
EXPLICIT = "explicit, continuous equations, one variable after the other, of scalars and one-dimensional arrays"


@dataclass(frozen=True)
class FlatVariable:
    """One variable of a flat model, an array as a whole."""

    name: str
    type: Type
    shape: tuple[int, ...]
    role: VariableRole
    """`dependent`: a constant, a protected or final parameter, or one that others determine."""
    unit: str
    """Its unit of measurement; empty where the model declares none."""
    description: str
    low: Tree | None
    high: Tree | None
    start: Tree | None
    fixed: bool
    binding: Tree | None
    place: str
    """The file and line of the declaration."""


@dataclass(frozen=True)
class Equation:
    """Both sides of an equation, and its file and line."""

    left: Tree
    right: Tree
    place: str


@dataclass(frozen=True)
class FlatModel:
    """A model without classes: it has only variables and equations."""

    name: str
    summary: str
    definition: str
    """Digest of all texts that it was made from, and of the version of rumoca."""
    place: str
    variables: Mapping[str, FlatVariable]
    equations: tuple[Equation, ...]
    initial: tuple[Equation, ...]


def library() -> Path:
    """The Modelica package with the interfaces of the sockets, which every model may use."""
    return Path(components.interfaces.__path__[0]).parent / "modelica" / "MacroStep"


def standard_types() -> Path:
    """A Modelica package with the types of `Modelica.Units.SI`, which every model may use too."""
    return library().with_name("Modelica")


def read(path: Path, model: str | None = None) -> FlatModel:
    """Flatten a Modelica model.

    Args:
        path: The file.
        model: The model's name; None for the only model of the file.

    Raises:
        RequestError: The model does not compile, or is not supported; the error has all that is not supported.
    """
    if not path.is_file():
        raise refuse(str(path), "no such file", "a Modelica file (.mo)")
    with reading(str(path), "a model that a block can express"):
        return _flat(path, compiled_model(path, model, [library(), standard_types()]))


def _flat(path: Path, compiled: CompiledModel) -> FlatModel:
    name, flat = compiled.name, compiled.flat
    places = _Places(compiled.sources, str(path))
    raise_if_any(_unsupported(flat, places))
    raise_if_any(_too_large(flat, str(path)))
    variables = {v["name"]: _variable(v, flat, places) for v in flat["variables"].values()}
    raise_if_any(_bound_inputs(variables.values()))
    return FlatModel(
        name=name,
        summary=flat["model_description"] or name,
        definition=_digest(name, compiled.sources),
        place=str(path),
        variables=variables,
        equations=(*_equations(flat["equations"], places), *_bindings(variables.values())),
        initial=tuple(_equations(flat["initial_equations"], places)),
    )


def nodes(tree: Any) -> Iterator[Mapping[str, Any]]:
    """All nodes of one of rumoca's trees, each before those in it."""
    if isinstance(tree, dict):
        yield tree
    for part in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from nodes(part)


def names(tree: Any) -> set[str]:
    """All names that an expression refers to."""
    return {node["VarRef"]["name"]["name"] for node in nodes(tree) if "VarRef" in node}


class _Places:
    """Positions in rumoca's sources, which are counted in bytes, as file and line."""

    def __init__(self, sources: list[tuple[int, str, str]], otherwise: str) -> None:
        self._texts = {source: (name, text.encode()) for source, name, text in sources}
        self._otherwise = otherwise

    def __call__(self, node: Any) -> str:
        """The place of the first node of a tree that has a position."""
        span = next(_spans(node), None)
        if span is None or span["source"] not in self._texts:
            return self._otherwise
        name, text = self._texts[span["source"]]
        return f"{name}:{text[: span['start']].count(bytes([10])) + 1}"


def _spans(tree: Any) -> Iterator[Mapping[str, Any]]:
    for node in nodes(tree):
        for key in ("span", "source_span"):
            if isinstance(node.get(key), dict) and "source" in node[key]:
                yield node[key]


def _unsupported(flat: Mapping[str, Any], places: _Places) -> Iterator[Problem]:
    if flat["is_partial"]:
        yield Problem(
            places(None), "a partial model", "a model that is complete", "Extend it, and fill what it leaves."
        )
    for key, words in _UNSUPPORTED.items():
        for item in flat[key]:
            yield Problem(places(item), words, EXPLICIT)
    for variable in flat["variables"].values():
        where, name = places(variable), variable["name"]
        type_name = flat["variable_type_names"].get(name, "")
        if type_name not in _TYPES:
            yield Problem(where, f"`{name}`, a variable of the type {type_name}", "Real, Integer or Boolean")
        if "Discrete" in variable["variability"]:
            yield Problem(where, f"`{name}`, a discrete variable", EXPLICIT)
        if len(variable["dims"]) > 1:
            yield Problem(where, f"`{name}`, an array with {len(variable['dims'])} dimensions", EXPLICIT)
        if not re.fullmatch(r"[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*", name):
            yield Problem(where, f"the name {name}", "letters, digits and underscores")


def _too_large(flat: Mapping[str, Any], where: str) -> Iterator[Problem]:
    """More elements of all variables, or more equations, than are solved here in reasonable time."""
    elements = sum(prod(variable["dims"]) for variable in flat["variables"].values())
    if (number := max(elements, len(flat["equations"]))) > MOST_UNKNOWNS:
        yield Problem(where, f"{number} unknowns or equations", f"at most {MOST_UNKNOWNS}", "Split the model.")


def _variable(raw: Mapping[str, Any], flat: Mapping[str, Any], places: _Places) -> FlatVariable:
    name = raw["name"]
    return FlatVariable(
        name=name,
        type=_TYPES[flat["variable_type_names"][name]],
        shape=tuple(raw["dims"]),
        role=_role(raw, flat),
        unit=raw["unit"] or "",
        description=raw["description"] or name,
        low=raw["min"],
        high=raw["max"],
        start=raw["start"],
        fixed=bool(raw["fixed"] and raw["fixed"][0]),
        binding=raw["binding"],
        place=places(raw),
    )


def _role(raw: Mapping[str, Any], flat: Mapping[str, Any]) -> VariableRole:
    name = raw["name"]
    first = name.partition(".")[0].partition("[")[0]
    if "Constant" in raw["variability"]:
        return "dependent"
    if "Parameter" in raw["variability"]:
        own = not (raw["is_protected"] or raw["evaluate"] or flat["variable_final_flags"].get(name))
        return "parameter" if own and not names(raw["binding"]) else "dependent"
    if "Input" in raw["causality"] and first in flat["top_level_input_components"]:
        return "input"
    at_top = "." not in name or first in (*flat["top_level_connectors"], *flat["record_instances"])
    return "output" if "Output" in raw["causality"] and at_top and not raw["is_protected"] else "local"


def _equations(raw: list[Mapping[str, Any]], places: _Places) -> Iterator[Equation]:
    for item in raw:
        sides = item["residual"]["Binary"]  # rumoca writes every equation as left - right
        yield Equation(sides["lhs"], sides["rhs"], places(item))


def _bindings(variables: Iterable[FlatVariable]) -> Iterator[Equation]:
    """The equations in declarations: `Real F = m*a`."""
    for v in variables:
        if v.binding is not None and v.role in {"output", "local"}:
            yield Equation({"VarRef": {"name": {"name": v.name}, "subscripts": []}}, v.binding, v.place)


def _bound_inputs(variables: Iterable[FlatVariable]) -> Iterator[Problem]:
    for v in variables:
        if v.binding is not None and v.role == "input":
            yield Problem(v.place, f"the input `{v.name}` with a value", "an input without one")


def _digest(model: str, sources: list[tuple[int, str, str]]) -> str:
    digest = hashlib.sha256(f"{model} rumoca {version('rumoca')}".encode())
    for text in sorted(text for _, _, text in sources):
        digest.update(b"\0" + text.encode())
    return digest.hexdigest()
