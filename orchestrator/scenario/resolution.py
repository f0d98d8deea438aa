"""The resolution of parameters: the value of each one, its source, and the problems with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

import numpy as np

from components.interfaces.problem import Problem, choices, did_you_mean, listed
from components.interfaces.record import Variable
from orchestrator.system.files import Given
from orchestrator.system.named_variables import SETTABLE, UnitVariable, array_of, look_up, named, settable
from orchestrator.system.source import UnitSource
from orchestrator.system.value_texts import from_text, in_unit_of

_Source = TypeVar("_Source", bound=UnitSource)
_MOST_SIGNS: Final = 100
"""The most signs `=` that a name may have."""
_MOST_LISTED: Final = 60
"""The most names that a message lists as valid."""


@dataclass(frozen=True)
class Setting:
    """A value from the command line as it was typed, ``--set UNIT.NAME=VALUE``, in the unit of measurement of NAME.

    What is the name and what the value shows where it is known which names there are: either may have a `=` in it.
    """

    unit: str
    assignment: str
    """`NAME=VALUE`."""

    @property
    def name(self) -> str:
        """The shortest name that it may mean, for messages."""
        return self.assignment.partition("=")[0]

    def splits(self) -> Iterator[tuple[str, str]]:
        """The names that it may mean, each with the value that then follows; the longest first."""
        parts = self.assignment.split("=", _MOST_SIGNS)
        for n in range(len(parts) - 1, 0, -1):
            yield "=".join(parts[:n]), "=".join(parts[n:])

    def means(self, known: Mapping[str, UnitVariable]) -> tuple[UnitVariable, str] | None:
        """The variable or the element that is meant and the text of its value; None where no name is known."""
        found = ((look_up(name, known), text) for name, text in self.splits())
        return next(((variable, text) for variable, text in found if variable is not None), None)


@dataclass
class Resolution:
    """The values of declared parameters, by name, with their sources and all problems.

    A shorter array replaces the first elements of a longer one. Defaults that are not declared belong to other blocks
    and are ignored; all other unknown names are problems, and so are values that do not fit their quantity.
    """

    where: str
    """The name of the unit, with which full paths begin."""
    known: Mapping[str, UnitVariable]
    """What the names mean that values can be given to."""
    starts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """The start values of the unit itself, which the elements of an array keep that are not given."""
    declares: Callable[[str], bool] = lambda _: False
    """Whether the file of the unit declares a variable of a name, also one that cannot be set."""
    values: dict[str, Any] = field(default_factory=dict[str, Any])
    sources: dict[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    """Value, unit of measurement and source of each value, by full path."""
    problems: list[Problem] = field(default_factory=list[Problem])
    remarks: list[str] = field(default_factory=list[str])

    def path(self, name: str) -> str:
        """The full path of a parameter."""
        return f"{self.where}.{name}"

    def of_role(self, *roles: str) -> dict[str, Any]:
        """The values of the variables of some lists of the interface."""
        return {name: value for name, value in self.values.items() if self.known[name].role in roles}

    def give(self, name: str, given: Given) -> None:
        """Give a value of a file."""
        found = look_up(name, self.known)
        if found is None:
            self._refuse(name)
            return
        q = found.variable.quantity
        converts = q.type.is_float and q.unit != ""
        value = in_unit_of(given, q) if converts or given.unit == q.unit else None
        if value is None:
            self.problems.append(Problem(self.path(name), f"unit `{given.unit}`", f"unit `{q.unit}`"))
            return
        written = "" if given.unit == q.unit else f"{given.value} {given.unit}"
        self._put(self.path(name), found, value.value, ": ".join(part for part in (given.source, written) if part))

    def set(self, setting: Setting) -> None:
        """Give a value of the command line."""
        meant = setting.means(self.known)
        if meant is None:
            self._refuse(setting.name)
            return
        found, text = meant
        q = found.variable.quantity
        value = from_text(text, replace(q, shape=()) if found.index else q)
        path = self.path(setting.assignment.removesuffix(f"={text}"))
        self._tell_kept(found, value)
        self._put(path, found, value, "--set")

    def _tell_kept(self, found: UnitVariable, value: Any) -> None:
        """Add a remark where a list is shorter than the values that are there, and the others are not all alike.

        Others that are alike are of empty slots, mostly: nobody is surprised that they stay.
        """
        before = self.values.get(found.variable.name)
        if not (isinstance(value, list) and isinstance(before, list)):
            return
        given, whole = len(value), len(before)  # type: ignore[unknown]
        kept = [str(one) for one in before[given:]]  # type: ignore[unknown]
        if len({*kept}) > 1:
            others = f"--set gives the first {given} of {whole} values; the others stay as they were"
            self.remarks.append(f"{self.path(found.variable.name)}: {others}: {listed(kept)}")

    def _put(self, path: str, found: UnitVariable, value: Any, source: str) -> None:
        variable = found.variable
        if found.index is not None:
            value = self._with_element(path, found, value)
            if value is None:
                return
        self.values[variable.name] = _overlaid(self.values.get(variable.name), value)
        unit = variable.quantity.unit
        told = {"value": self.values[variable.name], "unit": unit, "source": source}
        self.sources[self.path(variable.name)] = told

    def _with_element(self, path: str, found: UnitVariable, value: Any) -> list[Any] | None:
        """All values of an array with one element changed; None where the problems say why there are none."""
        variable = found.variable
        if problems := replace(variable.quantity, shape=()).problems(path, value):
            self.problems += problems
            return None
        whole = np.array(self.values.get(variable.name, self.starts.get(variable.name)), dtype=object)
        if whole.ndim != len(variable.shape) or any(a < b for a, b in zip(whole.shape, variable.shape, strict=True)):
            remedy = f"Give all of them first: --set {self.path(variable.name)}=[...]."
            others = "an element of an array whose others have no values"
            self.problems.append(Problem(path, others, f"{variable.size} values", remedy))
            return None
        whole[tuple(i - 1 for i in found.index or ())] = value
        return whole.tolist()

    def _refuse(self, name: str) -> None:
        """Add the problem that nothing has a name to which a value could be given."""
        array = array_of(name, self.known)
        names = [other for other, found in self.known.items() if found.index is None]
        if array is None:
            more = f"one of {len(names)} names, which `macrostep check` lists"
            valid = choices(names) if len(names) <= _MOST_LISTED else more
            unknown = "a variable whose value nobody may set" if self.declares(name) else "an unknown parameter"
            self.problems.append(Problem(self.path(name), unknown, valid, did_you_mean(name, names)))
            return
        elements = [other for other, found in self.known.items() if found.variable is array.variable and found.index]
        ends = [other[other.rindex("[") + 1 : -1] for other in (elements[:1] + elements[-1:])]
        valid = " to ".join(ends) if array.variable.quantity.shape else "a scalar parameter"
        self.problems.append(Problem(self.path(name), "no such element", valid or "an array without elements"))


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
    known = named(declared)
    # a parameter file may hold values for other units too
    own = [(name, value) for name, value in (defaults or {}).items() if look_up(name, known)]
    return _resolved(Resolution(where, known), [*own, *(given or {}).items()], settings)


def resolve_unit(
    where: str,
    source: UnitSource,
    given: Mapping[str, Given] | None = None,
    settings: Sequence[Setting] = (),
    roles: Iterable[str] = SETTABLE,
) -> Resolution:
    """Give what of a unit may be set before the initialisation its values: `settings` over `given`.

    Args:
        where: The name of the unit.
        source: The source of the unit.
        given: Values that a scenario or another file gives to this unit, by name.
        settings: Values from the command line.
        roles: The lists of the interface whose variables may be given values.

    Returns:
        The values with their sources, and the problems, which are not raised.
    """
    result = Resolution(where, settable(source, roles), source.interface.starts, source.declares)
    return _resolved(result, [*(given or {}).items()], settings)


def with_lengths(
    where: str, source: _Source, given: Mapping[str, Given] | None = None, settings: Sequence[Setting] = ()
) -> _Source:
    """A unit whose arrays have the lengths that the values of structural parameters give them.

    Args:
        where: The name of the unit.
        source: The source of the unit.
        given: Values that a scenario or another file gives to this unit, by name.
        settings: Values from the command line.

    Returns:
        The source; as it was where the values do not fit, which `resolve_unit` tells.
    """
    if not source.structural:
        return source
    names = settable(source)
    known = {n: v for n, v in names.items() if v.variable.name in source.structural}
    lengths = Resolution(where, known)
    mine = [s for s in settings if (meant := s.means(names)) and meant[0].variable.name in source.structural]
    of_file = [(n, value) for n, value in (given or {}).items() if n in known]
    _resolved(lengths, of_file, mine)
    return source.with_parameters(lengths.values) if lengths.values and not lengths.problems else source


def _resolved(result: Resolution, given: Iterable[tuple[str, Given]], settings: Iterable[Setting]) -> Resolution:
    for name, value in given:
        result.give(name, value)
    for setting in settings:
        result.set(setting)
    for name, value in result.values.items():
        result.problems += result.known[name].variable.quantity.problems(result.path(name), value)
    return result


def _overlaid(before: Any, value: Any) -> Any:
    """A list, completed with the remaining elements of a longer previous one; any other value as it is."""
    if not isinstance(value, list):
        return value
    return [*value, *before[len(value) :]] if isinstance(before, list) else value  # type: ignore[unknown]
