"""What a person asks of a run, and the signals that answer; the viewer and the figures draw it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from orchestrator.pictures import cast, signals
from orchestrator.system import System


@dataclass(frozen=True)
class Limit:
    """A constant that a signal is drawn against."""

    signal: str
    label: str
    value: float


@dataclass(frozen=True)
class Plot:
    """Series that belong together: a title, full signal paths, and the limits that hold for them."""

    title: str
    signals: tuple[str, ...]
    limits: tuple[Limit, ...] = ()

    @property
    def quantity(self) -> str:
        """The title without its question: what is on the vertical axis."""
        return self.title.rpartition("? ")[2]


def limits(system: System) -> list[Limit]:
    """The limits that the controller's parameters give, and the friction limit where its use is known."""
    who = cast(system)
    given, known = parameter_values(system, who.controller), {s.path for s in signals(system)}
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
    friction = f"{who.plant}.tyre.mu_f"
    return [*found, Limit(friction, "limit [1]", 1.0)] if friction in known else found


def questions(system: System) -> list[Plot]:
    """What did it do, what did it feel, how hard was it, how fast; two rows of one column each.

    What the system does not have is left out.
    """
    who = cast(system)
    wanted = [
        ("What did it do? Steering delta_f [rad]", who.controller, ["actuation.delta_f"]),
        ("What did it feel? Yaw rate r [rad/s]", who.plant, ["state.r"]),
        ("How hard was it? Share of friction limit [1]", who.plant, ["tyre.mu_f", "tyre.mu_r"]),
        ("How fast was it? Speed v_x [m/s]", who.plant, ["state.v_x"]),
        ("What did it do? Torque T_r [N.m]", who.controller, ["actuation.T_r"]),
        ("What did it feel? Acceleration [m/s2]", who.plant, ["motion.a_x", "motion.a_y"]),
    ]
    known, held = {s.path for s in signals(system)}, limits(system)
    found: list[Plot] = []
    for title, unit, names in wanted:
        paths = tuple(path for name in names if (path := f"{unit}.{name}") in known)
        if paths:
            found.append(Plot(title, paths, tuple(limit for limit in held if limit.signal in paths)))
    return found


def buses(system: System) -> list[Plot]:
    """All signals, grouped by unit, bus and physical unit, so that none is flat beside a larger one."""
    found: dict[str, list[str]] = {}
    for signal in signals(system):
        found.setdefault(f"{signal.bus} [{signal.variable.quantity.unit}]", []).append(signal.path)
    return [Plot(bus, tuple(paths)) for bus, paths in found.items()]


def has_path_error(system: System) -> bool:
    """Whether there are a vehicle and a path to compare."""
    who = cast(system)
    known = {s.path for s in signals(system)}
    return {f"{who.plant}.state.x", f"{who.controller}.path.x"} <= known


def parameter_values(system: System, unit: str | None) -> Mapping[str, Any]:
    """The parameter values of a unit, its own start values where the system gives none."""
    if unit is None:
        return {}
    source = system.units[unit]
    return {**source.interface.starts, **source.parameters}


def limit_parts(limit: Limit) -> tuple[str, ...]:
    """Where a limit is drawn: root, the parts of its signal, and its side."""
    return "limits", *limit.signal.split("."), "lower" if limit.value < 0 else "upper"
