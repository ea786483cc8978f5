"""Nodes that output random numbers (`omni.graph.nodes`).

By default, the numbers depend on the session's seed and the node's prim path, so a run can be repeated. With `useSeed`, the
numbers depend only on the input `seed`: two nodes with the same `seed` output the same numbers. With `isNoise`, a node outputs
the same number at every execution as long as `seed` stays the same.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, In, Node, Out, State, UInt64
from graphengine.nodes.data.broadcast import Operand, Operation, lift
from graphengine.nodes.data.elementwise import TypedNode
from graphengine.nodes.data.unions import DECIMALS, NUMERICS


class RandomNode(Node):
    """Base class of nodes that output a new random value at each execution."""

    exec_in = ExecIn()
    seed: UInt64 = In(default=0, doc="seed of the random numbers; used if `useSeed` or `isNoise` is true")
    use_seed: bool = In(
        default=False, doc="true: the numbers depend only on `seed`; false: on the session's seed and the node's path"
    )
    is_noise: bool = In(default=False, doc="true: every execution with the same `seed` gives the same number")
    exec_out = ExecOut()

    common_numbers: np.random.Generator = Bound()
    own: tuple[int, np.random.Generator] | None = State(default=None)

    def setup(self, context: Context) -> None:
        """Store the generator that depends on the session's seed and the node's path."""
        self.common_numbers = context.random()

    def generator(self) -> np.random.Generator:
        """Return the random generator that `isNoise` and `useSeed` select for the next value."""
        if self.is_noise:
            return np.random.Generator(np.random.Philox(key=self.seed))
        if not self.use_seed:
            return self.common_numbers
        if self.own is None or self.own[0] != self.seed:
            self.own = (self.seed, np.random.Generator(np.random.Philox(key=self.seed)))
        return self.own[1]


class RandomBoolean(RandomNode, type="omni.graph.nodes.RandomBoolean"):
    """Outputs a random boolean: true with probability 1/2."""

    random: bool = Out(doc="random boolean")

    def compute(self) -> None:
        """Set `random` to a new random boolean."""
        self.random = bool(self.generator().integers(2))


class RandomUnitVector(RandomNode, type="omni.graph.nodes.RandomUnitVector"):
    """Outputs a random direction in space, uniformly distributed."""

    random: Any = Out(type="vectorf[3]", doc="direction as a unit vector")

    def compute(self) -> None:
        """Set `random` to a new random direction."""
        self.random = unit(self.generator(), 3)


class RandomUnitQuaternion(RandomNode, type="omni.graph.nodes.RandomUnitQuaternion"):
    """Outputs a random orientation in space, uniformly distributed."""

    random: Any = Out(type="quatf[4]", doc="orientation as a unit quaternion (x, y, z, w)")

    def compute(self) -> None:
        """Set `random` to a new random orientation."""
        self.random = unit(self.generator(), 4)


def unit(generator: np.random.Generator, size: Literal[3, 4]) -> tuple[float, ...]:
    """Return a random unit vector of `size` components; all directions are equally likely."""
    vector = generator.normal(size=size)
    return tuple((vector / np.linalg.norm(vector)).tolist())


class RandomNumeric(TypedNode, RandomNode, type="omni.graph.nodes.RandomNumeric"):
    """Outputs uniformly distributed random numbers between `min` and `max`: one number, a tuple or an array."""

    minimum: Any = In(type=NUMERICS, name="min", default=0, doc="lower bound (inclusive)")
    maximum: Any = In(
        type=NUMERICS, name="max", default=1.0, doc="upper bound: inclusive for integers, exclusive for reals"
    )
    random: Any = Out(type=NUMERICS, doc="random number, tuple or array; a scalar bound applies to all numbers")

    def compute(self) -> None:
        """Set `random` to new numbers from a uniform distribution.

        Raises:
            BadValueError: `min` is above `max`.
        """
        self.random = drawn(self, ("minimum", "maximum"), self.between)

    def between(self, low: Any, high: Any) -> Any:
        """Return uniformly distributed numbers between two arrays of bounds."""
        if np.any(low > high):
            raise BadValueError("min, max", (self.minimum, self.maximum), "in ascending order")
        shape = np.broadcast_shapes(np.shape(low), np.shape(high))
        if low.dtype.kind == "f":
            return low + (high - low) * self.generator().random(shape)
        return self.generator().integers(low, high, shape, low.dtype, endpoint=True)


class RandomGaussian(TypedNode, RandomNode, type="omni.graph.nodes.RandomGaussian"):
    """Outputs normally distributed random numbers: one number, a tuple or an array."""

    mean: Any = In(type=DECIMALS, default=0.0, doc="mean of the numbers, or of their logarithms if `useLog` is true")
    stdev: Any = In(
        type=DECIMALS,
        default=1.0,
        ge=0.0,
        doc="standard deviation of the numbers, or of their logarithms if `useLog` is true",
    )
    use_log: bool = In(default=False, doc="true: draw from a log-normal distribution; false: from a normal one")
    random: Any = Out(type=DECIMALS, doc="random number, tuple or array; a scalar input applies to all numbers")

    def compute(self) -> None:
        """Set `random` to new numbers from a normal or log-normal distribution.

        Raises:
            BadValueError: `stdev` is negative.
        """
        self.random = drawn(self, ("mean", "stdev"), self.around)

    def around(self, mean: Any, deviation: Any) -> Any:
        """Return normally or log-normally distributed numbers for arrays of means and standard deviations."""
        if np.any(deviation < 0.0):
            raise BadValueError("stdev", self.stdev, "0 or more")
        shape = np.broadcast_shapes(np.shape(mean), np.shape(deviation))
        numbers = mean + deviation * self.generator().normal(size=shape)
        return np.exp(numbers) if self.use_log else numbers


def drawn(node: TypedNode, inputs: tuple[str, str], draw: Operation) -> Any:
    """Return random numbers as a value for the output `random`; their shape is the common shape of two inputs.

    Args:
        node: node with the two inputs and the output.
        inputs: Python names of the two inputs.
        draw: function that takes the values of the two inputs as arrays, broadcasts them and returns random numbers.
    """
    known = node.port_types()
    operands = [Operand.of(known[name], type(node).fields[name].name) for name in inputs]
    return lift(draw, operands, known["random"])(*(getattr(node, name) for name in inputs))
