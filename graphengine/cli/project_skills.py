"""Finds the skills of a new project's robot, such as driving, and writes commands and tests for each skill."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import table
from graphengine.format.yaml_text import flow

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported
    from graphengine.descriptions.urdf.urdf import UrdfJoint

_BASE, _STAND, _TRAJECTORY = "base", "stand", "arm/trajectory.yaml"
"""Names of the graphs that drive the base and hold the legs of an imported robot, and the graph file that moves its arm."""


@dataclass(frozen=True, slots=True)
class Skill:
    """A skill of a robot, such as driving or following trajectories.

    Attributes:
        commands: commands that demonstrate the skill, each with its purpose.
        example: command for a separate section of the README, which moves a joint or an arm; may be empty.
        active: whether the robot falls over unless its graphs run.
        test: Python code of a test of the skill; it may use `SCENE` (path of the scene), `ROBOT` (name of the robot) and the
            imports of `_TEST_FILE`.
    """

    commands: tuple[tuple[str, str], ...]
    test: str
    example: str = ""
    active: bool = False


DRIVE = Skill(
    (
        ("graphrun teleop", "in another terminal: drive the robot from the keyboard"),
        ("graphrun calibrate {name}.yaml", "compare reached with commanded motion, and measure the odometry errors"),
    ),
    """
def test_the_base_follows_its_commands_within_two_percent() -> None:
    assert main(["calibrate", str(SCENE), "--check", "0.02"]) == 0
""",
)
_REACH = """
def test_{name}_reaches_a_pose_within_{within}() -> None:
    pose = {pose}    # rad, m
    way = {{"joint_names": [*pose], "points": [{{"positions": [*pose.values()], "time_from_start": {{"sec": 3}}}}]}}
    with ge.load(SCENE).session() as sim:
        sim.robots[ROBOT].publish({topic}, way)
        sim.run(5.0)
        reached = {{joint: state.position for joint, state in sim.robots[ROBOT].joints.items() if joint in pose}}
    assert reached == pytest.approx(pose, abs={error})
"""
_STANDS = """
def test_the_robot_stands_for_ten_seconds() -> None:
    with ge.load(SCENE).session() as sim:
        height = sim.robots[ROBOT].pose.position[2]
        sim.run(10.0)
        assert sim.robots[ROBOT].pose.position[2] == pytest.approx(height, abs=0.02)    # m
"""
HOLD = """
def test_the_joints_hold_their_start_positions() -> None:
    with ge.load(SCENE).session() as sim:
        start = {joint: state.position for joint, state in sim.robots[ROBOT].joints.items()}
        sim.run(3.0)
        held = {joint: state.position for joint, state in sim.robots[ROBOT].joints.items()}
    assert held == pytest.approx(start, abs=0.05)    # rad, m
"""
_TEST_FILE = '''\
"""Tests of the robot: its files have no errors, and it moves as commanded."""

from pathlib import Path

{imports}from graphengine.cli import main

SCENE = Path(__file__).with_name("{name}.yaml")
{robot}

def test_the_files_have_no_mistakes() -> None:
    assert main(["check", str(SCENE)]) == 0
'''


def skills_of(imported: Imported) -> list[Skill]:
    """Return the skills that an imported robot has through its graphs."""
    graphs, arms = imported.draft.graphs, _arms(imported)
    found = [DRIVE] if _BASE in graphs else []
    found += [_reach(imported, name, parameters) for name, parameters in arms.items()]
    if _STAND in graphs:
        found.append(Skill((), _STANDS, active=True))
    if not found and (joints := commanded(imported)):
        joint = joints[-1].name
        found.append(Skill((), HOLD, _move(joint, imported.robot.starts.get(joint, 0.0))))
    return found


def commanded(imported: Imported) -> list[UrdfJoint]:
    """Return the joints that take commands from a topic, without the joints of a base."""
    return [imported.robot.urdf.joints[name] for name in imported.draft.commanded]


def is_arm(imported: Imported) -> bool:
    """Return whether an imported robot has a fixed base and a graph that follows trajectories."""
    return not imported.free and bool(_arms(imported))


def usage(name: str, skills: Sequence[Skill]) -> str:
    """Return the commands for the README, one per line, each with a comment; `name` is the name of the scene."""
    tries = [command for skill in skills for command in skill.commands]
    commands = [
        (
            "graphrun run {name}.yaml --view",
            "run, with a web page of the robot and its graphs; --watch reloads files that you save",
        ),
        *tries[:1],
        ("graphrun topics {name}.yaml", "list the topics that the scene publishes and subscribes to"),
        *tries[1:],
        ("graphrun check {name}.yaml && pytest", "before a commit: check the files and run the tests"),
    ]
    return table([(command.replace("{name}", name), f"# {about}") for command, about in commands], indent="    ")


def test_file(name: str, skills: Sequence[Skill]) -> str:
    """Return the content of the test file; `name` is the name of the scene and of the robot."""
    simulated = any("ge." in skill.test for skill in skills)
    imports = "import pytest\n\nimport graphengine as ge\n" if simulated else ""
    robot = f'ROBOT = "{name}"\n' if simulated else ""
    return "\n".join([_TEST_FILE.format(name=name, imports=imports, robot=robot), *(skill.test for skill in skills)])


def _arms(imported: Imported) -> dict[str, Mapping[str, Any]]:
    """Return the parameters of each graph that drives an arm, by the name of the graph."""
    graphs = imported.draft.graphs
    return {name: each.value["parameters"] for name, each in graphs.items() if each.value["use"].endswith(_TRAJECTORY)}


def _reach(imported: Imported, name: str, parameters: Mapping[str, Any]) -> Skill:
    from graphengine.bringup.robots.arm_pose import raised_pose

    pose = raised_pose(imported.robot, parameters["joints"])
    controller = parameters.get("controller", "joint_trajectory_controller")
    topic = f"{controller}/joint_trajectory"
    lines = "".join(f"        {json.dumps(joint)}: {position!r},\n" for joint, position in pose.items())
    # The servos of a MuJoCo model sag under the weight of the arm, as its author chose.
    within, error = ("two_milliradians", 0.002) if imported.robot.urdf.mjcf is None else ("five_degrees", 0.087)
    target, place = f"{{\n{lines}    }}", json.dumps(topic)
    test = _REACH.format(name=re.sub(r"\W", "_", name), within=within, error=error, pose=target, topic=place)
    way = {"joint_names": [*pose], "points": [{"positions": [*pose.values()], "time_from_start": {"sec": 3}}]}
    action = f"/{controller}/follow_joint_trajectory control_msgs/action/FollowJointTrajectory"
    return Skill((), test, f"graphrun action send_goal {action} {shlex.quote(flow({'trajectory': way}))}")


def _move(joint: str, position: float) -> str:
    message = shlex.quote(flow({"name": [joint], "position": [position]}))
    return f"graphrun topic pub -1 /joint_commands sensor_msgs/msg/JointState {message}"
