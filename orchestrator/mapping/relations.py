"""From an entry of a mapping to numbers: which elements of theirs, and the linear relation to the signal of ours."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from components.interfaces.conversion import IDENTITY, Linear, unit_conversion
from components.interfaces.problem import Problem, choices, did_you_mean
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.socket import ANY_LENGTH, Socket, describe
from components.interfaces.units_of_measurement import BASE_UNITS, BaseUnit
from fmus.units.adaptation import Link, RateInput, VariableElement
from fmus.units.conventions import (
    LEFTWARD,
    BoxEnd,
    Convention,
    ReferencePoint,
    RoadFrameVelocity,
    SpeedAndSlip,
)
from orchestrator.mapping.mapping_file import Amount, Entry, MappingFile

ROLE_UNITS: Final[Mapping[str, str]] = {
    "steering_wheel_angle": "rad",
    "steering_rate": "rad/s",
    "axle_torque": "N.m",
    "wheel_force": "N",
    "force": "N",
    "acceleration": "m/s2",
}
_UNITS: Mapping[str, str] = {"ratio": "1", "R_w": "m", "m": "kg", "limit": "rad/s"}
_SCALES: Mapping[str, Callable[[Mapping[str, float]], float]] = {
    "steering_wheel_angle": lambda n: n["ratio"],
    "steering_rate": lambda _: 1.0,
    "axle_torque": lambda _: 2.0,
    "wheel_force": lambda n: 1 / n["R_w"],
    "force": lambda n: 2 / n["R_w"],
    "acceleration": lambda n: 2 / (n["R_w"] * n["m"]),
}
"""What the role's quantity is for one unit of our signal; `T_r` is the torque on one of two rear wheels"""


@dataclass
class Relations:
    """Makes links for one FMU and gathers what is wrong with the entries."""

    socket: Socket
    where: str
    """The mapping file's name, for messages"""
    unit_of: Mapping[str, str]
    """Units of signals that are given in another form than ours (the slip angle)"""
    mirrored: bool
    problems: list[Problem]

    def link(self, key: str, signal: Variable, entry: Entry, offered: Sequence[Variable]) -> Link | None:
        """The link of an entry that names variables; None where it is wrong. `key` is what messages call it."""
        found = self.places(key, signal, entry.variables, offered)
        if found is None:
            return None
        places, quantity = found
        if entry.unit is not None:
            quantity = replace(quantity, unit=entry.unit, base=None)
        relation = self.relation(key, signal, quantity, entry)
        if relation is None:
            return None
        limits = {n: self.limit(key, n, entry, quantity) for n in ("min", "max")}
        low, high = limits["min"], limits["max"]
        return Link(
            signal.name, places, relation, -math.inf if low is None else low, math.inf if high is None else high
        )

    def rate(self, key: str, signal: Variable, entry: Entry, link: Link, shown: Sequence[Variable]) -> RateInput | None:
        """A steering-rate input, with the FMU's own steering angle where it shows it."""
        limit = self.number(f"{key}.limit", entry, "limit")
        if entry.angle is None:
            return RateInput(link, None, math.inf if limit is None else limit)
        angle = self.link(f"{key}.angle", signal, Entry(variables=(entry.angle,)), shown)
        return None if angle is None else RateInput(link, angle, math.inf if limit is None else limit)

    def places(
        self, key: str, signal: Variable, names: Sequence[str], offered: Sequence[Variable]
    ) -> tuple[tuple[VariableElement, ...], Quantity] | None:
        """The elements that `names` stand for, and what they are."""
        known = {v.name: v for v in offered}
        elements = {e: (v.name, i) for v in offered for i, e in enumerate(v.elements)}
        found: list[VariableElement] = []
        for name in names:
            if name in known:
                found += [(name, i) for i in range(known[name].size)]
            elif name in elements:
                found.append(elements[name])
            elif "*" in name and (several := _numbered(name, elements)):
                found += [elements[element] for element in several]
            else:
                remedy = did_you_mean(name, [*known, *elements])
                self.problems.append(Problem(key, f"the unknown variable `{name}`", choices(known), remedy))
                return None
        size = 1 if not signal.shape else signal.shape[0]
        partial = self.socket.bus(signal.name).partial
        fits = len(found) == size or (size == ANY_LENGTH and found) or (0 < len(found) < size and partial)
        if not fits:
            valid = "1 element" if not signal.shape else f"{'up to ' * partial}{size} elements"
            self.problems.append(Problem(key, f"{len(found)} elements in {', '.join(f'`{n}`' for n in names)}", valid))
            return None
        return tuple(found), known[found[0][0]].quantity

    def relation(self, key: str, signal: Variable, theirs: Quantity, entry: Entry) -> Linear | None:
        """From theirs to ours: units, factor, offset, axes and role in one."""
        ours = signal.quantity
        if not ours.type.is_float:
            return self._plain(key, theirs, ours)
        wanted = replace(ours, unit=ROLE_UNITS.get(entry.role or "", self.unit_of.get(signal.name, ours.unit)))
        if not theirs.type.is_float and entry.unit is None:
            theirs = replace(theirs, unit="")
        factor = entry.numbers.get("factor", Amount(1.0))
        converted = conversion(theirs, wanted) if factor.unit == "1" else _product(factor, theirs, wanted)
        numbers = {n: self.number(f"{key}.{n}", entry, n) for n in ("ratio", "R_w", "m") if n in entry.numbers}
        offset = self._offset(key, entry, wanted)
        if converted is None:
            remedy = 'If the FMU declares its unit wrongly, say unit = "..." in a mapping file.'
            text = f"{', '.join(f'`{n}`' for n in entry.variables)}: {describe(theirs)}"
            valid = f"a unit that converts to `{wanted.unit}`"
            if factor.unit != "1":
                text, valid, remedy = f"{text}, times a factor in `{factor.unit}`", f"`{wanted.unit}`", ""
            self.problems.append(Problem(key, text, valid, remedy))
            return None
        if offset is None or None in numbers.values():
            return None
        value = _float(factor.value)
        scale = _SCALES[entry.role]({n: v for n, v in numbers.items() if v}) if entry.role else 1.0
        if value == 0 or scale == 0 or not math.isfinite(value * scale):
            self.problems.append(Problem(f"{key}.factor", f"{value:g}", "a finite number other than 0"))
            return None
        sign = -1.0 if self.mirrored and signal.name.partition(".")[2] in LEFTWARD else 1.0
        whole = Linear(sign * value, sign * offset).after(converted)
        return Linear(whole.factor / scale, whole.offset / scale) if scale != 1 else whole

    def _plain(self, key: str, theirs: Quantity, ours: Quantity) -> Linear | None:
        """Booleans, whole numbers and enumerations have no unit; a number may stand for them."""
        items = [{i.name: i.value for i in q.enumeration} if q.enumeration else {} for q in (theirs, ours)]
        if ours.type is Type.ENUMERATION and items[0] and items[0] != items[1]:
            self.problems.append(Problem(key, f"the enumeration {items[0]}", str(items[1])))
            return None
        return IDENTITY

    def number(self, key: str, entry: Entry, name: str) -> float | None:
        """A number of the entry in its SI unit; None where there is none, or a wrong one."""
        amount = entry.numbers.get(name)
        return None if amount is None else self.amount(key, amount, _UNITS[name], positive=True)

    def amount(self, key: str, amount: Amount, unit: str, *, positive: bool = False) -> float | None:
        """A number in `unit`; None where it measures something else."""
        found = unit_conversion(Quantity(amount.unit, ""), Quantity(unit, ""))
        if found is None or not amount.unit:
            self.problems.append(Problem(key, f"unit `{amount.unit}`", f"a unit that converts to `{unit}`"))
            return None
        value = float(found(_float(amount.value)))
        if not math.isfinite(value) or (positive and value <= 0):
            self.problems.append(Problem(key, f"{amount.value}", f"a {'positive' if positive else 'finite'} number"))
            return None
        return value

    def conventions(self, bus: str, mapping: MappingFile) -> Iterator[Convention]:
        """From the FMU's way of giving a bus to ours, in this order."""
        velocity = mapping.velocities.get(bus)
        if velocity == "speed_and_slip":
            yield SpeedAndSlip()
        elif velocity == "road":
            yield RoadFrameVelocity()
        point, amount = mapping.references.get(bus, ("", None))
        if amount is not None:
            distance = self.amount(f"{mapping.where}: {bus}.reference.distance", amount, "m")
            if distance is not None:
                yield ReferencePoint(-distance if point == "rear_axle" else distance)
        elif point in {"rear_bumper", "front_bumper"}:
            yield BoxEnd(-0.5 if point == "rear_bumper" else 0.5)

    def limit(self, key: str, name: str, entry: Entry, theirs: Quantity) -> float | None:
        """A limit in the unit of the variable."""
        amount = entry.numbers.get(name)
        return None if amount is None else self.amount(f"{key}.{name}", amount, theirs.unit or amount.unit)

    def _offset(self, key: str, entry: Entry, wanted: Quantity) -> float | None:
        amount = entry.numbers.get("offset")
        return 0.0 if amount is None else self.amount(f"{key}.offset", amount, wanted.unit)


def _float(value: Any) -> float:
    """A number, as TOML has it; NaN for what is none, or too large."""
    try:
        return float(value) if isinstance(value, int | float) else math.nan
    except OverflowError:
        return math.nan


def conversion(theirs: Quantity, ours: Quantity) -> Linear | None:
    """The change of unit; a file that defines `deg` without the radian means what everybody means by it."""
    found = unit_conversion(theirs, ours)
    return unit_conversion(replace(theirs, base=None), ours) if found is None else found


def _product(factor: Amount, theirs: Quantity, wanted: Quantity) -> Linear | None:
    """The conversion where the factor has a unit: that of theirs times the factor's measures what ours does."""
    f, b, w = Quantity(factor.unit, "").base_unit, theirs.base_unit or BaseUnit({}), wanted.base_unit
    if f is None or w is None:
        return None
    exponents = {base: f.exponents.get(base, 0) + b.exponents.get(base, 0) for base in BASE_UNITS}
    if not BaseUnit(exponents).same_dimension(w):
        return None
    return Linear(b.factor * f.factor / w.factor, b.offset * f.factor / w.factor)


def _numbered(pattern: str, names: Mapping[str, Any]) -> list[str]:
    """The names that the pattern stands for, in the order of the number in the place of its star."""
    before, _, after = pattern.partition("*")
    matcher = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}")
    found = {int(m[1]): name for name in names if (m := matcher.fullmatch(name))}
    return [found[number] for number in sorted(found)]
