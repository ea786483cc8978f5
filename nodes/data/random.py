"""Random numbers (`omni.graph.nodes`).

Without `useSeed` they depend on the session's seed and the node's prim path, so a run can be repeated. With `useSeed` they depend
on the node's `seed` only: two nodes with the same seed give the same numbers. `isNoise` gives one fixed number for each seed.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, State, UInt64
from graphengine.nodes.data.broadcast import Operand, Operation, lift
from graphengine.nodes.data.elementwise import TypedNode
from graphengine.nodes.data.unions import DECIMALS, NUMERICS


class RandomNode(Node):
    """Base of nodes that output the next random value at each execution."""

    exec_in = ExecIn()
    seed: UInt64 = In(default=0, doc="seed, used if useSeed or isNoise is true")
    use_seed: bool = In(
        default=False, doc="true: numbers depend on the seed only; false: on the session's seed and the node's path"
    )
    is_noise: bool = In(default=False, doc="same number at every execution with the same seed")
    exec_out = ExecOut()

    common_numbers: np.random.Generator = Bound()
    own: tuple[int, np.random.Generator] | None = State(default=None)

    def setup(self, context: Context) -> None:
        """Bind the session's random numbers."""
        self.common_numbers = context.random()

    def generator(self) -> np.random.Generator:
        """The generator for the next value."""
        if self.is_noise:
            return np.random.Generator(np.random.Philox(key=self.seed))
        if not self.use_seed:
            return self.common_numbers
        if self.own is None or self.own[0] != self.seed:
            self.own = (self.seed, np.random.Generator(np.random.Philox(key=self.seed)))
        return self.own[1]


class RandomBoolean(RandomNode, type="omni.graph.nodes.RandomBoolean"):
    """Random boolean, true with probability 1/2."""

    random: bool = Out()

    def compute(self) -> None:
        """Draw a boolean."""
        self.random = bool(self.generator().integers(2))


class RandomUnitVector(RandomNode, type="omni.graph.nodes.RandomUnitVector"):
    """Random direction in space, uniformly distributed."""

    random: Any = Out(type="vectorf[3]", doc="unit vector")

    def compute(self) -> None:
        """Draw a direction."""
        self.random = unit(self.generator(), 3)


class RandomUnitQuaternion(RandomNode, type="omni.graph.nodes.RandomUnitQuaternion"):
    """Random orientation in space, uniformly distributed."""

    random: Any = Out(type="quatf[4]", doc="unit quaternion (x, y, z, w)")

    def compute(self) -> None:
        """Draw an orientation."""
        self.random = unit(self.generator(), 4)


def unit(generator: np.random.Generator, size: Literal[3, 4]) -> tuple[float, ...]:
    """A uniformly distributed point of the unit sphere: a normalized sample of a normal distribution."""
    vector = generator.normal(size=size)
    return tuple((vector / np.linalg.norm(vector)).tolist())


class RandomNumeric(TypedNode, RandomNode, type="omni.graph.nodes.RandomNumeric"):
    """Random number between min and max, or a tuple or array of such numbers."""

    minimum: Any = In(type=NUMERICS, name="min", default=0, doc="lowest number")
    maximum: Any = In(
        type=NUMERICS, name="max", default=1.0, doc="upper bound; included for integers, excluded for real numbers"
    )
    random: Any = Out(type=NUMERICS, doc="drawn number; a scalar bound is broadcast to tuples and arrays")

    def compute(self) -> None:
        """Draw from a uniform distribution.

        Raises:
            BadValueError: min is above max.
        """
        self.random = drawn(self, ("minimum", "maximum"), self.between)

    def between(self, low: Any, high: Any) -> Any:
        """Draw numbers from a uniform distribution."""
        if np.any(low > high):
            raise BadValueError("min, max", (self.minimum, self.maximum), "in this order")
        shape = np.broadcast_shapes(np.shape(low), np.shape(high))
        if low.dtype.kind == "f":
            return low + (high - low) * self.generator().random(shape)
        return self.generator().integers(low, high, shape, low.dtype, endpoint=True)


class RandomGaussian(TypedNode, RandomNode, type="omni.graph.nodes.RandomGaussian"):
    """Normally distributed random number, or a tuple or array of such numbers."""

    mean: Any = In(type=DECIMALS, default=0.0, doc="mean of the distribution, or of its logarithm")
    stdev: Any = In(type=DECIMALS, default=1.0, doc="standard deviation of the distribution, or of its logarithm")
    use_log: bool = In(default=False, doc="draws from a log-normal distribution")
    random: Any = Out(type=DECIMALS, doc="drawn number; a scalar input is broadcast to tuples and arrays")

    def compute(self) -> None:
        """Draw from a normal or log-normal distribution.

        Raises:
            BadValueError: the deviation is negative.
        """
        self.random = drawn(self, ("mean", "stdev"), self.around)

    def around(self, mean: Any, deviation: Any) -> Any:
        """Draw numbers from a normal distribution."""
        if np.any(deviation < 0.0):
            raise BadValueError("stdev", self.stdev, "0 or more")
        shape = np.broadcast_shapes(np.shape(mean), np.shape(deviation))
        numbers = mean + deviation * self.generator().normal(size=shape)
        return np.exp(numbers) if self.use_log else numbers


def drawn(node: TypedNode, inputs: tuple[str, str], draw: Operation) -> Any:
    """The result of a draw with two inputs, in the representation of the output `random`."""
    known = node.port_types()
    operands = [Operand.of(known[name], type(node).fields[name].name) for name in inputs]
    return lift(draw, operands, known["random"])(*(getattr(node, name) for name in inputs))
