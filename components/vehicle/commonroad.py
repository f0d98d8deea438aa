"""What the vehicles of the package commonroad-vehicle-models share: our actuation, a stop, and the integration.

    v_delta = (delta_f - delta) / T_delta        a = 2 T_r / (m R_w)                                      (1)

Their inputs are the velocity v_delta of the steering angle, which their own limits bound (0.4 rad/s), and the
longitudinal acceleration a. A first-order servo gives the first from our steering angle; the drive force of two rear
wheels gives the second, with the mass and the wheel radius of the parameter set.

The models are not valid for v < 0: a vehicle that brakes stops at v = 0 and stands until it is driven again.
"""
# pyright: basic
# The package carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.util import find_spec
from itertools import count
from typing import Any, ClassVar, TypeVar

import numpy as np

from components.interfaces.block import Block
from components.interfaces.buses import Motion, VehicleState
from components.interfaces.callback import Callback
from components.interfaces.maths import Array, is_symbolic, vector
from components.interfaces.quantity import integer, quantity
from components.interfaces.record import pack, record, size, unpack, variables
from components.interfaces.sockets import PlantInputs

_X = TypeVar("_X")
RELATIVE, ABSOLUTE = 1e-6, 1e-6
"""Tolerances of the integration; much finer ones cause tiny steps at the discontinuity at `KINEMATIC`."""
MOST_CALLS = 20000
"""Evaluations after which a step ends as not a number; hard braking to a stop takes 2000."""
KINEMATIC = 0.1
"""[m/s] Below this speed the package's models are kinematic, and their tyres carry no force. Wheels roll there in our
models, because the package lets the brakes lock them and the engine spin them up."""


def installed() -> bool:
    """Whether the package commonroad-vehicle-models is installed."""
    return find_spec("vehiclemodels") is not None


@record
class CommonRoadOutputs:
    """The buses that these vehicles show."""

    state: VehicleState
    motion: Motion


@dataclass(frozen=True)
class Dynamics:
    """A model of the package: its functions, and which variables of its state have a special part in a stop."""

    state: type
    """The state as a record, in the package's order."""
    start: Callable[[Sequence[float], Any], Sequence[float]]
    """``start([x, y, delta, v, psi, r, beta], parameters) -> x``"""
    slope: Callable[[list[float], Sequence[float], Any], Sequence[float]]
    """``slope(x, [v_delta, a], parameters) -> dx/dt``"""
    speed: str
    moving: tuple[str, ...]
    """The variables that are zero at standstill, in addition to the speed."""
    wheels: tuple[str, ...] = ()
    """Wheel speeds, which do not become negative."""
    steering: str = "delta"

    @cached_property
    def places(self) -> dict[str, int]:
        """The index of each variable in the column of the state."""
        return {v.name: i for i, v in enumerate(variables(self.state))}

    def at(self, *names: str) -> list[int]:
        """The indices of these variables in the column of the state."""
        return [self.places[name] for name in names]


@record
class CommonRoadVehicle(Block[PlantInputs, _X, CommonRoadOutputs]):
    """The equations are calls of the package."""

    native: ClassVar[bool] = False
    staged: ClassVar[bool] = True

    vehicle: int = integer("parameter set of the package: 1 Ford Escort, 2 BMW 320i, 3 VW Vanagon", min=1, max=3)
    T_delta: float = quantity("s", "time constant of the steering servo", min=1e-3)
    x_start: float = quantity("m", "initial position along the road")
    y_start: float = quantity("m", "initial position across the road")
    psi_start: float = quantity("rad", "initial yaw angle")
    v_x_start: float = quantity("m/s", "initial longitudinal speed", min=0)
    v_y_start: float = quantity("m/s", "initial lateral speed")
    r_start: float = quantity("rad/s", "initial yaw rate")

    @staticmethod
    @abstractmethod
    def dynamics() -> Dynamics:
        """The model; this imports the package."""

    @abstractmethod
    def shown(self, x: _X) -> VehicleState:
        """The bus `state`."""

    @abstractmethod
    def moved(self, x: _X, dx: _X) -> Motion:
        """The bus `motion`, from the state and its slope."""

    def start(self) -> _X:
        """Straight wheels, and the speeds of the parameters."""
        return self._state(self._called(_start, pack(self), sizes=(size(type(self)),)))

    def output(self, x: _X, u: PlantInputs) -> CommonRoadOutputs:
        """State and accelerations with the actuation of this instant."""
        dx = self._state(self._called(_slope, pack(x), pack(u), pack(self), sizes=self._sizes()))
        return CommonRoadOutputs(state=self.shown(x), motion=self.moved(x, dx))

    def step(self, x: _X, u: PlantInputs, h: float) -> _X:
        """Integrated by LSODA: wheels that turn slowly are stiff."""
        sizes = (*self._sizes(), 1)
        return self._state(self._called(_step, pack(x), pack(u), pack(self), vector([h]), sizes=sizes))

    def _sizes(self) -> tuple[int, ...]:
        return tuple(size(kind) for kind in (self.state_type, self.input_type, type(self)))

    def _state(self, column: Array) -> _X:
        return unpack(self.state_type, column)

    def _called(self, function: Callable[..., Array], *columns: Array, sizes: tuple[int, ...]) -> Array:
        if any(map(is_symbolic, columns)):
            return _callback(type(self), function, sizes, size(self.state_type))(*columns)
        return function(self.dynamics(), *columns)


@cache
def _callback(kind: type[CommonRoadVehicle[Any]], function: Any, sizes: tuple[int, ...], n: int) -> Any:
    return Callback(function.__name__.strip("_"), lambda *columns: [function(kind.dynamics(), *columns)], sizes, [n])


@cache
def _parameters(vehicle: int) -> Any:
    """A parameter set of the package."""
    from vehiclemodels.vehicle_parameters import setup_vehicle_parameters  # noqa: PLC0415 - an extra, and slow

    return setup_vehicle_parameters(vehicle_id=vehicle)


def _start(model: Dynamics, p: Array) -> Array:
    vehicle, _, x, y, psi, v_x, v_y, r = p
    core = [x, y, 0.0, float(np.hypot(v_x, v_y)), psi, r, float(np.arctan2(v_y, v_x))]
    return np.array(model.start(core, _parameters(int(vehicle))), dtype=float)


def _slope(model: Dynamics, x: Array, u: Array, p: Array) -> Array:
    """dx/dt with our actuation."""
    return _rate(model, x, u, p, held=_stands(model, x, u))


def _stands(model: Dynamics, x: Array, u: Array) -> bool:
    """Whether the vehicle stands, and is not driven."""
    _, T_r = u
    return bool(x[model.places[model.speed]] <= 0 and T_r <= 0)


def _rate(model: Dynamics, x: Array, u: Array, p: Array, *, held: bool) -> Array:
    """dx/dt; of a vehicle that is held, zero but for the steering; not a number where the model has none."""
    vehicle, T_delta = _parameters(int(p[0])), p[1]
    delta_f, T_r = u
    steering, speed = model.at(model.steering, model.speed)
    v_delta, a = (delta_f - x[steering]) / T_delta, 2 * T_r / (vehicle.m * vehicle.R_w)  # (1)
    try:
        slope = np.array(model.slope(x.tolist(), (v_delta, a), vehicle))
    except (ArithmeticError, ValueError):  # the package divides by speeds, and takes sines of what is not finite
        return np.full_like(x, np.nan)
    if model.wheels and abs(x[speed]) < KINEMATIC:
        slope[model.at(*model.wheels)] = slope[speed] / vehicle.R_w
    return np.where(np.arange(x.size) == steering, slope, 0.0) if held else slope


def _step(model: Dynamics, x: Array, u: Array, p: Array, h: Array) -> Array:
    """The state after `h` seconds; the vehicle is held from the instant at which its speed becomes zero."""
    end, held = float(h[0]), _stands(model, x, u)
    try:
        x, t = _integrated(model, x, u, p, (0.0, end), held=held)
        if t < end:
            x[model.at(model.speed, *model.moving)] = 0.0
            x, _ = _integrated(model, x, u, p, (t, end), held=True)
    except ArithmeticError:
        return np.full_like(x, np.nan)
    never_back = model.at(model.speed, *model.wheels)
    x[never_back] = np.maximum(x[never_back], 0.0)
    return x


def _integrated(  # noqa: PLR0913 - what a span of the motion depends on
    model: Dynamics, x: Array, u: Array, p: Array, span: tuple[float, float], *, held: bool
) -> tuple[Array, float]:
    """The state at the end of a span, or where a vehicle that is not held stops. Raises `ArithmeticError`."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 - slow to import, and only this needs it

    calls = count(1)

    def slope(_: float, x: Array) -> Array:
        rate = _rate(model, x, u, p, held=held)
        if not np.isfinite(rate).all() or next(calls) > MOST_CALLS:
            raise ArithmeticError
        return rate

    def speed(_: float, x: Array) -> float:
        return x[model.places[model.speed]]

    speed.terminal, speed.direction = True, -1  # type: ignore[attr-defined]
    events = None if held else speed
    run = solve_ivp(slope, span, x, "LSODA", events=events, rtol=RELATIVE, atol=ABSOLUTE)
    if not run.success:
        raise ArithmeticError(run.message)
    return run.y[:, -1], run.t[-1]
