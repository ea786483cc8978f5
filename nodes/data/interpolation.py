"""Interpolation between values (`omni.graph.nodes`)."""

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
    """One step from a value toward a target, by a fraction of the way: 1 - (1 - `speed` * `deltaSeconds`)^`exponent`.

    OmniGraph's documentation lacks the leading `1 -`, without which no step would reach the target. Quaternions are interpolated
    along the shorter arc, other values along a line.
    """

    current: Any = In(type=DECIMALS, required=True, doc="number, tuple or array")
    target: Any = In(type=DECIMALS, required=True, doc="value to approach, of the same size as `current`")
    speed: float = In(default=1.0, unit="1/s", doc="fraction of the way per second, if `exponent` is 1")
    delta_seconds: float = In(default=0.0, unit="s", doc="duration of the step")
    exponent: Float = In(default=2.0, ge=0.0, doc="1 is linear in `deltaSeconds`, higher values start faster")
    result: Any = Out(type=DECIMALS, doc="value after the step, of the common type of `current` and `target`")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the interpolation: along an arc for quaternions, along a line for other values."""
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
    """Return the easing function with this name, which maps the range from 0 to 1 onto itself.

    Args:
        name: one of `EASINGS`.
        exponent: exponent of the functions whose name starts with Ease.

    Raises:
        BadValueError: the name is unknown.
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
    """Interpolates between two values with an easing function, for a gentle start or end."""

    alpha: Any = In(type="float|float[]", required=True, doc="elapsed fraction of the time, 0 to 1")
    blend_exponent: Int = In(default=2, doc="exponent of EaseIn, EaseOut and EaseInOut: 1 is linear, 2 quadratic, …")
    ease_func: Token = In(
        default="EaseInOut",
        tokens=EASINGS,
        doc="easing function; names with In start gently, names with Out end gently",
    )
    end: Any = In(type=DECIMALS, required=True, doc="value for `alpha` = 1")
    start: Any = In(type=DECIMALS, required=True, doc="value for `alpha` = 0")
    result: Any = Out(type=DECIMALS, doc="value for `alpha`, of the common type of `start` and `end`")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the interpolation along a line."""
        known = self.port_types()
        share = Operand("double", 1, known["alpha"].array, port="alpha")
        return lift(_lerp, [Operand.of(known["start"], "start"), Operand.of(known["end"], "end"), share], output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the common type of both ends, as an array if `alpha` is an array."""
        ends = common({"start": given["start"], "end": given["end"]})
        return replace(ends, array=ends.array or given["alpha"].array)

    def compute(self) -> None:
        """Choose the easing function and interpolate."""
        with np.errstate(all="ignore"):  # an exponent below 0 leaves alpha 0 no value
            share = curve(self.ease_func, self.blend_exponent)(np.clip(self.alpha, 0.0, 1.0))
        self.result = self.operate(self.start, self.end, share)


class Interpolator(Node, type="omni.graph.nodes.Interpolator"):
    """Interpolates linearly between samples; the value is constant before the first and after the last sample."""

    knots: Floats = In(default=np.zeros(0, np.float32), doc="positions of the samples, ascending")
    param: Float = In(default=0.0, doc="position to interpolate at")
    values: Floats = In(default=np.zeros(0, np.float32), doc="samples, one per knot")
    value: Float = Out(doc="interpolated value; 0 without samples")

    def compute(self) -> None:
        """Interpolate the samples.

        Raises:
            BadValueError: the numbers of values and knots differ.
        """
        knots: NDArray[np.float32] = self.knots
        same_length(knots=knots, values=self.values)
        self.value = float(np.interp(self.param, knots, self.values)) if len(knots) else 0.0
