"""Trivial blocks that tests put systems together from."""

from __future__ import annotations

from typing import final

from components.interfaces.block import Block, NoState, Sampled, block
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from orchestrator.system.source import block_source
from orchestrator.system.system import System


@record
class Signal:
    """One number."""

    value: float = quantity("1", "a number")


@record
class In:
    """One input bus."""

    a: Signal


@record
class Out:
    """One output bus."""

    b: Signal


ANY = Socket(name="any", inputs={"a": Signal}, outputs={}, optional={})


@final
@block(ANY)
class Gain(Block[In, NoState, Out]):
    """Shows ``k a`` at once."""

    k: float = quantity("1", "gain")

    def start(self):
        return NoState()

    def output(self, x, u):
        return Out(b=Signal(value=self.k * u.a.value))

    def step(self, x, u, h):
        return x


@final
@block(ANY)
class Affine(Block[In, NoState, Out]):
    """Shows ``k a + d`` at once."""

    k: float = quantity("1", "gain")
    d: float = quantity("1", "offset")

    def start(self):
        return NoState()

    def output(self, x, u):
        return Out(b=Signal(value=self.k * u.a.value + self.d))

    def step(self, x, u, h):
        return x


@final
@block(ANY)
class Sum(Block[In, Signal, Out]):
    """Shows the sum of its inputs so far."""

    def start(self):
        return Signal(value=1.0)

    def output(self, x, u):
        return Out(b=x)

    def step(self, x, u, h):
        return Signal(value=x.value + u.a.value)


@final
@block(ANY)
class Held(Sampled[In, Signal, Out]):
    """Shows its input and how often it sampled."""

    def start(self):
        return Signal(value=0.0)

    def sample(self, x, u):
        count = Signal(value=x.value + 1)
        return count, Out(b=Signal(value=u.a.value + 1000 * count.value))


def system(units, wiring):
    return System({name: block_source(b) for name, b in units.items()}, wiring)
