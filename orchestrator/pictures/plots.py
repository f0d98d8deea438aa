"""The questions about a run, and the signals that answer them, as the viewer and the figures draw them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from components.interfaces.buses import Actuation, Motion, Tyre, VehicleState
from components.interfaces.record import variables
from orchestrator.pictures.signals import Signal
from orchestrator.system.shown import BusPaths, parameter_values, shown, signal_path, unit_that_shows
from orchestrator.system.system import System

QUESTIONS: Final = (
    DID := "What did it do?",
    FELT := "What did it feel?",
    HARD := "How hard was it?",
    FAST := "How fast, how near?",
)

_SHARES: Final = ("mu_f", "mu_r")
"""The signals of `tyre` that are limited to 1."""

_ANSWERS: Final = (
    (DID, "Steering", Actuation, ("delta_f",)),
    (DID, "Torque", Actuation, ("T_r",)),
    (DID, "Place across the road", VehicleState, ("y",)),
    (FELT, "Yaw rate", VehicleState, ("r",)),
    (FELT, "Acceleration", Motion, ("a_x", "a_y")),
    (HARD, "Friction share", Tyre, _SHARES),
    (FAST, "Speed", VehicleState, ("v_x",)),
)
"""A question, the name of a quantity that answers it, and the bus and its signals that show it."""

_ACTUATION_LIMITS: Final = (
    ("delta_f", "delta_max", 1, False),
    ("delta_f", "delta_max", -1, False),
    ("T_r", "T_dmax", 1, True),
    ("T_r", "T_bmax", -1, True),
)
"""A signal of `actuation`, the controller's parameter that limits it, the side of the limit, and whether it is near."""


@dataclass(frozen=True)
class Limit:
    """A constant that a signal is drawn against."""

    signal: Signal
    name: str
    """What the limit is called, with a minus sign where its value is the negative of a parameter."""
    unit: str
    """Unit of measurement."""
    value: float
    binds: bool = True
    """Whether reaching it is an event; a desired value is only drawn."""
    is_near: bool = True
    """Whether the signal usually comes near it; the viewer would show the signal flat beside one that is far away."""

    @property
    def label(self) -> str:
        """Name and unit of measurement."""
        return titled(self.name, self.unit)


@dataclass(frozen=True)
class Plot:
    """Series that belong together, and the limits that hold for them."""

    quantity: str
    """What is drawn."""
    unit: str | None
    """The unit of measurement of all series; None where none is shown."""
    signals: tuple[Signal, ...]
    limits: tuple[Limit, ...] = ()

    @property
    def title(self) -> str:
        """Quantity, the signal if it is a single one, and unit of measurement."""
        name = f" {self.signals[0].name}" if len(self.signals) == 1 else ""
        return titled(f"{self.quantity}{name}", self.unit)

    def split(self, limits: Sequence[Limit]) -> list[Plot]:
        """One plot per signal, each with those of the `limits` that are its own."""
        if len(self.signals) == 1:
            return [self]
        return [
            Plot(
                self.quantity,
                self.unit,
                (signal,),
                tuple(limit for limit in limits if limit.signal.path == signal.path),
            )
            for signal in self.signals
        ]


def titled(quantity: str, unit: str | None) -> str:
    """A title: the quantity, and its unit of measurement in brackets unless it is None."""
    return quantity if unit is None else f"{quantity} [{unit}]"


def limits(system: System, signals: Sequence[Signal]) -> list[Limit]:
    """What is known to limit the signals of a run.

    Args:
        system: The system; the parameters of its controller give the limits of the actuation and the desired speed.
        signals: The signals that are recorded.

    Returns:
        The limits and desired values of these signals, among them 1 for the shares of the friction limit.
    """
    buses, known = shown(system), {s.path: s for s in signals}
    given = parameter_values(system, unit_that_shows(buses, Actuation))
    limiting = [
        Limit(
            signal,
            f"{'-' * (side < 0)}{name}",
            _unit(Actuation, signal.name),
            side * float(given[name]),
            is_near=is_near,
        )
        for actuated, name, side, is_near in _ACTUATION_LIMITS
        if name in given and (signal := known.get(signal_path(buses, Actuation, actuated)))
    ]
    limiting += [
        Limit(signal, "limit", _unit(Tyre, signal.name), 1.0) for signal in _known(known, buses, Tyre, _SHARES)
    ]
    if "v_ref" in given and (speed := known.get(signal_path(buses, VehicleState, "v_x"))):
        limiting.append(Limit(speed, "v_ref", _unit(VehicleState, "v_x"), float(given["v_ref"]), binds=False))
    return limiting


def questions(system: System, signals: Sequence[Signal]) -> dict[str, list[Plot]]:
    """The plots that answer each of `QUESTIONS`.

    Args:
        system: The system.
        signals: The signals that are recorded; what cannot be answered from them is left out.

    Returns:
        The plots, by question.
    """
    buses, known, held = shown(system), {s.path: s for s in signals}, limits(system, signals)
    answers: dict[str, list[Plot]] = {}
    for question, quantity, record, names in _ANSWERS:
        drawn = _known(known, buses, record, names)
        if drawn:
            paths = {signal.path for signal in drawn}
            lines = {(limit.label, limit.value): limit for limit in reversed(held) if limit.signal.path in paths}
            plot = Plot(quantity, drawn[0].unit_of_measurement, drawn, tuple(lines.values()))
            answers.setdefault(question, []).append(plot)
    return answers


def by_bus(signals: Sequence[Signal]) -> list[Plot]:
    """The signals that are numbers, grouped by bus and by unit of measurement, so that series are of similar size.

    Args:
        signals: The signals that are recorded.
    """
    groups: dict[tuple[str, str | None], list[Signal]] = {}
    for signal in (signal for signal in signals if signal.is_number):
        groups.setdefault((signal.bus, signal.unit_of_measurement or None), []).append(signal)
    return [Plot(bus, unit, tuple(group)) for (bus, unit), group in groups.items()]


def limit_parts(limit: Limit) -> tuple[str, ...]:
    """The parts of the entity path of a limit: the root, the parts of its signal, and its side."""
    return "limits", *limit.signal.parts, "lower" if limit.value < 0 else "upper"


def _known(known: Mapping[str, Signal], buses: BusPaths, record: type, names: Sequence[str]) -> tuple[Signal, ...]:
    """Those signals of a bus that are known, in the order of their names."""
    paths = [signal_path(buses, record, name) for name in names]
    return tuple(known[path] for path in paths if path in known)


def _unit(record: type, name: str) -> str:
    """The unit of measurement that a bus declares for a signal."""
    return next(variable.quantity.unit for variable in variables(record) if variable.name == name)
