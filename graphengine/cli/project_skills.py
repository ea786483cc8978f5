"""Finds the skills of a new project's robot, such as driving, and writes commands and tests for each skill."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import table
from graphengine.format.templates import filled
from graphengine.format.yaml_text import flow

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported
    from graphengine.descriptions.robot_description import Joint

TEMPLATES = Path(__file__).with_name("project_files")
_BASE, _STAND, _TRAJECTORY = "base", "stand", "arm/trajectory.yaml"
"""Names of the graphs that drive the base and hold the legs of an imported robot, and the graph file that moves its arm."""


@dataclass(frozen=True, slots=True)
class Skills:
    """The skills that a robot has through its graphs.

    Attributes:
        drives: whether a graph drives its base.
        stands: whether a graph holds its legs; without this graph, the robot falls over.
        holds: whether its joints take commands from a topic and hold their positions; False for a robot with other skills.
        reaches: Python code of the test of each arm that follows trajectories.
        examples: commands for the README that move a joint or an arm.
    """

    drives: bool = False
    stands: bool = False
    holds: bool = False
    reaches: tuple[str, ...] = ()
    examples: tuple[str, ...] = ()


def skills_of(imported: Imported) -> Skills:
    """Return the skills that an imported robot has through its graphs."""
    graphs, arms, joints = imported.draft.graphs, _arms(imported), commanded(imported)
    drives, stands = _BASE in graphs, _STAND in graphs
    if joints and not (drives or stands or arms):
        joint = joints[-1].name
        return Skills(holds=True, examples=(_move(joint, imported.robot.starts.get(joint, 0.0)),))
    reached = [_reach(imported, name, parameters) for name, parameters in arms.items()]
    reaches, examples = (tuple(part) for part in zip(*reached, strict=True)) if reached else ((), ())
    return Skills(drives, stands, reaches=reaches, examples=examples)


def commanded(imported: Imported) -> list[Joint]:
    """Return the joints that take commands from a topic, without the joints of a base."""
    return [imported.robot.description.joints[name] for name in imported.draft.commanded]


def is_arm(imported: Imported) -> bool:
    """Return whether an imported robot has a fixed base and a graph that follows trajectories."""
    return not imported.free and bool(_arms(imported))


def usage(name: str, skills: Skills) -> str:
    """Return the commands for the README, one per line, each with a comment; `name` is the name of the scene."""
    watch = "run, with a web page of the robot and its graphs; --watch reloads files that you save"
    commands = [
        (f"graphrun run {name}.yaml --view", watch),
        (f"graphrun topics {name}.yaml", "list the topics that the scene publishes and subscribes to"),
        (f"graphrun check {name}.yaml && pytest", "before a commit: check the files and run the tests"),
    ]
    if skills.drives:
        commands.insert(1, ("graphrun teleop", "in another terminal: drive the robot from the keyboard"))
        compare = "compare reached with commanded motion, and measure the odometry errors"
        commands.insert(3, (f"graphrun calibrate {name}.yaml", compare))
    return table([(command, f"# {about}") for command, about in commands], indent="    ")


def test_file(name: str, skills: Skills) -> str:
    """Return the content of the test file; `name` is the name of the scene and of the robot."""
    facts = {fact: bool(getattr(skills, fact)) for fact in ("drives", "stands", "holds", "reaches")}
    facts["simulated"] = skills.stands or skills.holds or bool(skills.reaches)
    return filled(TEMPLATES / "robot_test.txt", facts, name=name, reaches="\n\n\n".join(skills.reaches))


def _arms(imported: Imported) -> dict[str, Mapping[str, Any]]:
    """Return a dict from the names of graphs that drive an arm to their parameters."""
    graphs = imported.draft.graphs
    return {name: each.value["parameters"] for name, each in graphs.items() if each.value["use"].endswith(_TRAJECTORY)}


def _reach(imported: Imported, name: str, parameters: Mapping[str, Any]) -> tuple[str, str]:
    """Return the test of an arm, and the command that moves the arm."""
    from graphengine.bringup.robots.arm_pose import raised_pose

    pose = raised_pose(imported.robot, parameters["joints"])
    controller = parameters.get("controller", "joint_trajectory_controller")
    lines = "".join(f"        {json.dumps(joint)}: {position!r},\n" for joint, position in pose.items())
    # The servos of a MuJoCo model sag under the weight of the arm, as its author chose.
    within, error = ("two_milliradians", 0.002) if imported.robot.description.mjcf is None else ("five_degrees", 0.087)
    test = filled(
        TEMPLATES / "reach_test.txt",
        name=re.sub(r"\W", "_", name),
        within=within,
        error=error,
        pose=f"{{\n{lines}    }}",
        topic=json.dumps(f"{controller}/joint_trajectory"),
    )
    way = {"joint_names": [*pose], "points": [{"positions": [*pose.values()], "time_from_start": {"sec": 3}}]}
    action = f"/{controller}/follow_joint_trajectory control_msgs/action/FollowJointTrajectory"
    return test.rstrip("\n"), f"graphrun action send_goal {action} {shlex.quote(flow({'trajectory': way}))}"


def _move(joint: str, position: float) -> str:
    message = shlex.quote(flow({"name": [joint], "position": [position]}))
    return f"graphrun topic pub -1 /joint_commands sensor_msgs/msg/JointState {message}"
