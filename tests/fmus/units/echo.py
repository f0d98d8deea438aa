"""A block that shows what it reads: the foreign unit behind whatever is translated."""

# Without deferred annotations: the records are made of the one that is given.

from typing import final

from components.interfaces.block import Block, NoState, block
from components.interfaces.record import record
from components.interfaces.socket import Socket


def echo(numbers):
    """The class of a block with the inputs `u` and the outputs `y`, both records of the type `numbers`."""

    @record
    class EchoIn:
        """What goes in."""

        u: numbers

    @record
    class EchoOut:
        """What comes out."""

        y: numbers

    @final
    @block(Socket(name="any", inputs={"u": numbers}, outputs={}, optional={"y": numbers}))
    class Echo(Block[EchoIn, NoState, EchoOut]):
        """What goes in comes out."""

        def start(self):
            return NoState()

        def output(self, x, u):
            return EchoOut(y=u.u)

        def step(self, x, u, h):
            return x

    return Echo
