"""Large systems for tests of growth: units in rings, with as many connections as a test wants."""

from __future__ import annotations

from pathlib import Path
from typing import final

from components.interfaces.block import Block, block
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from orchestrator.system.source import block_source
from orchestrator.system.system import System
from tests.orchestrator.ssps import body, component, connectors, echo, wire, write

PORTS = "abcdefghij"


@record
class Numbers:
    """Ten numbers."""

    a: float = quantity("1", "a number")
    b: float = quantity("1", "a number")
    c: float = quantity("1", "a number")
    d: float = quantity("1", "a number")
    e: float = quantity("1", "a number")
    f: float = quantity("1", "a number")
    g: float = quantity("1", "a number")
    h: float = quantity("1", "a number")
    i: float = quantity("1", "a number")
    j: float = quantity("1", "a number")


@record
class NumbersIn:
    """One bus."""

    u: Numbers


@record
class NumbersOut:
    """One bus."""

    y: Numbers


@final
@block(Socket(name="any", inputs={"u": Numbers}, outputs={"y": Numbers}, optional={}))
class Mean(Block[NumbersIn, Numbers, NumbersOut]):
    """Each number goes half of the way to what it reads."""

    first: float = quantity("1", "the start value of all numbers")

    def start(self) -> Numbers:
        """All alike."""
        return Numbers(**dict.fromkeys(PORTS, self.first))

    def output(self, x: Numbers, u: NumbersIn) -> NumbersOut:
        """The numbers."""
        return NumbersOut(y=x)

    def step(self, x: Numbers, u: NumbersIn, h: float) -> Numbers:
        """Half of the way."""
        return Numbers(**{n: (getattr(x, n) + getattr(u.u, n)) / 2 for n in PORTS})


def source_of(unit: int, port: int, units: int) -> int:
    """The unit that drives a port of another: ten different ones for the ten ports."""
    return (unit + 7 * port + 1) % units


def of_blocks(units: int, *, turned: bool = False) -> System:
    """A system with ten connections for each unit, each from another one.

    Args:
        units: How many units it has.
        turned: Whether the units stand in the opposite order.
    """
    names = [f"u{k}" for k in range(units)]
    sources = {name: block_source(Mean(first=float(k))) for k, name in enumerate(names)}
    wires = {
        f"u{k}.u.{port}": f"u{source_of(k, i, units)}.y.{port}" for k in range(units) for i, port in enumerate(PORTS)
    }
    order = names[::-1] if turned else names
    return System({name: sources[name] for name in order}, wires)


def ssp_of_units(folder: Path, units: int) -> Path:
    """An SSP with ten connections for each unit, each from another one."""
    fmu = echo(folder / "unit.fmu", [f"u{i}" for i in range(10)])
    ports = connectors(*[f"u{i}:input" for i in range(10)], *[f"y_u{i}:output" for i in range(10)])
    wires = [wire(f"c{source_of(k, i, units)}.y_u{i}", f"c{k}.u{i}") for k in range(units) for i in range(10)]
    elements = "".join(component(f"c{k}", "unit.fmu", ports) for k in range(units))
    return write(folder / f"{units}.ssp", body(elements, "".join(wires)), {"resources/unit.fmu": fmu})
