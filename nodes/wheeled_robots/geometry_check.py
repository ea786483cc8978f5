"""Lints that compare a node's wheel radius and wheel distance with the geometry of its robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from graphengine.compiler.graph import Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim
    from graphengine.format.diagnostics import Span

TOLERANCE = 0.01
"""Largest relative difference, between a node's input and the geometry of its robot, that gives no warning."""
Effects = tuple[Callable[[float], str], Callable[[float], str]]
"""Two functions that return a text for users: the effect of a wrong wheel radius, and the effect of a wrong wheel distance.

The argument of each function is the input's value divided by the true value.
"""


class WheelGeometry(Protocol):
    """A node with inputs for the radius of the wheels on an axle and for the distance between them, both in m; 0: unknown."""

    wheel_radius: float
    wheel_distance: float


def compare_geometry(
    context: LintContext, node: Instance, inputs: WheelGeometry, robot: Prim, joints: Sequence[str], effects: Effects
) -> None:
    """Warn if `wheelRadius` or `wheelDistance` of a node differs from the geometry of its robot.

    Args:
        context: context of the lint; it collects the findings.
        node: instance of the node.
        inputs: object whose attributes are the initial values of the inputs.
        robot: the robot.
        joints: names of the joints of the wheels.
        effects: functions that describe the effects of wrong values.
    """
    radius, distance = inputs.wheel_radius, inputs.wheel_distance
    known = [known for joint in joints if (known := robot.facts.get("wheel_radii", {}).get(joint))]
    if known and _differs(radius, known[0]):
        span, effect = node.entry.span("inputs", "wheelRadius"), effects[0](abs(radius) / known[0])
        what = f"wheelRadius is {radius:g} m, but the wheels of {robot.path} have {known[0]:g} m"
        context.findings.add("W201", what, span, effect, _remedy(span, "wheelRadius", known[0]))
    true = robot.facts.get("wheel_distance")
    if true and _differs(distance, true):
        span, effect = node.entry.span("inputs", "wheelDistance"), effects[1](abs(distance) / true)
        what = f"wheelDistance is {distance:g} m, but the wheels of {robot.path} are {true:g} m apart"
        context.findings.add("W202", what, span, effect, _remedy(span, "wheelDistance", true))


def _remedy(span: Span, name: str, true: float) -> str:
    return f"set the parameter {span.parameter} to {true:g}" if span.parameter else f"write {name}: {true:g}"


def _differs(value: float, true: float) -> bool:
    return value != 0.0 and abs(abs(value) - true) > TOLERANCE * true
