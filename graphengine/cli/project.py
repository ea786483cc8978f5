"""Makes the files of a new project for `graphrun new`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import clean
from graphengine.cli.project_skills import DRIVE, HOLD, Skill, commanded, is_arm, skills_of, test_file, usage
from graphengine.devices.rotation import Vector3
from graphengine.format.atomic_write import write_together
from graphengine.format.distribution import requirement
from graphengine.format.files import near, shipped
from graphengine.format.version import __version__
from graphengine.format.wording import quoted
from graphengine.format.yaml_text import scalar

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported


@dataclass(frozen=True, slots=True)
class WorldPlaces:
    """An included world and free places for a robot in it.

    Attributes:
        file: MJCF file of the world, relative to the folder of the included scenes.
        stand: x and y of a place on the floor for a robot that moves freely, m.
        mount: position for the base link of a robot with a fixed base, m.
    """

    file: str
    stand: tuple[float, float]
    mount: Vector3


WORLDS = {
    "flat": WorldPlaces("worlds/flat_grid.xml", (0.0, 0.0), (0.0, 0.0, 0.0)),
    "table": WorldPlaces("worlds/table.xml", (-0.9, 0.0), (0.0, 0.0, 0.75)),
    "warehouse": WorldPlaces("worlds/warehouse_features.xml", (-3.0, 6.0), (-3.0, 6.0, 0.0)),
}
DINGO = Path("scenes/robots/dd100.yaml")
DINGO_GRAPH = Path("graphs/dd100/cmd_vel.yaml")
DINGO_LIFT = 0.025
"""Initial height of the Dingo-D's base link above the floor, m; from there, the robot comes to rest on the floor."""

SCENE = """\
# The scene that `graphrun run {name}.yaml` runs: a world with the robot.
format: 1
scene: {key}
world: {world}    # a world that ships with graphengine; or an MJCF file in this folder
physics: {{tick_rate: 60, substeps: 4}}
settle: {settle}
robots:
  {key}:
    use: robots/{name}.yaml
    position: [{x:g}, {y:g}, {z:g}]    # m
    orientation: {{rpy_deg: [0, 0, 0]}}
    robot_state: true    # publish /robot_description, /tf and /tf_static, as robot_state_publisher does
    # namespace: {name}    # the robot's topics then begin with /{name}
graphs:
  clock: {{use: graphs/clock.yaml, at: /World/clock}}
"""

SETTLE = "true    # let the robot come to rest before t = 0"
ACTIVE = "false    # the robot would fall before t = 0, because the graph that holds it runs only from t = 0 on"

DINGO_ROBOT = """\
# The Clearpath Dingo-D that ships with graphengine. Keys in this file are added to those of the extended file, or replace them.
format: 1
robot: {key}
extends: robots/dd100.yaml
graphs:
  cmd_vel: {{use: ../graphs/cmd_vel.yaml}}    # your copy: change a value and run again
"""

README = """\
# {name}

This project simulates {source} with graphengine {version}. Install graphengine and pytest:

{installation}

Then run these commands in this folder:

{commands}

- `{name}.yaml` is the scene: the world and the position of the robot.
- `robots/{name}.yaml` is the robot.
- `graphs/` contains the graphs that control the robot.
"""
EXAMPLE = """\
Move the robot from another terminal while the simulation runs:

    {command}
"""
ROS2_CONTROL = """\
`ros2_control.xacro` lets ros2_control, and therefore MoveIt, command the joints.
"""
ROS2_CONTROL_FILE = """\
<?xml version="1.0"?>
<!-- With this file, controllers of ros2_control, and therefore MoveIt, command the simulated joints. Include it in the robot
     description of your controller manager, and set these parameters of the graphs in robots/{name}.yaml:
       joint_states: parameters: joint_states: {states}
       joint_commands: parameters: joint_commands: {commands} -->
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
{block}</robot>
"""


class Project:
    """Collects the files of a project in memory; `write` writes them.

    Args:
        folder: folder of the project.
        name: name of the robot and the scene.
        world: a key of `WORLDS`; None takes `table` for an arm and `flat` for other robots.
    """

    def __init__(self, folder: Path, name: str, world: str | None) -> None:
        self.folder = folder
        self.name = name
        self.world = world
        self.robot_file = folder / "robots" / f"{name}.yaml"
        self.scene_file = folder / f"{name}.yaml"
        self.holds = False
        self._contents: dict[Path, bytes] = {}

    def add_dingo(self) -> None:
        """Add the Dingo-D, a copy of the graph that drives it, and the files around them, such as the scene."""
        self._add(self.robot_file, DINGO_ROBOT.format(key=scalar(self.name)))
        self._contents[self.folder / "graphs" / DINGO_GRAPH.name] = (shipped() / DINGO_GRAPH).read_bytes()
        world = WORLDS[self.world or "flat"]
        self._add_rest("a Clearpath Dingo-D", [DRIVE], world, (*world.stand, DINGO_LIFT))

    def add_robot(self, imported: Imported) -> None:
        """Add an imported robot with its description, meshes and graphs, and the files around them, such as the scene."""
        for path, text in imported.files.items():
            self._add(path, text)
        for path, source in imported.copies.items():
            self._contents[path] = source.read_bytes()
        world = WORLDS[self.world or ("table" if is_arm(imported) else "flat")]
        x, y, z = (*world.stand, imported.lift) if imported.free else world.mount
        place = (x, y, z + imported.rise)
        more = ROS2_CONTROL if self._add_ros2_control(imported) else ""
        self._add_rest(f"the robot of {imported.draft.source}", skills_of(imported), world, place, more)

    def write(self) -> None:
        """Write all files or none."""
        write_together(self._contents)

    def told(self) -> str:
        """Return a text for the user with the folder, the number of files and the next command."""
        folder = near(str(self.folder))
        return clean(
            f"{folder}: a project of {len(self._contents)} files\nnext: cd {quoted(folder)} && graphrun run {self.name}.yaml"
        )

    def _add(self, path: Path, text: str) -> None:
        self._contents[path] = text.encode()

    def _add_ros2_control(self, imported: Imported) -> bool:
        """Add a xacro file for ros2_control with the commanded joints; return False if the robot has no such joints."""
        from graphengine.bringup.robots import topic_based

        joints = commanded(imported)
        if joints:
            block = topic_based.block(self.name, joints, imported.robot.starts)
            topics = {"states": topic_based.STATES, "commands": topic_based.COMMANDS}
            text = ROS2_CONTROL_FILE.format(name=self.name, block=block, **topics)
            self._add(self.folder / "ros2_control.xacro", text)
        return bool(joints)

    def _add_rest(
        self, source: str, skills: Sequence[Skill], world: WorldPlaces, place: Vector3, more: str = ""
    ) -> None:
        """Add the scene, the test, the README and the requirements.

        Args:
            source: origin of the robot, with which the README begins.
            skills: skills of the robot, for the test and the README.
            world: world of the scene.
            place: position of the robot in the world, m.
            more: text for the end of the README.
        """
        x, y, z = place
        settle = ACTIVE if any(skill.active for skill in skills) else SETTLE
        scene = SCENE.format(name=self.name, key=scalar(self.name), world=world.file, settle=settle, x=x, y=y, z=z)
        self._add(self.scene_file, scene)
        self.holds = any(skill.test == HOLD for skill in skills)
        self._add(self.folder / "test_robot.py", test_file(self.name, skills))
        needed = requirement("view")
        self._add(self.folder / "requirements.txt", f"{needed}\npytest\n")
        commands = usage(self.name, skills)
        by_hand = [needed.removeprefix("# ")] if needed.startswith("#") else []
        installation = "\n".join(f"    {command}" for command in (*by_hand, "pip install -r requirements.txt"))
        texts = {"source": source, "version": __version__, "installation": installation, "commands": commands}
        readme = README.format(name=self.name, **texts)
        examples = [EXAMPLE.format(command=skill.example) for skill in skills if skill.example]
        self._add(self.folder / "README.md", "\n".join([readme, *examples, more]).rstrip("\n") + "\n")
