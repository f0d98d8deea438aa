"""The resolution of values: which each declared parameter has, where it comes from, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from components.interfaces.problem import Problem, choices, did_you_mean
from components.interfaces.record import Variable
from orchestrator.system.files import Given


@dataclass(frozen=True)
class Setting:
    """A value given on the command line, in the parameter's own unit: ``--set UNIT.NAME[INDEX]=VALUE``."""

    unit: str
    name: str
    index: int | None
    value: Any


@dataclass
class Resolution:
    """The values of what is declared, by name, with their sources and all problems.

    A shorter array leaves the rest as it was. Defaults that are not declared belong to others and are passed over;
    other unknown names are problems, as is whatever does not fit its quantity.
    """

    where: str
    """The unit's name, with which full paths begin."""
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
        where: The unit's name.
        declared: The parameters there are.
        defaults: Values of parameter files, by name; they may hold values for others too.
        given: Values that a scenario or another file gives for just this unit.
        settings: What the command line sets.
    """
    known = {v.name: v for v in declared}
    found = Resolution(where)
    given = given or {}
    origins: dict[str, str] = {}
    for name, value in [*(defaults or {}).items(), *given.items()]:
        variable = known.get(name)
        origins[name] = value.source
        if variable is None:
            found.problems += [_unknown(found.path(name), name, known)] if name in given else []
        elif value.unit != variable.quantity.unit:
            valid = f"unit `{variable.quantity.unit}`"
            found.problems.append(Problem(found.path(name), f"unit `{value.unit}`", valid))
        else:
            found.values[name] = _overlaid(found.values.get(name), value.value)
    for setting in settings:
        origins[setting.name] = "--set"
        if setting.name not in known:
            found.problems.append(_unknown(found.path(setting.name), setting.name, known))
        elif setting.index is None:
            found.values[setting.name] = _overlaid(found.values.get(setting.name), setting.value)
        else:
            found.problems += _set_element(found.path(setting.name), known[setting.name], found.values, setting)
    for name, value in found.values.items():
        quantity = known[name].quantity
        found.problems += quantity.problems(found.path(name), value)
        found.sources[found.path(name)] = {"value": value, "unit": quantity.unit, "source": origins[name]}
    return found


def _unknown(path: str, name: str, known: Mapping[str, Variable]) -> Problem:
    return Problem(path, "an unknown parameter", choices(known), did_you_mean(name, known))


def _overlaid(before: Any, value: Any) -> Any:
    """A list over the first elements of a longer one, or the value itself."""
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
    values[setting.name] = [*values[setting.name]]
    values[setting.name][setting.index - 1] = setting.value
    return []
