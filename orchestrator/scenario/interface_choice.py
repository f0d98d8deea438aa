"""The interface types that a person chooses for FMUs that have both: `--interface me`, `--interface plant=me`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, raise_if_any
from fmus.reading.archive import InterfaceType, interface_type_named


@dataclass(frozen=True)
class InterfaceChoice:
    """The interface types that a person chooses."""

    everywhere: InterfaceType | None = None
    """That of all FMUs that have none of their own."""
    by_unit: Mapping[str, InterfaceType] = field(default_factory=dict[str, InterfaceType])

    def of(self, unit: str, otherwise: InterfaceType | None = None) -> InterfaceType | None:
        """The interface type of a unit; `otherwise` where the person chooses none."""
        return self.by_unit.get(unit, self.everywhere) or otherwise

    def problems(self, units: Iterable[str]) -> list[Problem]:
        """The problems of units that are not there, among the FMUs that an interface type can be chosen for."""
        known = list(units)
        unknown = [
            Problem(f"--interface {unit}={kind.short}", f"`{unit}`, no FMU", choices(known), did_you_mean(unit, known))
            for unit, kind in self.by_unit.items()
            if unit not in known
        ]
        if self.everywhere is not None and not known:
            remedy = "Leave it out; our own blocks are Co-Simulation."
            unknown.append(Problem(f"--interface {self.everywhere.short}", "no FMU of another maker", "one", remedy))
        return unknown


NO_CHOICE: Final = InterfaceChoice()
"""What holds where a person chooses nothing."""


def interface_choice(requests: Sequence[str], units: Sequence[str] | None = None) -> InterfaceChoice:
    """Read the values of the option `--interface`; the last for a unit counts.

    Args:
        requests: `cs` or `me`, or a unit with one of them, such as `plant=me`.
        units: The units that are FMUs, where they are known already.

    Raises:
        RequestError: A value means no interface type, or a unit is none of the `units`; the error lists all of them.
    """
    everywhere: InterfaceType | None = None
    by_unit: dict[str, InterfaceType] = {}
    problems: list[Problem] = []
    for request in [requests] if isinstance(requests, str) else requests:
        unit, _, name = request.rpartition("=")
        try:
            kind = interface_type_named(name, f"--interface {request}")
        except RequestError as error:
            problems += error.problems
            continue
        if unit:
            by_unit[unit] = kind
        else:
            everywhere = kind
    choice = InterfaceChoice(everywhere, by_unit)
    raise_if_any([*problems, *([] if units is None else choice.problems(units))])
    return choice
