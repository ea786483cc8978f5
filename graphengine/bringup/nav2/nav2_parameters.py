"""Generates Nav2's parameter file for a robot."""

from __future__ import annotations

from typing import get_args

from graphengine.bringup.nav2.choices import CONTROLLERS, Choices
from graphengine.bringup.nav2.motion_limits import Kinematics
from graphengine.bringup.nav2.parameter_text import parameter_lines
from graphengine.bringup.nav2.parameter_values import parameter_values
from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.bringup.nav2.sourced import Sourced
from graphengine.bringup.nav2.text_files import TEMPLATES
from graphengine.format.templates import Facts
from graphengine.format.yaml_text import comment
from graphengine.messages.distros import DISTROS

Alphas = tuple[float, float, float, float, float]
CIRCULAR = 0.95
"""A footprint is a circle if its inscribed radius is at least this share of its circumscribed radius."""


def nav2_parameters(robot: RobotFacts, choices: Choices, alphas: Sourced[Alphas] | None, scene: str) -> str:
    """Return the content of nav2_params.yaml.

    Args:
        robot: properties of the robot.
        choices: choices of the user.
        alphas: motion noise of AMCL; None configures slam_toolbox instead of AMCL.
        scene: name of the scene, for the comment in the first line.
    """
    text = (TEMPLATES / "nav2_params.txt").read_text(encoding="utf-8")
    template = [line for line in text.splitlines() if not line.startswith("#")]
    for name in reversed(list(filter(None, robot.namespace.split("/")))):
        template = [f"{name}:", *(f"  {line}" for line in template)]
    values = parameter_values(robot, choices)
    if alphas is not None:
        values |= {f"alpha{number}": Sourced(alpha, alphas.source) for number, alpha in enumerate(alphas.value, 1)}
    lines = parameter_lines(template, values, _facts(robot, choices, slam=alphas is None))
    name = f"Nav2 ({choices.distribution}) for {robot.name} of {scene}"
    head = f"{name}, by `graphrun nav2 files`; comments: sources of values"
    return "\n".join([comment(head), *lines, ""])


def _facts(robot: RobotFacts, choices: Choices, *, slam: bool) -> Facts:
    """Return the facts to which the conditions of the template refer."""
    limits, (inner, outer) = robot.limits, robot.radii
    chosen = {choices.distribution, choices.controller_for(limits), limits.kinematics.value}
    return {
        **{name: name in chosen for name in (*DISTROS, *CONTROLLERS, *get_args(Kinematics))},
        "busy": choices.busy,
        "car": limits.car,
        "circular": inner >= CIRCULAR * outer,
        "round": robot.radius is not None,
        "slam": slam,
    }
