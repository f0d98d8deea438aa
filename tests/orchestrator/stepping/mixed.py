"""Blocks with signals of all types, which random systems are put together from."""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from typing import final

from components.interfaces.block import Block, NoState, Sampled, block
from components.interfaces.maths import Array, vector, where
from components.interfaces.quantity import boolean, enumeration, integer, quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from fmus.export.build import build
from orchestrator.system.source import Fmu, block_source
from tests.fmus.foreign import kept_folder


class Colour(IntEnum):
    """Three items."""

    RED = 1
    GREEN = 2
    BLUE = 3


@record
class Mixed:
    """A number, three of them, a speed, a count, three flags and a colour."""

    a: float = quantity("1", "a number")
    v: Array = quantity("1", "three numbers", shape=(3,))
    s: float = quantity("m/s", "a speed")
    n: int = integer("a count")
    b: Array = boolean("three flags", shape=(3,))
    c: Colour = enumeration(Colour, "a colour")


@record
class MixedIn:
    """What goes in."""

    u: Mixed


@record
class MixedOut:
    """What comes out."""

    y: Mixed


@record
class Two:
    """Two numbers."""

    a: float = quantity("1", "a number")
    n: float = quantity("1", "a number")


ANY = Socket(name="any", inputs={"u": Mixed}, outputs={}, optional={"y": Mixed})


def shown(u, a, n):
    """What all of them show, of two numbers and of what goes in."""
    v = u.v
    return MixedOut(
        y=Mixed(
            a=a,
            v=vector([v[2], 0.3 * v[0] + a, v[1]]),
            s=0.3 * u.s + a,
            n=where(n > 1000, 0, n),
            b=vector([u.b[1], a > 0.5, u.b[0]]),
            c=where(a > 0.5, 3, u.c),
        )
    )


@final
@block(ANY)
class Through(Block[MixedIn, NoState, MixedOut]):
    """Shows what it reads, changed, at once."""

    def start(self):
        return NoState()

    def output(self, x, u):
        return shown(u.u, 0.7 * u.u.a + 0.1, u.u.n)

    def step(self, x, u, h):
        return x


@final
@block(ANY)
class Follows(Block[MixedIn, Two, MixedOut]):
    """Shows numbers that follow what it reads; the rest at once."""

    def start(self):
        return Two(a=0.25, n=2.0)

    def output(self, x, u):
        return shown(u.u, x.a, x.n)

    def step(self, x, u, h):
        return Two(a=x.a + h * (u.u.a + u.u.s - x.a), n=x.n + 1)


@final
@block(ANY)
class Acts(Sampled[MixedIn, Two, MixedOut]):
    """Acts at its samples."""

    def start(self):
        return Two(a=0.0, n=0.0)

    def sample(self, x, u):
        later = Two(a=0.5 * x.a + u.u.a, n=x.n + u.u.n)
        return later, shown(u.u, later.a, later.n)


KINDS = {"through": Through, "follows": Follows, "acts": Acts}


@cache
def made(kind, version):
    """A source of a kind: the FMU of a version, or the block in this process for `None`."""
    cls = KINDS[kind]
    return block_source(cls()) if version is None else Fmu(build(cls, version, {}, kept_folder()).path)
