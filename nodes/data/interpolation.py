"""Values between two others (`omni.graph.nodes`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.node import BadValueError, Float, Floats, In, Int, Node, Out, PortType, Token
from graphengine.nodes.checked import one_of, same_length
from graphengine.nodes.data.broadcast import Operand, Operation, common, lift
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.orientation import slerp
from graphengine.nodes.data.unions import DECIMALS


class InterpolateTo(Elementwise, type="omni.graph.nodes.InterpolateTo"):
    """One step from a value toward another, of 1 - (1 - speed * deltaSeconds)^exponent of the way.

    The documentation prints the formula without the leading `1 -`; by that no step would go the whole way. Quaternions go along
    the shorter arc, everything else along a line.
    """

    current: Any = In(type=DECIMALS, required=True, doc="number, tuple or array")
    target: Any = In(type=DECIMALS, required=True, doc="of the same size")
    speed: float = In(default=1.0, unit="1/s")
    delta_seconds: float = In(default=0.0, unit="s", doc="time of the step")
    exponent: Float = In(default=2.0, ge=0.0, doc="1 is linear in the time, higher ones go faster at first")
    result: Any = Out(type=DECIMALS, doc="of the type that holds both")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Along an arc where the values are quaternions, else along a line."""
        ends_and_share = [*inputs[:2], PortType("double")]
        between = (
            lift(slerp, ends_and_share, output) if output.role == "quat" else lift(_lerp, ends_and_share, output, _lerp)
        )

        def step(current: Any, target: Any, speed: float, delta_seconds: float, exponent: float) -> Any:
            if exponent < 0.0:
                raise BadValueError("exponent", exponent, "0 or more")
            left = 1.0 - min(max(speed * delta_seconds, 0.0), 1.0)
            return between(current, target, 1.0 - left**exponent)

        return step


def _lerp(start: Any, end: Any, alpha: Any) -> Any:
    return start + (end - start) * alpha


EASINGS = ("EaseIn", "EaseOut", "EaseInOut", "Linear", "SinIn", "SinOut", "SinInOut")


def curve(name: str, exponent: int) -> Callable[[Any], Any]:
    """The easing function of a name, from 0 to 1 onto itself.

    Raises:
        BadValueError: none has that name.
    """
    one_of("easeFunc", name, EASINGS)

    def ease_in(t: Any) -> Any:
        return t**exponent if name.startswith("Ease") else 1.0 - np.cos(t * math.pi / 2.0)

    if name == "Linear":
        return lambda t: t
    if name.endswith("InOut"):
        return lambda t: np.where(t < 0.5, ease_in(2.0 * t) / 2.0, 1.0 - ease_in(2.0 - 2.0 * t) / 2.0)
    return ease_in if name.endswith("In") else lambda t: 1.0 - ease_in(1.0 - t)


class Ease(Elementwise, type="omni.graph.nodes.Ease"):
    """A value on the way from one to another, which it leaves or reaches gently."""

    alpha: Any = In(type="float|float[]", required=True, doc="share of the time, 0 to 1, that has passed")
    blend_exponent: Int = In(default=2, doc="of the Ease functions: 1 is linear, 2 quadratic and so on")
    ease_func: Token = In(default="EaseInOut", tokens=EASINGS)
    end: Any = In(type=DECIMALS, required=True, doc="value at alpha 1")
    start: Any = In(type=DECIMALS, required=True, doc="value at alpha 0")
    result: Any = Out(type=DECIMALS, doc="of the type that holds both")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Along a line, by a share of the way."""
        known = self.port_types()
        share = Operand("double", 1, known["alpha"].array, port="alpha")
        return lift(_lerp, [Operand.of(known["start"], "start"), Operand.of(known["end"], "end"), share], output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """That of both ends, an array where alpha is one."""
        ends = common({"start": given["start"], "end": given["end"]})
        return replace(ends, array=ends.array or given["alpha"].array)

    def compute(self) -> None:
        """Ease."""
        with np.errstate(all="ignore"):  # an exponent below 0 leaves alpha 0 no value
            share = curve(self.ease_func, self.blend_exponent)(np.clip(self.alpha, 0.0, 1.0))
        self.result = self.operate(self.start, self.end, share)


class Interpolator(Node, type="omni.graph.nodes.Interpolator"):
    """A curve through samples, with straight lines between them; before the first and after the last it stays as it is there."""

    knots: Floats = In(default=np.zeros(0, np.float32), doc="where the samples are, rising")
    param: Float = In(default=0.0, doc="where the curve is asked for")
    values: Floats = In(default=np.zeros(0, np.float32), doc="the samples, as many as knots")
    value: Float = Out(doc="of the curve; 0 where there are no samples")

    def compute(self) -> None:
        """Interpolate.

        Raises:
            BadValueError: there is not a value for each knot.
        """
        knots: NDArray[np.float32] = self.knots
        same_length(knots=knots, values=self.values)
        self.value = float(np.interp(self.param, knots, self.values)) if len(knots) else 0.0
