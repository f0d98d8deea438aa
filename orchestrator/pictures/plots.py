"""What a person asks of a run, and the signals that answer; the viewer and the figures draw it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from orchestrator.pictures.signals import Signal, cast
from orchestrator.system.system import System

QUESTIONS: Final = (
    DID := "What did it do?",
    FELT := "What did it feel?",
    HARD := "How hard was it?",
    FAST := "How fast was it?",
)


@dataclass(frozen=True)
class Limit:
    """A constant that a signal is drawn against."""

    signal: str
    label: str
    value: float
    binds: bool = True
    """Whether reaching it is worth a line in the log; a desired value is only drawn"""


@dataclass(frozen=True)
class Plot:
    """Series that belong together: a title, full signal paths, and the limits that hold for them."""

    title: str
    signals: tuple[str, ...]
    limits: tuple[Limit, ...] = ()

    def split(self, limits: Sequence[Limit]) -> list[Plot]:
        """One plot per signal, each with its own `limits`."""
        if len(self.signals) == 1:
            return [self]
        title, _, unit = self.title.rpartition(" [")
        return [
            Plot(
                f"{title} {path.rpartition('.')[2]} [{unit}",
                (path,),
                tuple(limit for limit in limits if limit.signal == path),
            )
            for path in self.signals
        ]


def limits(system: System, signals: Sequence[Signal]) -> list[Limit]:
    """The limits of `signals` and their desired values, as the controller's parameters give them; 1 for friction."""
    who = cast(system)
    given, known = parameter_values(system, who.controller), {s.path for s in signals}
    wanted = [
        (f"{who.controller}.actuation.delta_f", "delta_max", "rad", 1),
        (f"{who.controller}.actuation.delta_f", "delta_max", "rad", -1),
        (f"{who.controller}.actuation.T_r", "T_dmax", "N.m", 1),
        (f"{who.controller}.actuation.T_r", "T_bmax", "N.m", -1),
    ]
    found = [
        Limit(path, f"{'-' * (sign < 0)}{name} [{unit}]", sign * float(given[name]))
        for path, name, unit, sign in wanted
        if name in given and path in known
    ]
    found += [Limit(path, "limit [1]", 1.0) for n in "fr" if (path := f"{who.plant}.tyre.mu_{n}") in known]
    speed = f"{who.plant}.state.v_x"
    if "v_ref" in given and speed in known:
        found.append(Limit(speed, "v_ref [m/s]", float(given["v_ref"]), binds=False))
    return found


def questions(system: System, signals: Sequence[Signal]) -> dict[str, list[Plot]]:
    """The plots of `signals` that answer each of `QUESTIONS`; what they do not hold is left out."""
    who = cast(system)
    wanted = {
        DID: [
            ("Steering delta_f", who.controller, "actuation.delta_f"),
            ("Torque T_r", who.controller, "actuation.T_r"),
        ],
        FELT: [
            ("Yaw rate r", who.plant, "state.r"),
            ("Acceleration", who.plant, "motion.a_x", "motion.a_y"),
        ],
        HARD: [("Friction share", who.plant, "tyre.mu_f", "tyre.mu_r")],
        FAST: [("Speed v_x", who.plant, "state.v_x")],
    }
    known, held = {s.path: s for s in signals}, limits(system, signals)
    found: dict[str, list[Plot]] = {}
    for question, plots in wanted.items():
        for title, unit, *names in plots:
            paths = tuple(path for name in names if (path := f"{unit}.{name}") in known)
            if paths:
                quantity = f"{title} [{known[paths[0]].variable.quantity.unit}]"
                drawn = {(limit.label, limit.value): limit for limit in reversed(held) if limit.signal in paths}
                plot = Plot(quantity, paths, tuple(drawn.values()))
                found.setdefault(question, []).append(plot)
    return found


def buses(signals: Sequence[Signal]) -> list[Plot]:
    """The signals that are numbers, grouped by unit, bus and physical unit: none is flat beside a larger one."""
    found: dict[str, list[str]] = {}
    for signal in (signal for signal in signals if signal.is_number):
        unit = signal.variable.quantity.unit
        found.setdefault(f"{signal.bus} [{unit}]" if unit else signal.bus, []).append(signal.path)
    return [Plot(bus, tuple(paths)) for bus, paths in found.items()]


def parameter_values(system: System, unit: str | None) -> Mapping[str, Any]:
    """The parameter values of a unit, its own start values where the system gives none."""
    if unit is None:
        return {}
    source = system.units[unit]
    return {**source.interface.starts, **source.parameters}


def limit_parts(limit: Limit) -> tuple[str, ...]:
    """Where a limit is drawn: root, the parts of its signal, and its side."""
    return "limits", *limit.signal.split("."), "lower" if limit.value < 0 else "upper"
