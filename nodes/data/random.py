"""Random numbers (`omni.graph.nodes`).

Without `useSeed` they come from the session's seed and the node's prim path, so a run gives the same again. With it they come
from the node's own seed alone: two nodes of one seed give the same numbers. `isNoise` gives one number for each seed, always.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, State, UInt64
from graphengine.nodes.data.broadcast import Operand, Operation, lift
from graphengine.nodes.data.elementwise import TypedNode
from graphengine.nodes.data.unions import DECIMALS, NUMERICS


class RandomNode(Node):
    """A node that gives the next random value whenever it is executed."""

    exec_in = ExecIn()
    seed: UInt64 = In(default=0, doc="used with useSeed, and with isNoise")
    use_seed: bool = In(
        default=False, doc="numbers come from the seed alone; else from the session's and the node's path"
    )
    is_noise: bool = In(default=False, doc="the same number at every execution, as long as the seed stays")
    exec_out = ExecOut()

    common_numbers: np.random.Generator = Bound()
    own: tuple[int, np.random.Generator] | None = State(default=None)

    def setup(self, context: Context) -> None:
        """Bind the session's random numbers."""
        self.common_numbers = context.random()

    def generator(self) -> np.random.Generator:
        """Where the next value comes from."""
        if self.is_noise:
            return np.random.Generator(np.random.Philox(key=self.seed))
        if not self.use_seed:
            return self.common_numbers
        if self.own is None or self.own[0] != self.seed:
            self.own = (self.seed, np.random.Generator(np.random.Philox(key=self.seed)))
        return self.own[1]


class RandomBoolean(RandomNode, type="omni.graph.nodes.RandomBoolean"):
    """True or false, as likely the one as the other."""

    random: bool = Out()

    def compute(self) -> None:
        """Draw."""
        self.random = bool(self.generator().integers(2))


class RandomUnitVector(RandomNode, type="omni.graph.nodes.RandomUnitVector"):
    """A direction in space; every one is as likely."""

    random: Any = Out(type="vectorf[3]", doc="of length 1")

    def compute(self) -> None:
        """Draw."""
        self.random = unit(self.generator(), 3)


class RandomUnitQuaternion(RandomNode, type="omni.graph.nodes.RandomUnitQuaternion"):
    """An orientation in space; every one is as likely."""

    random: Any = Out(type="quatf[4]", doc="(x, y, z, w), of length 1")

    def compute(self) -> None:
        """Draw."""
        self.random = unit(self.generator(), 4)


def unit(generator: np.random.Generator, size: Literal[3, 4]) -> tuple[float, ...]:
    """A point of the unit sphere: where a normal distribution, which has no preferred direction, points to."""
    vector = generator.normal(size=size)
    return tuple((vector / np.linalg.norm(vector)).tolist())


class RandomNumeric(TypedNode, RandomNode, type="omni.graph.nodes.RandomNumeric"):
    """A number between two others, or a tuple or an array of such."""

    minimum: Any = In(type=NUMERICS, name="min", default=0, doc="the lowest number")
    maximum: Any = In(type=NUMERICS, name="max", default=1.0, doc="the highest whole number; real ones stay below it")
    random: Any = Out(type=NUMERICS, doc="single numbers go with tuples and arrays, as those of sums do")

    def compute(self) -> None:
        """Draw.

        Raises:
            BadValueError: min is above max.
        """
        self.random = drawn(self, ("minimum", "maximum"), self.between)

    def between(self, low: Any, high: Any) -> Any:
        """Numbers from a uniform distribution."""
        if np.any(low > high):
            raise BadValueError("min, max", (self.minimum, self.maximum), "in this order")
        shape = np.broadcast_shapes(np.shape(low), np.shape(high))
        if low.dtype.kind == "f":
            return low + (high - low) * self.generator().random(shape)
        return self.generator().integers(low, high, shape, low.dtype, endpoint=True)


class RandomGaussian(TypedNode, RandomNode, type="omni.graph.nodes.RandomGaussian"):
    """A normally distributed number, or a tuple or an array of such."""

    mean: Any = In(type=DECIMALS, default=0.0, doc="of the distribution, or of its logarithm")
    stdev: Any = In(type=DECIMALS, default=1.0, doc="standard deviation of the distribution, or of its logarithm")
    use_log: bool = In(default=False, doc="draws from a log-normal distribution")
    random: Any = Out(type=DECIMALS, doc="single numbers go with tuples and arrays, as those of sums do")

    def compute(self) -> None:
        """Draw.

        Raises:
            BadValueError: the deviation is negative.
        """
        self.random = drawn(self, ("mean", "stdev"), self.around)

    def around(self, mean: Any, deviation: Any) -> Any:
        """Numbers from a normal distribution."""
        if np.any(deviation < 0.0):
            raise BadValueError("stdev", self.stdev, "0 or more")
        shape = np.broadcast_shapes(np.shape(mean), np.shape(deviation))
        numbers = mean + deviation * self.generator().normal(size=shape)
        return np.exp(numbers) if self.use_log else numbers


def drawn(node: TypedNode, inputs: tuple[str, str], draw: Operation) -> Any:
    """What a function of arrays gives for two inputs, as the output `random` carries it."""
    known = node.port_types()
    operands = [Operand.of(known[name], type(node).fields[name].name) for name in inputs]
    return lift(draw, operands, known["random"])(*(getattr(node, name) for name in inputs))
