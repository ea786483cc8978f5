"""Scripts with nodes for holonomic bases, actuators, radars and buffers, from the import to the robot and its topics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.isaac.harness import imported
from tests.jobs.harness import Job
from tests.nodes import scenes
from tests.nodes.harness import read_points, write
from tests.physics.bases import MECANUM, MECANUM_WHEELS
from tests.physics.pictures.harness import needs_opengl

WALL = """<mujoco><worldbody><geom type="plane" size="0 0 1" friction="0.8"/>
  <geom type="box" size=".1 9 9" pos="8.1 0 0" rgba="0 0 1 1"/></worldbody></mujoco>"""
SCENE = """scene: seen
world: world.xml
robots:
  bot: {use: bot.yaml, position: [0, 0, 0.05]}
graphs:
"""
EYES = MECANUM_WHEELS + (
    "sensors:\n"
    "  radar: {type: radar, profile: radar_77ghz, parent: base_link, position: [0.2, 0, 0.5]}\n"
    "  lidar: {type: lidar, profile: lidar_3d_16, parent: base_link, position: [0.2, 0, 0.5]}\n"
    "  eye: {type: camera, profile: camera, parent: base_link, position: [0.2, 0, 0.5]}\n"
)
SCRIPT = """
import omni.graph.core as og
keys = og.Controller.Keys
def build(name, nodes, values, wires):
    nodes = [("Tick", "omni.graph.action.OnPlaybackTick"), *nodes]
    where = {"graph_path": f"/World/{name}", "evaluator_name": "execution"}
    og.Controller.edit(where, {keys.CREATE_NODES: nodes, keys.SET_VALUES: values, keys.CONNECT: wires})
"""
DRIVE = """
setup = ("wheelRadius", "wheelPositions", "wheelOrientations", "mecanumAngles", "wheelAxis", "upAxis")
build(
    "drive",
    [
        ("Setup", "isaacsim.robot.wheeled_robots.HolonomicRobotUsdSetup"),
        ("Controller", "isaacsim.robot.wheeled_robots.HolonomicController"),
        ("Wheels", "isaacsim.core.nodes.IsaacArticulationController"),
        ("Actuators", "isaacsim.core.experimental.actuators.ArticulationActuators"),
        ("Echo", "isaacsim.core.nodes.IsaacTestNode"),
    ],
    [
        ("Setup.inputs:usePath", True),
        ("Setup.inputs:robotPrimPath", "/bot"),
        ("Setup.inputs:comPrimPath", "/bot/base_link"),
        ("Controller.inputs:rolling", True),
        ("Controller.inputs:inputVelocity", [0.2, 0.1, 0.0]),
        ("Wheels.inputs:robotPath", "/bot"),
        ("Actuators.inputs:robotPath", "/bot"),
        ("Actuators.inputs:feedforwardCommand", [0.0]),
        ("Echo.inputs:input", "hello"),
    ],
    [(f"Setup.outputs:{name}", f"Controller.inputs:{name}") for name in setup]
    + [
        ("Setup.outputs:wheelDofNames", "Wheels.inputs:jointNames"),
        ("Controller.outputs:jointVelocityCommand", "Wheels.inputs:velocityCommand"),
        ("Tick.outputs:tick", "Controller.inputs:execIn"),
        ("Tick.outputs:tick", "Wheels.inputs:execIn"),
        ("Tick.outputs:tick", "Actuators.inputs:execIn"),
        ("Tick.outputs:tick", "Echo.inputs:execIn"),
    ],
)
"""
RADAR = """
build(
    "radar",
    [
        ("Once", "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame"),
        ("Product", "isaacsim.core.nodes.IsaacCreateRenderProduct"),
        ("Radar", "isaacsim.ros2.bridge.ROS2RtxRadarHelper"),
    ],
    [
        ("Product.inputs:cameraPrim", "/bot/base_link/radar/Radar"),
        ("Radar.inputs:outputRadialVelocityMS", True),
        ("Radar.inputs:frameId", "radar"),
    ],
    [
        ("Tick.outputs:tick", "Once.inputs:execIn"),
        ("Once.outputs:step", "Product.inputs:execIn"),
        ("Product.outputs:execOut", "Radar.inputs:execIn"),
        ("Product.outputs:renderProductPath", "Radar.inputs:renderProductPath"),
    ],
)
"""
SENSORS = {
    "radar": "isaacsim.sensors.rtx.nodes.OgnIsaacExtractRTXSensorPointCloud",
    "lidar": "omni.isaac.sensor.IsaacCreateRTXLidarScanBuffer",
}
POINTS = """
build(
    "KIND_points",
    [("Points", "TYPE"), ("Publish", "isaacsim.ros2.bridge.ROS2PublishPointCloud")],
    [
        ("Points.inputs:renderProductPath", "/bot/base_link/KIND/PRIM"),
        ("Publish.inputs:topicName", "KIND_points"),
    ],
    [
        ("Tick.outputs:tick", "Points.inputs:exec"),
        ("Points.outputs:exec", "Publish.inputs:execIn"),
        ("Points.outputs:dataPtr", "Publish.inputs:dataPtr"),
    ],
)
"""
PICTURES = """
build(
    "pictures",
    [
        ("Product", "isaacsim.core.nodes.IsaacCreateRenderProduct"),
        ("Colours", "isaacsim.core.nodes.IsaacConvertRGBAToRGB"),
        ("Depths", "isaacsim.core.nodes.IsaacConvertDepthToPointCloud"),
        ("Image", "isaacsim.ros2.bridge.ROS2PublishImage"),
        ("Cloud", "isaacsim.ros2.bridge.ROS2PublishPointCloud"),
    ],
    [
        ("Product.inputs:cameraPrim", "/bot/base_link/eye/Camera"),
        ("Product.inputs:width", 32),
        ("Product.inputs:height", 24),
    ],
    [
        ("Tick.outputs:tick", "Product.inputs:execIn"),
        ("Product.outputs:execOut", "Colours.inputs:execIn"),
        ("Product.outputs:execOut", "Depths.inputs:execIn"),
        ("Product.outputs:renderProductPath", "Colours.inputs:renderProductPath"),
        ("Product.outputs:renderProductPath", "Depths.inputs:renderProductPath"),
        ("Colours.outputs:execOut", "Image.inputs:execIn"),
        ("Colours.outputs:dataPtr", "Image.inputs:dataPtr"),
        ("Colours.outputs:width", "Image.inputs:width"),
        ("Colours.outputs:height", "Image.inputs:height"),
        ("Colours.outputs:encoding", "Image.inputs:encoding"),
        ("Depths.outputs:execOut", "Cloud.inputs:execIn"),
        ("Depths.outputs:dataPtr", "Cloud.inputs:dataPtr"),
    ],
)
"""


def started(folder: Path, *parts: str) -> Job:
    """A mecanum base before a wall, with the graphs of a script."""
    (folder / "script.py").write_text(SCRIPT + "".join(parts), "utf-8")
    written, findings = imported(folder / "script.py", folder)
    assert [one.render() for one in findings.items if one.code not in ("N101", "N301")] == []
    write(folder, MECANUM.files(EYES) | {"world.xml": WALL})
    graphs = "".join(f"  {path.stem}: {{use: {path.name}}}\n" for path in written)
    (folder / "scene.yaml").write_text(SCENE + graphs, "utf-8")
    return Job(folder / "scene.yaml")


def test_a_mecanum_base_drives_to_a_wall_that_its_radar_sees_come_nearer(tmp_path: Path) -> None:
    with started(tmp_path, DRIVE, RADAR) as job:
        job.run(4.0)
        clouds = job.heard("/radar_point_cloud")
    assert len(clouds) == 81
    nearer = [np.median([x for x in read_points(cloud)["x"] if x > 6.0]) for cloud in (clouds[20], clouds[-1])]
    assert nearer[0] - nearer[1] == pytest.approx(0.2 * 3.0, abs=0.05)
    columns = {name: np.array(values) for name, values in read_points(clouds[-1]).items()}
    ahead = (columns["x"] > 6.0) & (np.abs(columns["y"]) < 1.0)
    assert columns["radial_velocity_ms"][ahead].mean() == pytest.approx(-0.2, abs=0.02)


@pytest.mark.parametrize("kind", SENSORS)
def test_buffers_of_points_are_published(tmp_path: Path, kind: str) -> None:
    text = POINTS.replace("KIND", kind).replace("TYPE", SENSORS[kind]).replace("PRIM", kind.capitalize())
    with started(tmp_path, text) as job:
        job.run(1.0)
        cloud = job.newest(f"/{kind}_points")
    points = {name: np.array(values) for name, values in read_points(cloud).items()}
    ahead = (points["x"] > 6.0) & (np.abs(points["y"]) < 1.0) & (points["z"] > -0.4)  # not the floor
    assert points["x"][ahead].mean() == pytest.approx(7.8, abs=0.05)


@needs_opengl
def test_pictures_of_a_camera_become_an_image_and_points(tmp_path: Path) -> None:
    with started(tmp_path, PICTURES) as job:
        job.run(1.0)
        image, cloud = job.newest("/rgb"), job.newest("/point_cloud")
    assert (image.width, image.height, image.encoding) == (32, 24, "rgb8")
    red, _, blue = np.frombuffer(bytes(image.data), np.uint8).reshape(24, 32, 3)[6, 16].tolist()
    assert blue > red + 40
    points = np.array([read_points(cloud)[axis] for axis in "xyz"]).T.reshape(24, 32, 3)
    assert points[6, 16, 2] == pytest.approx(7.8, abs=0.05)
    assert points[6, 16, 0] == pytest.approx(0.0, abs=1e-6)


ARM = [f"panda_joint{number}" for number in range(1, 4)]
TUTORIAL = f"""
build(
    "arm",
    [
        ("RobotPath", "omni.graph.nodes.ConstantString"),
        ("TargetPositions", "omni.graph.nodes.ConstructArray"),
        ("ArticulationActuators", "isaacsim.core.experimental.actuators.ArticulationActuators"),
        ("ArticulationController", "isaacsim.core.nodes.IsaacArticulationController"),
        ("States", "isaacsim.ros2.bridge.ROS2PublishJointState"),
        *[(f"Pose{{i}}", "omni.graph.nodes.ConstantDouble") for i in range({len(ARM)})],
    ],
    [
        ("RobotPath.inputs:value", "/robot"),
        ("TargetPositions.inputs:arraySize", {len(ARM)}),
        ("TargetPositions.inputs:arrayType", "double[]"),
        ("States.inputs:targetPrim", "/robot"),
        *[(f"Pose{{i}}.inputs:value", 0.1 * i) for i in range({len(ARM)})],
    ],
    [
        ("Tick.outputs:tick", "ArticulationActuators.inputs:execIn"),
        ("Tick.outputs:tick", "ArticulationController.inputs:execIn"),
        ("Tick.outputs:tick", "States.inputs:execIn"),
        ("RobotPath.inputs:value", "ArticulationActuators.inputs:robotPath"),
        ("RobotPath.inputs:value", "ArticulationController.inputs:robotPath"),
        ("TargetPositions.outputs:array", "ArticulationController.inputs:positionCommand"),
        *[(f"Pose{{i}}.inputs:value", f"TargetPositions.inputs:input{{i}}") for i in range({len(ARM)})],
    ],
)
"""
"""The graph of Isaac Sim's tutorial on actuators."""


def test_the_graph_of_isaac_sims_tutorial_on_actuators_brings_an_arm_to_its_pose(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT + TUTORIAL, "utf-8")
    (written,), findings = imported(tmp_path / "script.py", tmp_path)
    assert [one.render() for one in findings.items if one.code not in ("N101", "N301")] == []
    write(tmp_path, scenes.arm(ARM, 64.0, 8.0) | {"graph.yaml": written.read_text("utf-8")})
    with Job(tmp_path / "scene.yaml") as job:
        job.run(3.0)
        state = job.newest("/joint_states")
    assert state.name == ARM
    np.testing.assert_allclose(state.position, [0.0, 0.1, 0.2], atol=0.01)
