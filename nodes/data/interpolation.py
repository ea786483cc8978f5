"""Nodes that interpolate between values (`omni.graph.nodes`)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.compiler.lint_registry import LintContext, lint
from graphengine.node import BadValueError, Float, Floats, In, Int, Node, Out, PortType, Token
from graphengine.nodes.checked import one_of, same_length
from graphengine.nodes.data.broadcast import Operand, Operation, common, lift
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.orientation import slerp
from graphengine.nodes.data.unions import DECIMALS
from graphengine.nodes.known_inputs import known_inputs


class InterpolateTo(Elementwise, type="omni.graph.nodes.InterpolateTo"):
    """Moves a value one step toward a target.

    The step covers the fraction 1 - (1 - `speed` * `deltaSeconds`)^`exponent` of the way. OmniGraph's documentation lacks the
    leading `1 -`; without it, a higher speed would give a shorter step. Quaternions move along the shorter arc, other values
    along a straight line.
    """

    current: Any = In(type=DECIMALS, required=True, doc="value before the step: number, tuple or array")
    target: Any = In(type=DECIMALS, required=True, doc="value to approach, of the same size as `current`")
    speed: float = In(default=1.0, ge=0.0, unit="1/s", doc="fraction of the way per second, if `exponent` is 1")
    delta_seconds: float = In(default=0.0, ge=0.0, unit="s", doc="duration of the step")
    exponent: Float = In(default=2.0, ge=0.0, doc="exponent in the formula; higher values give longer steps")
    result: Any = Out(type=DECIMALS, doc="value after the step; has the common type of `current` and `target`")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that computes the step: along an arc for quaternions, along a line for other values."""
        ends_and_share = [*inputs[:2], PortType("double")]
        along = (slerp, None) if output.role == "quat" else (_lerp, _lerp)
        between = lift(along[0], ends_and_share, output, along[1])

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
    """Return the easing function with the given name; it maps the range from 0 to 1 onto itself.

    Args:
        name: one of `EASINGS`.
        exponent: exponent of EaseIn, EaseOut and EaseInOut; the other functions ignore it.

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

    alpha: Any = In(
        type="float|float[]", required=True, doc="elapsed fraction of the duration, limited to the range from 0 to 1"
    )
    blend_exponent: Int = In(default=2, ge=0, doc="exponent of EaseIn, EaseOut and EaseInOut; 1 is linear")
    ease_func: Token = In(
        default="EaseInOut",
        tokens=EASINGS,
        doc="easing function; functions with In in their name start gently, functions with Out end gently",
    )
    end: Any = In(type=DECIMALS, required=True, doc="value at `alpha` = 1")
    start: Any = In(type=DECIMALS, required=True, doc="value at `alpha` = 0")
    result: Any = Out(type=DECIMALS, doc="value at `alpha`; has the common type of `start` and `end`")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that interpolates linearly between `start` and `end`."""
        known = self.port_types()
        share = Operand("double", 1, known["alpha"].array, port="alpha")
        return lift(_lerp, [Operand.of(known["start"], "start"), Operand.of(known["end"], "end"), share], output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the common type of `start` and `end`; an array type if any input is an array."""
        ends = common({"start": given["start"], "end": given["end"]})
        return replace(ends, array=ends.array or given["alpha"].array)

    def compute(self) -> None:
        """Set `result` to the value that the easing function gives for `alpha`."""
        with np.errstate(all="ignore"):  # with an exponent below 0, there is no value at alpha 0
            share = curve(self.ease_func, self.blend_exponent)(np.clip(self.alpha, 0.0, 1.0))
        self.result = self.operate(self.start, self.end, share)


class Interpolator(Node, type="omni.graph.nodes.Interpolator"):
    """Interpolates linearly between samples. Before the first and after the last sample, the value is constant."""

    knots: Floats = In(default=np.zeros(0, np.float32), doc="positions of the samples, in ascending order")
    param: Float = In(default=0.0, doc="position to interpolate at")
    values: Floats = In(default=np.zeros(0, np.float32), doc="values of the samples, one per knot")
    value: Float = Out(doc="interpolated value; 0 if there are no samples")

    def compute(self) -> None:
        """Set `value` to the interpolated value at `param`.

        Raises:
            BadValueError: `knots` and `values` differ in length.
        """
        knots: NDArray[np.float32] = self.knots
        same_length(knots=knots, values=self.values)
        self.value = float(np.interp(self.param, knots, self.values)) if len(knots) else 0.0


@lint("W215")
def lint_lengths_of_samples(context: LintContext) -> None:
    """Warn about interpolators that do not have one value per knot."""
    for inputs, _ in known_inputs(context, Interpolator):
        inputs.warn_of_unequal("knots", "values")


@lint("W216")
def lint_order_of_knots(context: LintContext) -> None:
    """Warn about interpolators whose knots do not ascend: their output is wrong or jumps."""
    for inputs, _ in known_inputs(context, Interpolator):
        knots = inputs.value("knots")
        pairs = itertools.pairwise(knots.tolist()) if knots is not None else ()
        fall = next((pair for pair in pairs if not pair[0] < pair[1]), None)
        if fall:
            message = f"knots do not ascend: {fall[0]:g} is followed by {fall[1]:g}"
            remedy = "sort the knots, and their values with them; each knot occurs once"
            inputs.warn_of_value("knots", message, remedy)
