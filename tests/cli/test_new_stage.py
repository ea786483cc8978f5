"""`graphrun new --from stage.usda` makes a scene that runs of the robots, the world and the graphs of one stage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("pxr")

from pxr import Sdf, Usd, UsdPhysics

import graphengine as ge
from tests.cli.harness import Graphrun
from tests.descriptions.usd.stages import StageWriter, arm
from tests.descriptions.usd.tutorial_stage import hall

DINGO = "/World/dd100_with_sensors"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scene_of(path: str) -> Any:
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


def driven(scene: str, robot: str, topic: str, seconds: float) -> tuple[float, float, float]:
    """The way of a robot that drives at a command of 0.5 m/s: distance (m), direction (degrees), height at the end (m)."""
    with ge.load(scene).session() as sim:
        sim.publish(topic, {"linear": {"x": 0.5}}, every=0.1, type="geometry_msgs/msg/Twist")
        sim.run(0.5)
        x, y, _ = sim.robots[robot].pose.position
        sim.run(seconds)
        to_x, to_y, height = sim.robots[robot].pose.position
    return math.hypot(to_x - x, to_y - y), math.degrees(math.atan2(to_y - y, to_x - x)), height


def topics(result: Sequence[str]) -> set[str]:
    return {line.split()[0] for line in result if line.startswith("/")}


def test_the_tutorials_stage_drives_as_its_urdf_does_and_has_its_topics(folder: Path, graphrun: Graphrun) -> None:
    hall(folder)
    result = graphrun("new", "made", "--from", "dd100_warehouse_navigation.usda", code=0)
    assert "graphs: scan, joint_states, cmd_vel, clock" in result.lines
    assert "graphs" not in scene_of("made/robots/made.yaml")
    told = graphrun("topics", "made/made.yaml", code=0)
    names = ("cmd_vel", "platform/joint_states", "odom", "sim_lidar/scan", "tf", "tf_static")
    assert topics(told.lines) >= {"/clock", *(f"/dd100_0000/{name}" for name in names)}
    made = driven("made/made.yaml", "made", "/dd100_0000/cmd_vel", 8.2)
    urdf = driven("tutorial/navigation", "dd100", "/dd100_0000/cmd_vel", 8.2)
    assert made == pytest.approx(urdf, rel=0.01)
    assert made[0] == pytest.approx(
        0.5 * 0.049 / 0.1 * 8.2, rel=0.03
    )  # the graph takes 0.1 m for the radius of 0.049 m


def test_a_stage_without_a_world_stands_on_the_flat_floor(folder: Path, graphrun: Graphrun) -> None:
    writer = StageWriter(folder / "cart.usda")
    cart(writer, "/World/cart")
    writer.save()
    graphrun("new", "made", "--from", "cart.usda", code=0)
    scene = scene_of("made/made.yaml")
    assert scene["world"] == "worlds/flat_grid.xml"
    assert scene["robots"]["made"]["at"] == "/World/cart"
    assert driven("made/made.yaml", "made", "/cmd_vel", 4.0)[0] == pytest.approx(0.5 * 4.0, rel=0.01)


def test_two_robots_of_a_stage_stand_in_its_world(folder: Path, graphrun: Graphrun) -> None:
    writer = StageWriter(folder / "cell.usda")
    writer.shape("Plane", "/World/floor")
    writer.body("/World/crate", (3.0, 3.0, 0.2), mass=2.0)
    writer.shape("Cube", "/World/crate/box", edges=(0.4, 0.4, 0.4))
    for name, y in (("left", 1.0), ("right", -1.0)):
        cart(writer, f"/World/{name}", (0.0, y, 0.0), topic=f"{name}/cmd_vel")
    writer.save()
    graphrun("new", "made", "--from", "cell.usda", code=0)
    assert [*scene_of("made/made.yaml")["robots"]] == ["left", "right"]
    with ge.load("made/made.yaml").session() as sim:
        sim.publish("/right/cmd_vel", {"linear": {"x": 0.5}}, every=0.1, type="geometry_msgs/msg/Twist")
        sim.run(2.0)
        lost = 0.5**2 / (2 * 0.5 * 9.81 * 0.7)  # until the wheels, which carry 70 %, have pushed it to 0.5 m/s
        assert sim.robots["right"].pose.position[:2] == pytest.approx((1.0 - lost, -1.0), abs=0.01)
        assert sim.robots["left"].pose.position[:2] == pytest.approx((0.0, 1.0), abs=0.001)
        assert sim.body("crate").pose.position == pytest.approx((3.0, 3.0, 0.2), abs=0.002)


def test_a_graph_that_cannot_run_is_left_out_of_the_scene_and_told(folder: Path, graphrun: Graphrun) -> None:
    writer = StageWriter(folder / "cell.usda")
    cart(writer, "/World/cart")
    writer.stage.DefinePrim("/World/other", "OmniGraph")
    node(writer.stage, "/World/other/Odd", "omni.replicator.core.Writer")
    writer.save()
    result = graphrun("new", "made", "--from", "cell.usda", code=0)
    assert "not carried over: the scene leaves out the graph other" in result.out
    assert [*scene_of("made/made.yaml")["graphs"]] == ["clock_of_scene", "drive"]
    graphrun("check", "made/made.yaml", code=0)


def test_a_hall_on_a_server_is_brought_by_a_mirror_and_a_variant_is_selected_for_all_parts(
    folder: Path, graphrun: Graphrun
) -> None:
    writer = StageWriter(folder / "cell.usda")
    cart(writer, "/World/cart")
    room = writer.stage.DefinePrim("/World/hall", "Xform")
    room.GetReferences().AddReference("https://assets.example/Isaac/hall.usda", "/Hall")
    crates = writer.stage.DefinePrim("/World/load", "Xform").GetVariantSets().AddVariantSet("load")
    for name in ("empty", "full"):
        crates.AddVariant(name)
        crates.SetVariantSelection(name)
        with crates.GetVariantEditContext():
            if name == "full":
                writer.body("/World/load/crate", (2.0, 2.0, 0.2), mass=1.0)
                writer.shape("Cube", "/World/load/crate/box", edges=(0.4, 0.4, 0.4))
    crates.SetVariantSelection("empty")
    writer.save()
    (folder / "mirror").mkdir()
    hall = StageWriter(folder / "mirror/hall.usda")
    hall.shape("Plane", "/Hall/floor")
    hall.save()
    options = ("--assets", "mirror", "--variant", "load=full")
    graphrun("new", "made", "--from", "cell.usda", *options, code=0)
    scene = scene_of("made/made.yaml")
    assert scene["world"].endswith("cell.usda")
    assert scene["usd_variants"] == {"load": "full"}
    with ge.load("made/made.yaml", allow=["mirror"]).session() as sim:
        sim.run(0.5)
        assert sim.body("crate").pose.position == pytest.approx((2.0, 2.0, 0.2), abs=0.002)
        assert sim.robots["made"].pose.position[2] == pytest.approx(0.05, abs=0.002)


def test_a_robot_alone_is_imported_as_before(folder: Path, graphrun: Graphrun) -> None:
    arm(folder / "arm.usda")
    graphrun("new", "made", "--from", "arm.usda", code=0)
    assert scene_of("made/made.yaml")["world"] == "worlds/table.xml"


def test_a_broken_stage_writes_nothing(folder: Path, graphrun: Graphrun) -> None:
    (folder / "bad.usda").write_text("#usda 1.0\ndef {\n", encoding="utf-8")
    assert "bad.usda:2:" in graphrun("new", "made", "--from", "bad.usda", code=1).err
    assert not Path("made").exists()


def node(stage: Usd.Stage, path: str, kind: str, **values: Any) -> Usd.Prim:
    """Add a node with values; a value that is a pair (node, port) is a wire."""
    prim = stage.DefinePrim(path, "OmniGraphNode")
    prim.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set(kind)
    types = {float: Sdf.ValueTypeNames.Double, str: Sdf.ValueTypeNames.String, list: Sdf.ValueTypeNames.TokenArray}
    for name, value in values.items():
        if isinstance(value, tuple):
            made = prim.CreateAttribute(f"inputs:{name}", Sdf.ValueTypeNames.Token)
            made.AddConnection(
                prim.GetPath().GetParentPath().AppendChild(value[0]).AppendProperty(f"outputs:{value[1]}")
            )
        elif isinstance(value, Sdf.Path):
            prim.CreateRelationship(f"inputs:{name}").SetTargets([value])
        else:
            prim.CreateAttribute(f"inputs:{name}", types[type(value)]).Set(value)
    return prim


def cart(
    writer: StageWriter, path: str, at: tuple[float, float, float] = (0.0, 0.0, 0.0), topic: str = "cmd_vel"
) -> None:
    """A robot of 10.7 kg with two wheels of radius 0.05 m, 0.45 m apart, a ball behind, and a graph that drives it."""
    writer.place(writer.robot(path), at)
    writer.body(f"{path}/chassis", (0.0, 0.0, 0.05), mass=10.0)
    writer.shape("Cube", f"{path}/chassis/box", (0.0, 0.0, 0.05), edges=(0.5, 0.4, 0.06))
    ball = writer.shape("Sphere", f"{path}/chassis/ball", (-0.2, 0.0, -0.04), radius=0.01)
    UsdPhysics.MassAPI.Apply(ball).CreateMassAttr(0.5)
    for name, y in (("left", 0.225), ("right", -0.225)):
        writer.body(f"{path}/{name}_wheel", (0.1, y, 0.05), mass=0.1)
        writer.shape("Cylinder", f"{path}/{name}_wheel/tyre", radius=0.05, height=0.02, axis="Y")
        bodies = (f"{path}/chassis", f"{path}/{name}_wheel")
        joint = writer.joint("Revolute", f"{path}/{name}_wheel_joint", bodies, "Y", (0.1, y, 0.0))
        writer.drive(joint, stiffness=0.0, damping=10000.0)
    graph = writer.stage.DefinePrim(f"{path}/drive", "OmniGraph").GetPath()
    writer.stage.GetPrimAtPath(graph).CreateAttribute("evaluator:type", Sdf.ValueTypeNames.Token).Set("execution")
    own, core = "isaacsim.ros2.bridge", "omni.graph"
    node(writer.stage, f"{graph}/Tick", f"{core}.action.OnPlaybackTick")
    node(writer.stage, f"{graph}/Twist", f"{own}.ROS2SubscribeTwist", topicName=topic, execIn=("Tick", "tick"))
    node(writer.stage, f"{graph}/Ahead", f"{core}.nodes.BreakVector3", tuple=("Twist", "linearVelocity"))
    node(writer.stage, f"{graph}/Turn", f"{core}.nodes.BreakVector3", tuple=("Twist", "angularVelocity"))
    node(
        writer.stage,
        f"{graph}/Base",
        "isaacsim.robot.wheeled_robots.DifferentialController",
        wheelDistance=0.45,
        wheelRadius=0.05,
        dt=("Tick", "deltaSeconds"),
        execIn=("Twist", "execOut"),
        linearVelocity=("Ahead", "x"),
        angularVelocity=("Turn", "z"),
    )
    node(
        writer.stage,
        f"{graph}/Wheels",
        "isaacsim.core.nodes.IsaacArticulationController",
        jointNames=["left_wheel_joint", "right_wheel_joint"],
        targetPrim=Sdf.Path(path),
        execIn=("Tick", "tick"),
        velocityCommand=("Base", "velocityCommand"),
    )
