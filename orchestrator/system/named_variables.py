"""What the names of variables mean in a unit: a whole variable, or one element of an array."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from components.interfaces.problem import listed
from components.interfaces.record import Variable
from orchestrator.system.source import UnitSource

ElementIndex: TypeAlias = tuple[int, ...] | None
"""The element of an array, counted from 1 in each dimension; None for the whole array, and for a scalar."""

FREE: Final = "free"
"""What stands in the place of a list of the interface for `UnitSource.free_inputs`."""
SETTABLE: Final = ("parameters", "initials", "inputs", FREE)
"""The lists of an interface whose variables may be given a value before the initialisation."""

_LISTED: Final = 12
"""The parameters that a remark lists."""
_BETWEEN_INDICES: Final = re.compile(r"\]\[|,\s*")
_ELEMENT: Final = re.compile(r"(?P<name>.+?)\[[\d,]+\]")


@dataclass(frozen=True)
class UnitVariable:
    """What a name means in a unit: a variable, or one element of it.

    Attributes:
        role: `inputs`, `outputs`, `parameters`, `initials`, `clocks`, or `FREE`.
        variable: The variable.
        index: The element; None for the whole variable.
    """

    role: str
    variable: Variable
    index: ElementIndex = None

    @property
    def shape(self) -> tuple[int, ...]:
        """The lengths of the array; empty for a scalar and for an element."""
        return () if self.index else self.variable.shape


def variables_of_role(source: UnitSource, role: str) -> Iterator[tuple[str, UnitVariable]]:
    """The variables of a role, and the elements of arrays as the file spells them."""
    for variable in getattr(source.interface, role):
        spelled = source.element_names(variable, role) if variable.shape else ()
        yield from _named(role, variable, spelled)


def named(variables: Iterable[Variable], role: str = "parameters") -> dict[str, UnitVariable]:
    """Variables without a file by name, and the elements of arrays as `name[1]`."""
    return {name: found for variable in variables for name, found in _named(role, variable, ())}


def settable(source: UnitSource, roles: Iterable[str] = SETTABLE) -> dict[str, UnitVariable]:
    """What of a unit may be given a value before the initialisation, by name, by element and by alias.

    Args:
        source: The source of the unit.
        roles: The lists of the interface that count; the first that has a name decides what it means.
    """
    found: dict[str, UnitVariable] = {}
    for role in roles:
        own = named(source.free_inputs, FREE) if role == FREE else dict(variables_of_role(source, role))
        found = own | found
    aliases = source.interface.aliases.items()
    return {alias: found[name] for alias, name in aliases if name in found} | found


def look_up(name: str, known: Mapping[str, UnitVariable]) -> UnitVariable | None:
    """What a name means; `x[1][2]` and `x[1, 2]` mean `x[1,2]` where nothing else has their name.

    Args:
        name: The name.
        known: What the names mean.
    """
    if name in known or "[" not in name:
        return known.get(name)
    plain = _one_bracket(name)
    return next((found for other, found in known.items() if _one_bracket(other) == plain), None)


def array_of(name: str, known: Mapping[str, UnitVariable]) -> UnitVariable | None:
    """The variable of which a name would be an element if there were one."""
    match = _ELEMENT.fullmatch(_one_bracket(name))
    return known.get(match["name"]) if match else None


def own_values(unit: str, source: UnitSource) -> list[str]:
    """A remark on the parameters that keep values inside an FMU which nobody gives and its file does not tell.

    Args:
        unit: The name of the unit.
        source: The source of the unit.
    """
    told = {*source.parameters, *source.interface.starts}
    untold = [v.name for v in source.interface.parameters if v.name not in told]
    if not (untold and source.has_own_values):
        return []
    return [f"{unit}: no start value in the file, the FMU keeps its own: {listed(untold, _LISTED, 'others')}"]


def _one_bracket(name: str) -> str:
    return _BETWEEN_INDICES.sub(",", name)


def _named(role: str, variable: Variable, spelled: Iterable[str]) -> Iterator[tuple[str, UnitVariable]]:
    yield variable.name, UnitVariable(role, variable)
    if not variable.shape:
        return
    names = list(spelled)
    names = names if len(names) == variable.size and names != [variable.name] else variable.elements
    for name, index in zip(names, np.ndindex(*variable.shape), strict=True):
        yield name, UnitVariable(role, variable, tuple(i + 1 for i in index))
