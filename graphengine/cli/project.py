"""The files of a new project."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import clean, table
from graphengine.format.atomic_write import write_together
from graphengine.format.files import near, shipped
from graphengine.format.version import __version__
from graphengine.format.yaml_text import scalar

if TYPE_CHECKING:
    from graphengine.physics.importing.import_robot import Imported

WORLDS = {
    "flat": ("worlds/flat_grid.xml", (0.0, 0.0)),
    "warehouse": ("worlds/warehouse_features.xml", (-3.0, 6.0)),
}
"""File of each world, and a free place (m) to begin at."""
DINGO = Path("scenes/robots/dd100.yaml")
DINGO_GRAPH = Path("graphs/dd100/cmd_vel.yaml")
DINGO_LIFT = 0.025
"""Height (m) of the Dingo-D's base link above the floor, from which it settles."""

SCENE = """\
# What `graphrun run {name}.yaml` runs.
format: 1
scene: {key}
world: {world}    # a world of graphengine; or an MJCF file in this folder
physics: {{tick_rate: 60, substeps: 4}}
settle: {settle}
robots:
  {key}:
    use: robots/{name}.yaml
    position: [{x:g}, {y:g}, {z:g}]    # m
    orientation: {{rpy_deg: [0, 0, 0]}}
    robot_state: true    # publishes /robot_description, /tf and /tf_static, as robot_state_publisher does
    # namespace: {name}    # puts its topics below /{name}
graphs:
  clock: {{use: graphs/clock.yaml, at: /World/clock}}
"""

SETTLED = "true    # the robot comes to rest before t = 0"
STANDING = "false    # the graph that holds the robot runs from t = 0 on"

DINGO_ROBOT = """\
# The Clearpath Dingo-D that comes with graphengine. Keys that you write here replace or add to those of the extended file.
format: 1
robot: {key}
extends: robots/dd100.yaml
graphs:
  cmd_vel: {{use: ../graphs/cmd_vel.yaml}}    # your copy: change a number and run again
"""

TEST = '''\
"""The robot follows its commands on a flat floor."""

from pathlib import Path

from graphengine.cli import main

SCENE = Path(__file__).with_name("{name}.yaml")


def test_the_files_have_no_mistakes() -> None:
    assert main(["check", str(SCENE)]) == 0


def test_the_robot_follows_its_commands_within_two_percent() -> None:
    assert main(["calibrate", str(SCENE), "--check", "0.02"]) == 0
'''

README = """\
# {name}

{source}, run by graphengine {version}: `pip install -r requirements.txt`, then in this folder

{commands}

`{name}.yaml` is the scene: the world and where the robot stands, `robots/{name}.yaml` the robot, `graphs/` what it does.
"""


COMMANDS = (
    ("graphrun run {name}.yaml --view", "# the robot and its graphs in a browser; --watch reloads files that you save"),
    ("graphrun teleop", "# in another terminal: drive it from the keyboard"),
    ("graphrun topics {name}.yaml", "# the topics that it publishes and subscribes to"),
    ("graphrun calibrate {name}.yaml", "# commanded against reached motion, and the errors of its odometry"),
    ("graphrun check {name}.yaml && pytest", "# before you commit"),
)


class Project:
    """The files of a project, by path; nothing is written before `write`.

    Args:
        folder: where they go.
        name: of the robot and the scene.
        world: a key of `WORLDS`.
    """

    def __init__(self, folder: Path, name: str, world: str) -> None:
        self.folder = folder
        self.name = name
        self.world = world
        self.robot_file = folder / "robots" / f"{name}.yaml"
        self._contents: dict[Path, bytes] = {}

    def add_dingo(self) -> None:
        """Add the Dingo-D with a copy of the graph that drives it."""
        self._add(self.robot_file, DINGO_ROBOT.format(key=scalar(self.name)))
        self._contents[self.folder / "graphs" / DINGO_GRAPH.name] = (shipped() / DINGO_GRAPH).read_bytes()
        self._add_rest("A Clearpath Dingo-D", DINGO_LIFT)

    def add_robot(self, imported: Imported) -> None:
        """Add an imported robot with its description, meshes and graphs."""
        for path, text in imported.files.items():
            self._add(path, text)
        for path, source in imported.copies.items():
            self._contents[path] = source.read_bytes()
        settle = SETTLED if imported.settles else STANDING
        self._add_rest(f"The robot of {imported.draft.source}", imported.lift, settle)

    def write(self) -> None:
        """Write all files or none."""
        write_together(self._contents)

    def told(self) -> str:
        """What was written and what to do next."""
        folder = near(str(self.folder))
        return clean(
            f"{folder}: a project of {len(self._contents)} files\nnext: cd {folder} && graphrun run {self.name}.yaml"
        )

    def _add(self, path: Path, text: str) -> None:
        self._contents[path] = text.encode()

    def _add_rest(self, source: str, lift: float, settle: str = SETTLED) -> None:
        """Add the scene, with the robot at a height (m), and what does not depend on the robot."""
        world, (x, y) = WORLDS[self.world]
        scene = SCENE.format(name=self.name, key=scalar(self.name), world=world, x=x, y=y, z=lift, settle=settle)
        self._add(self.folder / f"{self.name}.yaml", scene)
        self._add(self.folder / "test_drive.py", TEST.format(name=self.name))
        self._add(self.folder / "requirements.txt", f"graphengine[view]=={__version__}\npytest\n")
        commands = table([(command.format(name=self.name), about) for command, about in COMMANDS], indent="    ")
        readme = README.format(name=self.name, source=source, version=__version__, commands=commands)
        self._add(self.folder / "README.md", readme)
