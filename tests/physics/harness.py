"""Scenes for the tests of the world: those that ship, and a small one that a test may write over."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from graphengine.devices.rotation import Quaternion
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.core.simulation_core import SimulationCore
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.loading import load_world
from graphengine.physics.simulation import Simulation

SHIPPED = Path(__file__).resolve().parents[2] / "scenes"

FLOOR = '<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1" friction="0.8"/></worldbody></mujoco>'
SCENE = "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml, position: [0, 0, 0.1]}\n"
ROBOT = "robot: bot\nurdf: bot.urdf\n"
CART = """<robot name="cart">
  <link name="base_link">
    <inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".4 .3 .1"/></geometry></collision>
  </link>
  <link name="arm">
    <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 .2"/><geometry><sphere radius=".05"/></geometry></collision>
  </link>
  <link name="plate"/>
  <joint name="arm_joint" type="revolute">
    <parent link="base_link"/><child link="arm"/><origin xyz=".1 0 .1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="40" velocity="1"/>
  </joint>
  <joint name="plate_joint" type="fixed">
    <parent link="arm"/><child link="plate"/><origin xyz="0 0 .3" rpy="0 0 1.5707963267948966"/>
  </joint>
</robot>
"""


class Project:
    """A folder with a scene, a world, a robot file and a description; each may be written anew."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write("scene.yaml", SCENE).write("world.xml", FLOOR).write("bot.yaml", ROBOT).write("bot.urdf", CART)

    def write(self, name: str, text: str) -> Project:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return self

    def robot(self, keys: str) -> Project:
        """Write the robot file with more keys."""
        return self.write("bot.yaml", f"{ROBOT}{keys}\n")

    def cart(self, old: str, new: str) -> Project:
        """Write the description with a part replaced."""
        assert old in CART
        return self.write("bot.urdf", CART.replace(old, new))

    def scene(self, more: str) -> Project:
        """Write the scene with more robots, or more keys."""
        return self.write("scene.yaml", SCENE + more)

    def world(self, *things: str, before: str = "") -> Project:
        """Write the world, a floor with things on it; `before` stands before the `worldbody`."""
        floor = FLOOR.replace("<worldbody>", f"{before}<worldbody>", 1)
        return self.write("world.xml", floor.replace("</worldbody>", f"{''.join(things)}</worldbody>"))

    def try_load(self) -> tuple[LoadedWorld | None, Findings]:
        return try_load(self.folder / "scene.yaml")

    def load(self) -> LoadedWorld:
        return load(self.folder / "scene.yaml")

    def load_joints(self) -> tuple[Simulation, Joints]:
        """The simulation, and the joints of its robot."""
        simulation = self.load().simulation
        return simulation, simulation.articulation(simulation.stage.find("/bot"))

    def load_with_findings(self) -> tuple[LoadedWorld, Findings]:
        return load_with_findings(self.folder / "scene.yaml")

    def errors(self) -> list[str]:
        """Code, place and message of each error, without the folder."""
        loaded, findings = self.try_load()
        assert (loaded is None) == bool(findings.errors)
        return [finding.render().replace(f"{self.folder}/", "") for finding in findings.errors]

    def error(self) -> str:
        (only,) = self.errors()
        return only


def try_load(path: Path) -> tuple[LoadedWorld | None, Findings]:
    findings = Findings()
    scene = read(SceneSpec, path, findings)
    return (load_world(scene, Files.of(path), findings) if scene else None), findings


def load_with_findings(path: Path) -> tuple[LoadedWorld, Findings]:
    loaded, findings = try_load(path)
    assert loaded is not None, "\n".join(finding.render() for finding in findings.errors)
    return loaded, findings


def load(path: Path) -> LoadedWorld:
    return load_with_findings(path)[0]


def steps(simulation: SimulationCore, count: int) -> None:
    for _ in range(count):
        simulation.step()


def ticks(simulation: SimulationCore, count: int = 1, each: Callable[[], object] = lambda: None) -> None:
    """Run whole ticks, and do something at the end of each."""
    for _ in range(count):
        steps(simulation, simulation.substeps)
        simulation.begin_tick(simulation.tick + 1)
        each()


def yaw_of(orientation: Quaternion) -> float:
    x, y, z, w = orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
