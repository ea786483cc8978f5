"""Makes the files of a new project for `graphrun new`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import clean
from graphengine.cli.project_skills import TEMPLATES, Skills, commanded, is_arm, skills_of, test_file, usage
from graphengine.devices.rotation import Vector3
from graphengine.format.atomic_write import write_together
from graphengine.format.distribution import requirement
from graphengine.format.files import near, shipped
from graphengine.format.templates import filled
from graphengine.format.version import __version__
from graphengine.format.wording import quoted
from graphengine.format.yaml_text import scalar

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported


@dataclass(frozen=True, slots=True)
class WorldPlaces:
    """An included world with free positions for a robot.

    Attributes:
        file: MJCF file of the world, relative to the folder of the included scenes.
        stand: free position (x, y) on the floor for a robot that moves freely, m.
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
DINGO_GRAPH = Path("graphs/dd100/cmd_vel.yaml")
ROS2_CONTROL = "ros2_control.xacro"
DINGO_LIFT = 0.025
"""Initial height of the Dingo-D's base link above the floor, m; from there, the robot comes to rest on the floor."""


class Project:
    """Collects the files of a project in memory; `write` writes them.

    Args:
        folder: folder of the project.
        name: name of the robot and the scene.
        world: a key of `WORLDS`; None chooses `table` for an arm and `flat` for other robots.
    """

    def __init__(self, folder: Path, name: str, world: str | None) -> None:
        self.folder = folder
        self.extras = "view"
        self.name = name
        self.world = world
        self.robot_file = folder / "robots" / f"{name}.yaml"
        self.scene_file = folder / f"{name}.yaml"
        self.holds = False
        self._contents: dict[Path, bytes] = {}

    def add_dingo(self) -> None:
        """Add the Dingo-D, a copy of the graph that drives it, and the files around them, such as the scene."""
        self._add(self.robot_file, filled(TEMPLATES / "dingo.txt", key=scalar(self.name)))
        self._contents[self.folder / "graphs" / DINGO_GRAPH.name] = (shipped() / DINGO_GRAPH).read_bytes()
        world = WORLDS[self.world or "flat"]
        skills = Skills(drives=True)
        self._add_scene(skills, world, (*world.stand, DINGO_LIFT))
        self._add_rest("a Clearpath Dingo-D", skills)

    def add_robot(self, imported: Imported) -> None:
        """Add an imported robot with its description, meshes and graphs, and the files around them, such as the scene."""
        self._add_files(imported)
        world = WORLDS[self.world or ("table" if is_arm(imported) else "flat")]
        x, y, z = (*world.stand, imported.lift) if imported.free else world.mount
        place = (x, y, z + imported.rise)
        self._add_ros2_control(imported)
        self.extras = "usd,view" if imported.draft.description.usd is not None else "view"
        skills = skills_of(imported)
        self._add_scene(skills, world, place)
        self._add_rest(f"the robot of {imported.draft.source}", skills)

    def add_stage(
        self,
        robots: Sequence[Imported],
        scene: str,
        graphs: Mapping[str, str],
        copies: Mapping[Path, Path],
        source: str,
    ) -> None:
        """Add the robots, graphs and scene of a USD stage, and the files around them.

        Args:
            robots: imported robots.
            scene: text of the scene.
            graphs: texts of the graph files by name.
            copies: source of each file to copy, by destination.
            source: path of the stage.
        """
        for imported in robots:
            self._add_files(imported)
        self._contents |= {path: origin.read_bytes() for path, origin in copies.items()}
        for name, text in graphs.items():
            self._add(self.folder / "graphs" / f"{name}.yaml", text)
        self._add(self.scene_file, scene)
        self.extras = "usd,view"
        self._add_rest(f"the stage {source}", Skills())

    def write(self) -> None:
        """Write all files or none."""
        write_together(self._contents)

    def told(self) -> str:
        """Return a text for the user with the folder, its number of files, and the command to run next."""
        folder = near(str(self.folder))
        command = f"cd {quoted(folder)} && graphrun run {self.name}.yaml"
        return clean(f"{folder}: a project of {len(self._contents)} files\nnext: {command}")

    def _add(self, path: Path, text: str) -> None:
        self._contents[path] = text.encode()

    def _add_ros2_control(self, imported: Imported) -> None:
        """Add a xacro file for ros2_control with the commanded joints, if the robot has such joints."""
        from graphengine.bringup.robots import topic_based

        if joints := commanded(imported):
            block = topic_based.block(self.name, joints, imported.robot.starts)
            topics = {"states": topic_based.STATES, "commands": topic_based.COMMANDS}
            text = filled(TEMPLATES / "ros2_control.txt", name=self.name, block=block, **topics)
            self._add(self.folder / ROS2_CONTROL, text)

    def _add_files(self, imported: Imported) -> None:
        for path, text in imported.files.items():
            self._add(path, text)
        for path, source in imported.copies.items():
            self._contents[path] = source.read_bytes()

    def _add_scene(self, skills: Skills, world: WorldPlaces, place: Vector3) -> None:
        """Add a scene with one robot, whose position (m) is `place`."""
        position = {axis: f"{value:g}" for axis, value in zip("xyz", place, strict=True)}
        names = {"name": self.name, "key": scalar(self.name), "world": world.file}
        self._add(self.scene_file, filled(TEMPLATES / "scene.txt", {"stands": skills.stands}, **names, **position))

    def _add_rest(self, source: str, skills: Skills) -> None:
        """Add the test, the README and the requirements.

        Args:
            source: origin of the robot, with which the README begins.
            skills: skills of the robot, for the test and the README.
        """
        self.holds = skills.holds
        self._add(self.folder / "test_robot.py", test_file(self.name, skills))
        needed = requirement(self.extras)
        self._add(self.folder / "requirements.txt", f"{needed}\npytest\n")
        by_hand = [needed.removeprefix("# ")] if needed.startswith("#") else []
        moves = "Move the robot from another terminal while the simulation runs:"
        readme = filled(
            TEMPLATES / "readme.txt",
            {"examples": bool(skills.examples), "ros2_control": self.folder / ROS2_CONTROL in self._contents},
            name=self.name,
            source=source,
            version=__version__,
            installation="\n".join(f"    {command}" for command in (*by_hand, "pip install -r requirements.txt")),
            commands=usage(self.name, skills),
            examples="\n\n".join(f"{moves}\n\n    {command}" for command in skills.examples),
        )
        self._add(self.folder / "README.md", readme)
