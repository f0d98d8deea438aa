"""FMUs as others make them: other names, units, axes and reference points, and inputs that ours do not have."""

from __future__ import annotations

import re
import shutil
from functools import cache
from pathlib import Path
from typing import Any, final

from lxml import etree

from components.interfaces.block import Block, block
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.maths import atan2, cos, sin, sqrt
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.runge_kutta import runge_kutta
from components.interfaces.socket import Socket
from components.interfaces.sockets import PlantInputs
from components.vehicle.bicycle import Bicycle
from fmus.export.build import build
from fmus.toolchain.version import Version
from orchestrator.scenario.catalogue import default_values
from tests.fmus.foreign import copied, entries, kept_folder

DEG = 57.29577951308232
L_R, RATIO = 1.05, 16.0
CAR = default_values(Bicycle)
README = (Path(__file__).parents[2] / "fmus" / "README.md").read_text(encoding="utf-8")
(CART,) = re.findall(r"^```modelica\n(block Cart .*?)^```$", README, re.DOTALL | re.MULTILINE)
"""The README's Modelica model with names of its own."""
(CART_MAPPING,) = re.findall(r'^```toml\n(fmu = "Cart\.mo".*?)^```$', README, re.DOTALL | re.MULTILINE)
"""Its mapping."""
START = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0, v_y=0.0, r=0.0)
UNIT_BASES = {
    "km/h": {"m": "1", "s": "-1", "factor": repr(1 / 3.6)},
    "deg": {"rad": "1", "factor": repr(1 / DEG)},
    "deg/s": {"rad": "1", "s": "-1", "factor": repr(1 / DEG)},
    "m": {"m": "1"},
    "mm": {"m": "1", "factor": "1e-3"},
    "m/s": {"m": "1", "s": "-1"},
    "m/s2": {"m": "1", "s": "-2"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
    "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "rad": {"rad": "1"},
    "rad/s": {"rad": "1", "s": "-1"},
    "kg": {"kg": "1"},
    "1": {},
}


def own_step(x: VehicleState, delta_f: float, T_r: float, h: float) -> VehicleState:
    """Our own plant's motion over `h`, in the steps that it takes."""
    car = Bicycle(**CAR)
    u = PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r))
    for _ in range(10):
        x = runge_kutta(lambda state: car.derivative(state, u), x, h / 10)
    return x


@record
class RightHandedIn:
    """What a car whose maker counts to the right reads."""

    wheel: float = quantity("1", "steering-wheel angle [deg], to the right")
    force: float = quantity("1", "force of both driven wheels [N]")


@record
class RightHandedOut:
    """Where its rear axle is."""

    east: float = quantity("1", "position along the road [m]")
    south: float = quantity("1", "position across the road, to the right [mm]")
    heading: float = quantity("1", "yaw angle to the right [deg]")
    speed: float = quantity("1", "longitudinal speed [km/h]")
    drift: float = quantity("1", "lateral speed of the rear axle to the right [m/s]")
    yaw_rate: float = quantity("1", "to the right [deg/s]")
    engine: float = quantity("1", "something of its own")


@record
class RightHandedBus:
    """One bus."""

    car: RightHandedIn


@record
class RightHandedShown:
    """One bus."""

    car: RightHandedOut


@final
@block(Socket(name="any", inputs={"car": RightHandedIn}, outputs={"car": RightHandedOut}, optional={}))
class RightHanded(Block[RightHandedBus, VehicleState, RightHandedShown]):
    """Our bicycle, with y to the right, the rear axle as reference, and the units of an instrument panel."""

    def start(self) -> VehicleState:
        """Ten metres per second along the road."""
        return START

    def output(self, x: VehicleState, u: RightHandedBus) -> RightHandedShown:
        """As its maker shows it."""
        return RightHandedShown(
            car=RightHandedOut(
                east=x.x - L_R * cos(x.psi),
                south=-1000 * (x.y - L_R * sin(x.psi)),
                heading=-DEG * x.psi,
                speed=3.6 * x.v_x,
                drift=-(x.v_y - L_R * x.r),
                yaw_rate=-DEG * x.r,
                engine=42.0,
            )
        )

    def step(self, x: VehicleState, u: RightHandedBus, h: float) -> VehicleState:
        """As ours."""
        return own_step(x, -u.car.wheel / DEG / RATIO, u.car.force * CAR["R_w"] / 2, h)


@record
class RateIn:
    """Rate and acceleration."""

    steer_rate: float = quantity("rad/s", "steering rate, to the left")
    accel: float = quantity("m/s2", "longitudinal acceleration asked for")


@record
class RateState:
    """Ours, and the steering angle."""

    body: VehicleState
    delta: float = quantity("rad", "road-wheel angle")


@record
class RateOut:
    """Speed and slip angle."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    psi: float = quantity("rad", "yaw angle")
    v: float = quantity("m/s", "speed")
    beta: float = quantity("rad", "slip angle")
    r: float = quantity("rad/s", "yaw rate")
    delta: float = quantity("rad", "road-wheel angle")


@record
class RateBus:
    """One bus."""

    u: RateIn


@record
class RateShown:
    """One bus."""

    y: RateOut


@final
@block(Socket(name="any", inputs={"u": RateIn}, outputs={"y": RateOut}, optional={}))
class RateCar(Block[RateBus, RateState, RateShown]):
    """Our bicycle, steered by a rate that acts at once for the whole step, and driven by an acceleration."""

    def start(self) -> RateState:
        """Ten metres per second along the road."""
        return RateState(body=START, delta=0.0)

    def output(self, x: RateState, u: RateBus) -> RateShown:
        """As its maker shows it."""
        b = x.body
        v, beta = sqrt(b.v_x * b.v_x + b.v_y * b.v_y), atan2(b.v_y, b.v_x)
        return RateShown(y=RateOut(x=b.x, y=b.y, psi=b.psi, v=v, beta=beta, r=b.r, delta=x.delta))

    def step(self, x: RateState, u: RateBus, h: float) -> RateState:
        """As ours, with the angle that the rate leads to."""
        delta = x.delta + h * u.u.steer_rate
        body = own_step(x.body, delta, u.u.accel * CAR["m"] * CAR["R_w"] / 2, h)
        return RateState(body=body, delta=delta)


RIGHT_HANDED_UNITS = {
    "car.wheel": "deg",
    "car.force": "N",
    "car.east": "m",
    "car.south": "mm",
    "car.heading": "deg",
    "car.speed": "km/h",
    "car.drift": "m/s",
    "car.yaw_rate": "deg/s",
}
RIGHT_HANDED = """
fmu = "theirs.fmu"
axes = "y_right"

[state]
reference = { point = "rear_axle", distance = { value = 1.05, unit = "m" } }
x = "car.east"
y = "car.south"
psi = "car.heading"
v_x = "car.speed"
v_y = "car.drift"
r = "car.yaw_rate"

[actuation]
delta_f = { variable = "car.wheel", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }
T_r = { variable = "car.force", as = "force", R_w = { value = 300, unit = "mm" } }
"""


@cache
def _built(block_type: Any, version: Version) -> Path:
    return build(block_type, version, {}, kept_folder()).path


def made(block_type: Any, folder: Path, version: Version = Version.FMI2) -> Path:
    """The FMU of a block, in `folder`; it is compiled once for all tests."""
    return Path(shutil.copy(_built(block_type, version), folder))


def right_handed(folder: Path, version: Version = Version.FMI2) -> Path:
    """`theirs.fmu` in `folder`: the right-handed car, with the units of its instruments."""
    return relabelled(_built(RightHanded, version), folder / "theirs.fmu", units=RIGHT_HANDED_UNITS)


def right_handed_mapping(folder: Path, version: Version = Version.FMI2) -> Path:
    """`theirs.toml` in `folder`, with the right-handed car beside it."""
    right_handed(folder, version)
    path = folder / "theirs.toml"
    path.write_text(RIGHT_HANDED)
    return path


def relabelled(
    source: Path,
    target: Path,
    names: dict[str, str] | None = None,
    units: dict[str, str | None] | None = None,
    *,
    silent: bool = False,
) -> Path:
    """A copy of an FMU under other names and units (by old name); a `silent` one does not declare its dependencies."""
    root = etree.fromstring(entries(source)["modelDescription.xml"])
    for variable in root.iterfind("ModelVariables/*"):
        name = variable.get("name")
        variable.set("name", (names or {}).get(name, name))
        typed = variable if root.get("fmiVersion")[0] == "3" else variable[0]
        if name in (units or {}):
            unit = (units or {})[name]
            typed.attrib.pop("unit", None)
            typed.attrib.pop("declaredType", None)
            if unit is not None:
                typed.set("unit", unit)
    known = {unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")}
    definitions = root.find("UnitDefinitions")
    for name in sorted({u for u in (units or {}).values() if u} - known):
        etree.SubElement(etree.SubElement(definitions, "Unit", name=name), "BaseUnit", UNIT_BASES[name])
    for unknown in root.iterfind("ModelStructure//*[@dependencies]"):
        if silent:
            unknown.attrib.pop("dependencies")
            unknown.attrib.pop("dependenciesKind", None)
    text = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return copied(source, target, {"modelDescription.xml": text, "terminalsAndIcons/terminalsAndIcons.xml": None})
