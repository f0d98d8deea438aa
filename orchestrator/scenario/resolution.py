"""The resolution of parameters: the value of each one, its source, and the problems with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from components.interfaces.problem import Problem, choices, did_you_mean
from components.interfaces.record import Variable
from orchestrator.system.files import Given


@dataclass(frozen=True)
class Setting:
    """A value from the command line, in the parameter's unit of measurement: ``--set UNIT.NAME[INDEX]=VALUE``."""

    unit: str
    name: str
    index: int | None
    value: Any


@dataclass
class Resolution:
    """The values of declared parameters, by name, with their sources and all problems.

    A shorter array replaces the first elements of a longer one. Defaults that are not declared belong to other blocks
    and are ignored; all other unknown names are problems, and so are values that do not fit their quantity.
    """

    where: str
    """The name of the unit, with which full paths begin."""
    values: dict[str, Any] = field(default_factory=dict[str, Any])
    sources: dict[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    """Value, unit of measurement and source of each value, by full path."""
    problems: list[Problem] = field(default_factory=list[Problem])

    def path(self, name: str) -> str:
        """The full path of a parameter."""
        return f"{self.where}.{name}"


def resolve(
    where: str,
    declared: Sequence[Variable],
    defaults: Mapping[str, Given] | None = None,
    given: Mapping[str, Given] | None = None,
    settings: Sequence[Setting] = (),
) -> Resolution:
    """Give the declared parameters their values: `settings` over `given` over `defaults`.

    Args:
        where: The name of the unit.
        declared: The parameters of the unit.
        defaults: Values of parameter files, by name; other blocks may have values in them too.
        given: Values that a scenario or another file gives to this unit, by name.
        settings: Values from the command line.

    Returns:
        The values with their sources, and the problems, which are not raised.
    """
    known = {v.name: v for v in declared}
    result = Resolution(where)
    origins: dict[str, str] = {}
    # a parameter file may hold values for other units too
    own = {name: value for name, value in (defaults or {}).items() if name in known}
    for name, value in [*own.items(), *(given or {}).items()]:
        variable = known.get(name)
        origins[name] = value.source
        if variable is None:
            result.problems.append(_unknown(result.path(name), name, known))
        elif value.unit != variable.quantity.unit:
            valid = f"unit `{variable.quantity.unit}`"
            result.problems.append(Problem(result.path(name), f"unit `{value.unit}`", valid))
        else:
            result.values[name] = _overlaid(result.values.get(name), value.value)
    for setting in settings:
        origins[setting.name] = "--set"
        if setting.name not in known:
            result.problems.append(_unknown(result.path(setting.name), setting.name, known))
        elif setting.index is None:
            result.values[setting.name] = _overlaid(result.values.get(setting.name), setting.value)
        else:
            result.problems += _set_element(result.path(setting.name), known[setting.name], result.values, setting)
    for name, value in result.values.items():
        quantity = known[name].quantity
        result.problems += quantity.problems(result.path(name), value)
        result.sources[result.path(name)] = {"value": value, "unit": quantity.unit, "source": origins[name]}
    return result


def _unknown(path: str, name: str, known: Mapping[str, Variable]) -> Problem:
    return Problem(path, "an unknown parameter", choices(known), did_you_mean(name, known))


def _overlaid(before: Any, value: Any) -> Any:
    """A list, completed with the remaining elements of a longer previous one; any other value as it is."""
    if not isinstance(value, list):
        return value
    return [*value, *before[len(value) :]] if isinstance(before, list) else value  # type: ignore[unknown]


def _set_element(path: str, variable: Variable, values: dict[str, Any], setting: Setting) -> list[Problem]:
    size = variable.size if variable.quantity.shape else 0
    element = f"{path}[{setting.index}]"
    if setting.index is None or not 1 <= setting.index <= size:
        return [Problem(element, "no such element", f"1 to {size}" if size else "a scalar parameter")]
    if problems := replace(variable.quantity, shape=()).problems(element, setting.value):
        return problems
    items: Any = values.get(setting.name)
    if not isinstance(items, list) or len(items) < size:  # type: ignore[unknown]
        whole = f"Give all of them first: --set {path}=[...]."
        return [Problem(element, "an element of an array whose others have no values", f"{size} values", whole)]
    values[setting.name] = [*items[: setting.index - 1], setting.value, *items[setting.index :]]
    return []
