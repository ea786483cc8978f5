"""Compares a node's wheel radius and wheel distance with those of its robot, for lints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from graphengine.compiler.graph import Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim
    from graphengine.format.diagnostics import Span

TOLERANCE = 0.01
"""Largest accepted relative difference between the geometry of a node and of its robot."""
Effects = tuple[Callable[[float], str], Callable[[float], str]]
"""Functions that describe the effect of a wrong radius, and of a wrong distance; their argument is the ratio wrong / true."""


class WheelGeometry(Protocol):
    """A node with inputs for the geometry of wheels on one axle; 0 for a value that is not known before the run."""

    wheel_radius: float
    wheel_distance: float


def compare_geometry(
    context: LintContext, node: Instance, inputs: WheelGeometry, robot: Prim, joints: Sequence[str], effects: Effects
) -> None:
    """Warn if `wheelRadius` or `wheelDistance` of a node differs from the robot's.

    Args:
        context: context of the lint.
        node: instance of the node.
        inputs: the node with the initial values of its inputs.
        robot: the robot.
        joints: joints of the wheels.
        effects: describe the consequences of a wrong radius and of a wrong distance.
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
