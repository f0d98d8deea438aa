"""From an entry of a mapping to numbers: which elements stand for the signal, and by which linear relation."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

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
from orchestrator.mapping.mapping_file import SPEED_AND_SLIP, Amount, Entry, MappingFile
from orchestrator.mapping.roles import ROLE_NUMBERS, ROLES


@dataclass
class EntryRelation:
    """An entry that names variables, on its way to a link; gathers what is wrong with it in `problems`."""

    key: str
    """What messages call the entry."""
    signal: Variable
    entry: Entry
    socket: Socket
    mapping: MappingFile
    problems: list[Problem] = field(default_factory=list[Problem])

    def link(self, offered: Sequence[Variable]) -> Link | None:
        """The link to the variables among those `offered`; `None` where the entry is wrong."""
        elements = self._places(offered)
        if elements is None:
            return None
        places, theirs = elements
        if self.entry.unit is not None:
            theirs = replace(theirs, unit=self.entry.unit, base=None)
        relation = self._relation(theirs)
        if relation is None:
            return None
        low, high = (self._limit(name, theirs) for name in ("min", "max"))
        return Link(
            self.signal.name,
            places,
            relation,
            -math.inf if low is None else low,
            math.inf if high is None else high,
        )

    def rate_input(self, link: Link, shown: Sequence[Variable]) -> RateInput | None:
        """The input that takes the rate of the signal by `link`, with the FMU's own value where it is `shown`."""
        limit = self._role_number("limit")
        bound = math.inf if limit is None else limit
        if self.entry.angle is None:
            return RateInput(link, None, bound)
        present = replace(self, key=f"{self.key}.angle", entry=Entry(variables=(self.entry.angle,))).link(shown)
        return None if present is None else RateInput(link, present, bound)

    def _wrong(self, found: str, valid: str, remedy: str = "", part: str = "") -> None:
        self.problems.append(Problem(f"{self.key}{part}", found, valid, remedy))

    def _places(self, offered: Sequence[Variable]) -> tuple[tuple[VariableElement, ...], Quantity] | None:
        """The elements that the entry names, and what they are."""
        known = {v.name: v for v in offered}
        elements = {e: (v.name, i) for v in offered for i, e in enumerate(v.elements)}
        places: list[VariableElement] = []
        for name in self.entry.variables:
            if name in known:
                places += [(name, i) for i in range(known[name].size)]
            elif name in elements:
                places.append(elements[name])
            elif "*" in name and (several := _numbered(name, elements)):
                places += [elements[element] for element in several]
            else:
                remedy = did_you_mean(name, [*known, *elements])
                self._wrong(f"the unknown variable `{name}`", choices(known), remedy)
                return None
        shape = self.signal.shape
        size = shape[0] if shape else 1
        partial = self.socket.bus(self.signal.name).partial
        if len(places) == size or (places and (size == ANY_LENGTH or (partial and len(places) < size))):
            return tuple(places), known[places[0][0]].quantity
        valid = f"{'up to ' * partial}{size} elements" if shape else "1 element"
        self._wrong(f"{len(places)} elements in {', '.join(f'`{n}`' for n in self.entry.variables)}", valid)
        return None

    def _relation(self, theirs: Quantity) -> Linear | None:
        """The conversion from theirs to ours: units of measurement, factor, offset, axes and role in one."""
        if not self.signal.quantity.type.is_float:
            return self._plain(theirs)
        role = ROLES.get(self.entry.role or "")
        wanted = replace(self.signal.quantity, unit=role.unit if role else unit_given(self.signal, self.mapping))
        if not theirs.type.is_float and self.entry.unit is None:
            theirs = replace(theirs, unit="")
        factor = self.entry.numbers.get("factor", Amount(1.0))
        converted = conversion(theirs, wanted) if factor.unit == "1" else _product(factor, theirs, wanted)
        names = [name for name in role.numbers if ROLE_NUMBERS[name].required] if role else []
        numbers = {name: number for name in names if (number := self._role_number(name)) is not None}
        offset = self._offset(wanted)
        if converted is None:
            self._other_dimension(theirs, wanted, factor)
            return None
        if offset is None or len(numbers) < len(names):
            return None
        scale = role.scale(numbers) if role else 1.0
        value = _float(factor.value)
        if value == 0 or scale == 0 or not math.isfinite(value * scale):
            self._wrong(f"{value:g}", "a finite number other than 0", part=".factor")
            return None
        sign = -1.0 if self.mapping.axes == "y_right" and self.signal.name.partition(".")[2] in LEFTWARD else 1.0
        whole = Linear(sign * value, sign * offset).after(converted)
        return Linear(whole.factor / scale, whole.offset / scale) if scale != 1 else whole

    def _other_dimension(self, theirs: Quantity, wanted: Quantity, factor: Amount) -> None:
        found = f"{', '.join(f'`{n}`' for n in self.entry.variables)}: {describe(theirs)}"
        if factor.unit != "1":
            self._wrong(f"{found}, times a factor in `{factor.unit}`", f"`{wanted.unit}`")
            return
        remedy = 'If the FMU declares its unit wrongly, say unit = "..." in a mapping file.'
        self._wrong(found, f"a unit that converts to `{wanted.unit}`", remedy)

    def _plain(self, theirs: Quantity) -> Linear | None:
        """Booleans, integers and enumerations have no unit of measurement; a number may stand for them."""
        ours = self.signal.quantity
        items = [q.enumeration.values if q.enumeration else {} for q in (theirs, ours)]
        if ours.type is Type.ENUMERATION and items[0] and items[0] != items[1]:
            self._wrong(f"the enumeration {items[0]}", str(items[1]))
            return None
        return IDENTITY

    def _role_number(self, name: str) -> float | None:
        """A number of the role in its unit of measurement; `None` where there is none, or a wrong one."""
        amount = self.entry.numbers.get(name)
        if amount is None:
            return None
        return amount_in(ROLE_NUMBERS[name].unit, f"{self.key}.{name}", amount, self.problems, positive=True)

    def _limit(self, name: str, theirs: Quantity) -> float | None:
        """A limit in the unit of measurement of the variable."""
        amount = self.entry.numbers.get(name)
        if amount is None:
            return None
        return amount_in(theirs.unit or amount.unit, f"{self.key}.{name}", amount, self.problems)

    def _offset(self, wanted: Quantity) -> float | None:
        amount = self.entry.numbers.get("offset")
        return 0.0 if amount is None else amount_in(wanted.unit, f"{self.key}.offset", amount, self.problems)


def amount_in(unit: str, key: str, amount: Amount, problems: list[Problem], *, positive: bool = False) -> float | None:
    """A number of a mapping file in another unit of measurement.

    Args:
        unit: The unit of measurement that is wanted.
        key: What messages call the number.
        amount: The number, with its own unit of measurement.
        problems: Receives a problem where the number cannot be converted, or is not finite.
        positive: Whether the number must be greater than 0.

    Returns:
        The number; `None` where it is wrong.
    """
    to_unit = unit_conversion(Quantity(amount.unit, ""), Quantity(unit, ""))
    if to_unit is None or not amount.unit:
        problems.append(Problem(key, f"unit `{amount.unit}`", f"a unit that converts to `{unit}`"))
        return None
    value = float(to_unit(_float(amount.value)))
    if not math.isfinite(value) or (positive and value <= 0):
        found = f"{amount.value}" if isinstance(amount.value, int | float) else f"`{amount.value}`"
        problems.append(Problem(key, found, f"a {'positive' if positive else 'finite'} number"))
        return None
    return value


def unit_given(signal: Variable, mapping: MappingFile) -> str:
    """The unit of measurement in which a file gives a signal: ours, or that of the slip angle in place of `v_y`."""
    bus, _, leaf = signal.name.partition(".")
    slip_angle = leaf == "v_y" and mapping.velocities.get(bus) == SPEED_AND_SLIP
    return "rad" if slip_angle else signal.quantity.unit


def conventions(bus: str, mapping: MappingFile, problems: list[Problem]) -> Iterator[Convention]:
    """The conventions by which the FMU gives a bus, in the order in which they are applied to reach ours.

    Args:
        bus: The bus.
        mapping: The mapping.
        problems: Receives a problem for a wrong distance of a reference point.
    """
    velocity = mapping.velocities.get(bus)
    if velocity == SPEED_AND_SLIP:
        yield SpeedAndSlip()
    elif velocity == "road":
        yield RoadFrameVelocity()
    point, amount = mapping.references.get(bus, ("", None))
    if amount is not None:
        distance = amount_in("m", f"{mapping.where}: {bus}.reference.distance", amount, problems)
        if distance is not None:
            yield ReferencePoint(-distance if point == "rear_axle" else distance)
    elif point in {"rear_bumper", "front_bumper"}:
        yield BoxEnd(-0.5 if point == "rear_bumper" else 0.5)


def _float(value: Any) -> float:
    """A number as TOML has it; NaN for what is no number, or too large for a float."""
    try:
        return float(value) if isinstance(value, int | float) else math.nan
    except OverflowError:
        return math.nan


def conversion(theirs: Quantity, ours: Quantity) -> Linear | None:
    """The change of unit of measurement; a file that defines `deg` without the radian still means degrees."""
    direct = unit_conversion(theirs, ours)
    return unit_conversion(replace(theirs, base=None), ours) if direct is None else direct


def _product(factor: Amount, theirs: Quantity, wanted: Quantity) -> Linear | None:
    """The conversion by a factor with a unit of measurement; None where the product has another dimension than ours."""
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
    by_number = {int(m[1]): name for name in names if (m := matcher.fullmatch(name))}
    return [by_number[number] for number in sorted(by_number)]
