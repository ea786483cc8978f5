"""ReadPrimAttribute, WritePrimAttribute and the nodes that read poses: alone, and in graphs over physics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine import build
from graphengine.diagnostics import CheckError, ContextError, NodeError
from graphengine.prim_attributes import PORT_TYPES, StagePrims, type_of_attribute
from graphengine.spec import RobotUse
from graphengine.testing import RecordingContext
from nodes.prims import GetPrimLocalToWorldTransform, ReadPrimAttribute, ReadPrimLocalTransform, WritePrimAttribute
from tests.nodes.harness import Player, Playing, matrix, ready, yaw
from tests.nodes.test_service_prim import ARM, SCENE, URDF, WORLD

BOX = "/World/box"


def box() -> RecordingContext:
    """A body that is turned about z."""
    context = RecordingContext()
    context.world.add_body(BOX, (1.0, 2.0, 3.0), yaw(0.5))
    return context


@pytest.mark.parametrize("where", [{"prim": BOX}, {"prim_path": BOX, "use_path": True}])
def test_an_attribute_is_read_as_ports_carry_it(where: dict[str, Any]) -> None:
    node = ready(ReadPrimAttribute, box(), name="xformOp:translate", **where)
    node.compute()
    assert node.value == (1.0, 2.0, 3.0)
    node = ready(ReadPrimAttribute, box(), name="xformOp:orient", **where)
    node.compute()
    assert node.value == pytest.approx(yaw(0.5))


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("xformOp:translate", (4, 5.5, -6), (4.0, 5.5, -6.0)),
        ("xformOp:translate", np.array([4.0, 5.0, 6.0]), (4.0, 5.0, 6.0)),
        ("xformOp:orient", yaw(-1.0), yaw(-1.0)),
    ],
)
def test_what_is_written_is_read(name: str, value: Any, read: Any) -> None:
    context = box()
    ready(WritePrimAttribute, context, prim=BOX, name=name, value=value).compute()
    node = ready(ReadPrimAttribute, context, prim=BOX, name=name)
    node.compute()
    assert node.value == pytest.approx(read)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ((1.0, 2.0), r"is a double\[3\]: expected 3 values, got 2"),
        ("up", r"is a double\[3\]: expected a list of 3 values, got 'up'"),
        ((1.0, 2.0, math.nan), r"xformOp:translate of /World/box: it has to be .*, not \[1.0, 2.0, nan\]"),
    ],
)
def test_a_value_that_does_not_fit_says_what_would(value: Any, told: str) -> None:
    node = ready(WritePrimAttribute, box(), prim=BOX, name="xformOp:translate", value=value)
    with pytest.raises(ContextError, match=told):
        node.compute()


def test_what_cannot_be_changed_says_what_can() -> None:
    with pytest.raises(ContextError, match="physics:mass of /World/box cannot be changed") as refused:
        ready(WritePrimAttribute, box(), prim=BOX, name="physics:mass", value=2.0)
    assert "what can be changed there: xformOp:translate, xformOp:orient" in str(refused.value)


def test_an_unknown_attribute_is_told_with_the_nearest() -> None:
    with pytest.raises(ContextError, match="has no attribute 'xformOp:translat'") as refused:
        ready(ReadPrimAttribute, box(), prim=BOX, name="xformOp:translat")
    assert "xformOp:translate" in str(refused.value)


def test_a_prim_on_the_other_input_is_pointed_at() -> None:
    with pytest.raises(ContextError, match="prim is empty") as refused:
        ready(ReadPrimAttribute, box(), prim_path=BOX, name="xformOp:translate")
    assert "primPath is set, which counts while usePath is true" in str(refused.value)


def test_a_pose_is_a_matrix_for_row_vectors() -> None:
    context = box()
    context.world.add_body("/World/box/lid", (1.0, 0.0, 0.0), yaw(0.25))
    whole = ready(GetPrimLocalToWorldTransform, context, prim_path=BOX)
    whole.compute()
    made = np.array(whole.local_to_world_transform).reshape(4, 4)
    assert made[:3, :3] == pytest.approx(matrix(yaw(0.5)).T)
    assert made[3].tolist() == [1.0, 2.0, 3.0, 1.0]
    local = ready(ReadPrimLocalTransform, context, prim="/World/box/lid")
    local.compute()
    world = context.world.body(context.world.stage.find("/World/box/lid")).pose()
    row = np.array([*world[0], 1.0])
    assert np.array([0.0, 0.0, 0.0, 1.0]) @ np.array(local.value).reshape(4, 4) @ made == pytest.approx(row)


GRAPH = """
format: 1
graph: prims
nodes:
  Tick: OnPlaybackTick
NODES
connections:
CONNECTIONS
"""


def arm(play: Player, nodes: str, connections: str, world: str = WORLD) -> Playing:
    """An arm that can turn, a free box, and some nodes."""
    lines = GRAPH.replace("NODES", nodes.strip("\n")).replace("CONNECTIONS", connections.strip("\n"))
    files = {"arm.yaml": ARM, "arm.urdf": URDF, "scene.yaml": SCENE, "world.xml": world, "prims.yaml": lines}
    return play.scene(files)


DRIVE = """
  Drive:
    type: WritePrimAttribute
    inputs: {prim: /arm/Physics/turn, name: 'drive:angular:physics:targetPosition', value: 45.0}
  Angle: {type: ReadPrimAttribute, inputs: {prim: /arm/Physics/turn, name: 'state:angular:physics:position'}}
  Target:
    type: ReadPrimAttribute
    inputs: {primPath: /arm/Physics/turn, usePath: true, name: 'drive:angular:physics:targetPosition'}
  Both: {type: ConstructArray, inputs: {arraySize: 2}}
  Each: ForEach
"""
WIRES = """
  - Tick.tick -> Drive.execIn
  - Drive.execOut -> Each.execIn
  - Angle.value -> Both.input0
  - Target.value -> Both.input1
  - Both.array -> Each.arrayIn
"""


def test_a_drive_is_told_where_to_go_in_degrees_and_goes_there(play: Player) -> None:
    playing = arm(play, DRIVE, WIRES)
    playing.tick()
    angle, target = playing.node("Both").array.tolist()
    assert target == 45.0
    assert abs(angle) < 1.0
    playing.tick(600)
    assert playing.node("Both").array.tolist() == pytest.approx([45.0, 45.0], abs=0.5)
    assert playing.node("Both").array.dtype == np.float32


def test_a_write_is_seen_by_what_reads_after_it_in_the_same_pass(play: Player) -> None:
    playing = arm(play, READING, READING_WIRES)
    playing.tick()
    before, after, last = (playing.node(name).position for name in ("Before", "After", "Last"))
    assert before == pytest.approx((0.0, 3.0, 1.0))
    assert after == last == (7.0, 8.0, 9.0)


READING = """
  Steps: Multisequence
  Put:
    type: WritePrimAttribute
    inputs: {prim: /World/box, name: 'xformOp:translate', value: {type: 'double[3]', value: [7, 8, 9]}}
  Read: {type: ReadPrimAttribute, inputs: {prim: /World/box, name: 'xformOp:translate'}}
  Path: {type: ToToken, inputs: {value: /World/box}}
  Pose: GetPrimLocalToWorldTransform
  Point: GetMatrix4Translation
  Before: {type: PublishOdometry, inputs: {topicName: before}}
  After: {type: PublishOdometry, inputs: {topicName: after}}
  Last: {type: PublishOdometry, inputs: {topicName: last}}
"""
READING_WIRES = """
  - Tick.tick -> Steps.execIn
  - Steps.output0 -> Before.execIn
  - Steps.output1 -> Put.execIn
  - Steps.output2 -> After.execIn
  - Steps.output3 -> Last.execIn
  - Read.value -> Before.position
  - Read.value -> After.position
  - Path.converted -> Pose.primPath
  - Pose.localToWorldTransform -> Point.matrix
  - Point.translation -> Last.position
"""


FALLING = """
<mujoco>
  <worldbody><body name="box" pos="0 3 100"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body></worldbody>
</mujoco>
"""
GRAVITY = """
  Weaken: {type: WritePrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityMagnitude', value: 2}}
  Strength: {type: ReadPrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityMagnitude'}}
  Way: {type: ReadPrimAttribute, inputs: {prim: /physicsScene, name: 'physics:gravityDirection'}}
  Loaded: OnLoaded
  Print: PrintText
  Text: ToString
  WayText: ToString
  PrintWay: PrintText
"""
GRAVITY_WIRES = """
  - Loaded.execOut -> Weaken.execIn
  - Tick.tick -> Print.execIn
  - Tick.tick -> PrintWay.execIn
  - Strength.value -> Text.value
  - Text.converted -> Print.text
  - Way.value -> WayText.value
  - WayText.converted -> PrintWay.text
"""


def test_gravity_that_is_written_is_what_bodies_fall_by_and_a_stop_takes_it_back(play: Player) -> None:
    playing = arm(play, GRAVITY, GRAVITY_WIRES, FALLING)
    world = playing.session.services.world
    assert world.gravity == (0.0, 0.0, -9.81)
    playing.tick(60)
    assert (playing.node("Print").text, playing.node("PrintWay").text) == ("2", "[0, 0, -1]")
    fallen = [world.entities.state("box").position[2]]
    playing.tick(60)
    fallen.append(world.entities.state("box").position[2])
    speed = world.entities.state("box").linear_velocity[2]
    playing.tick(60)
    assert world.entities.state("box").linear_velocity[2] - speed == pytest.approx(-2.0)
    playing.session.stop()
    assert world.gravity == (0.0, 0.0, -9.81)
    assert fallen[1] < fallen[0] < 100.0


@pytest.mark.parametrize("value", [-1.0, 1e9, math.nan, "up"])
def test_gravity_of_no_sense_is_refused(value: Any) -> None:
    context = RecordingContext()
    context.world.stage.add("/physicsScene", "scope")
    node = ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityMagnitude")
    node.value = value
    with pytest.raises(ContextError):
        node.compute()
    node = ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityDirection", value=(0, 0, 0))
    with pytest.raises(ContextError, match="gravity has a direction"):
        node.compute()
    assert context.world.gravity == (0.0, 0.0, -9.81)


def test_a_direction_is_of_length_one_and_keeps_the_magnitude() -> None:
    context = RecordingContext()
    context.world.stage.add("/physicsScene", "scope")
    ready(WritePrimAttribute, context, prim="/physicsScene", name="physics:gravityDirection", value=(3, 0, 4)).compute()
    assert context.world.gravity == pytest.approx((9.81 * 0.6, 0.0, 9.81 * 0.8))


def test_a_wrong_value_stops_the_run_and_names_the_attribute(play: Player) -> None:
    playing = arm(play, READING.replace("[7, 8, 9]", "[7, 8, .nan]"), READING_WIRES)
    with pytest.raises(NodeError, match="it has to be an array of 3 finite numbers"):
        playing.tick()


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("up", r"Put: value is token and xformOp:translate is double\[3\]"),
        ("[7, 8]", r"Put: value is int\[2\] and xformOp:translate is double\[3\]"),
    ],
)
def test_a_value_of_another_kind_is_told_before_the_run(play: Player, value: str, told: str) -> None:
    with pytest.raises(CheckError, match=told):
        arm(play, READING.replace("{type: 'double[3]', value: [7, 8, 9]}", value), READING_WIRES)


def test_a_list_needs_no_type_to_be_written(play: Player) -> None:
    playing = arm(play, READING.replace("{type: 'double[3]', value: [7, 8, 9]}", "[7, 8, 9]"), READING_WIRES)
    playing.tick()
    assert playing.node("Read").value == pytest.approx((7.0, 8.0, 9.0))


def test_what_cannot_be_written_is_told_before_the_run(play: Player) -> None:
    with pytest.raises(CheckError, match="physics:mass of /World/box cannot be changed while the simulation runs"):
        arm(play, READING.replace("'xformOp:translate', value", "'physics:mass', value"), READING_WIRES)


def test_a_reader_and_a_writer_in_no_order_are_told(play: Player) -> None:
    wires = READING_WIRES.replace("Steps.output1", "Steps.output0")
    arm(play, READING, wires)
    assembly = build.assemble(play.folder / "scene.yaml")
    told = [finding.message for finding in assembly.findings.items if finding.code == "W105"]
    assert "Before reads and Put writes pose /World, in no stated order" in told


def test_the_types_by_name_are_those_that_prims_have(play: Player) -> None:
    playing = arm(play, DRIVE, WIRES)
    prims, seen = StagePrims(playing.session.services.world), set()
    for path, _ in prims.below("/"):
        for name, kind in prims.attributes(path).items():
            assert type_of_attribute(name) == PORT_TYPES[kind]
            seen.add(name)
    assert len(seen) > 6
    assert type_of_attribute("drive:angular:physics:stiffness") is None


SLOPE = """
<mujoco>
  <worldbody><geom name="floor" type="plane" size="0 0 1" friction="0.4" euler="0 20 0"/></worldbody>
</mujoco>
"""
BLOCK = """
<robot name="block">
  <link name="base_link">
    <inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".4 .3 .1"/></geometry></collision>
  </link>
</robot>
"""
SLIDING = {
    "world.xml": SLOPE,
    "block.urdf": BLOCK,
    "block.yaml": """
robot: block
urdf: block.urdf
materials: {Rubber: {static_friction: 0.7, dynamic_friction: 0.6, bind: [base_link]}}
""",
    "scene.yaml": """
scene: slope
world: world.xml
robots:
  block: {use: block.yaml, position: [0, 0, 0.0535], orientation: {rpy_deg: [0, 20, 0]}}
graphs:
  friction: {use: friction.yaml, at: /World/friction}
""",
    "friction.yaml": """
format: 1
graph: friction
nodes:
  Tick: OnPlaybackTick
  Write:
    type: WritePrimAttribute
    inputs: {prim: /block/Materials/Rubber, name: 'physics:dynamicFriction', value: 0.6}
  Read: {type: ReadPrimAttribute, inputs: {prim: /block/Materials/Rubber, name: 'physics:dynamicFriction'}}
  Text: ToString
  Print: PrintText
connections:
  - Tick.tick -> Write.execIn
  - Write.execOut -> Print.execIn
  - Read.value -> Text.value
  - Text.converted -> Print.text
""",
}
RUBBER = "/block/Materials/Rubber"
MATERIAL = {
    "static_friction": 0.7,
    "dynamic_friction": 0.6,
    "bind": ("base_link",),
    "bodies": {"block/base_link": False},
}


def speed_on_slope(playing: Playing) -> float:
    return math.hypot(*playing.session.services.world.entities.state("block").linear_velocity)


def slide(play: Player) -> list[float]:
    """Speeds of the block: at rest, sliding a quarter of a second and a half, and after its friction was restored."""
    playing, speeds = play.scene(SLIDING), []
    for ticks, friction in ((60, 0.6), (15, 0.1), (15, 0.1), (60, 0.6)):
        playing.set("Write", "value", friction)
        playing.tick(ticks)
        speeds.append(speed_on_slope(playing))
        assert float(playing.node("Print").text) == pytest.approx(friction)
    return speeds


def test_a_block_slides_while_its_friction_is_below_the_tangent_of_the_slope(play: Player) -> None:
    # the mean with the floor's 0.4 is 0.5 or 0.25, and tan 20 deg = 0.364
    resting, early, late, stopped = slide(play)
    assert resting < 1e-3
    expected = 9.81 * (math.sin(math.radians(20)) - 0.25 * math.cos(math.radians(20)))
    assert (late - early) / 0.25 == pytest.approx(expected, rel=0.02)
    assert stopped < 1e-3


def test_two_runs_in_which_friction_is_written_are_the_same(play: Player) -> None:
    assert np.array(slide(play)).tobytes() == np.array(slide(play)).tobytes()


def test_a_stop_and_a_robot_more_leave_friction_as_it_should_be(play: Player) -> None:
    playing = play.scene(SLIDING)
    world = playing.session.services.world
    material = world.stage.find(RUBBER)
    playing.set("Write", "value", 0.0)
    playing.tick(2)
    assert world.friction(material) == (0.7, 0.0)
    playing.session.spawn("other", RobotUse(use="block.yaml", position=(0.0, 5.0, 0.0535)))
    assert world.friction(world.stage.find("/other/Materials/Rubber")) == (0.7, 0.6)
    start = speed_on_slope(playing)
    playing.tick(30)
    expected = 9.81 * (math.sin(math.radians(20)) - 0.2 * math.cos(math.radians(20)))
    assert (speed_on_slope(playing) - start) / 0.5 == pytest.approx(expected, rel=0.02)
    playing.session.stop()
    assert world.friction(material) == (0.7, 0.6)
    playing.set("Write", "value", 0.6)
    playing.session.play()
    playing.tick(30)
    assert speed_on_slope(playing) < 1e-3


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, "slippery"])
@pytest.mark.parametrize("name", ["physics:staticFriction", "physics:dynamicFriction"])
def test_a_friction_of_no_sense_is_refused(name: str, value: Any) -> None:
    context = RecordingContext()
    material = context.world.stage.add(RUBBER, "material", facts=dict(MATERIAL))
    node = ready(WritePrimAttribute, context, prim=RUBBER, name=name)
    node.value = value
    with pytest.raises(ContextError, match=f"{name} of {RUBBER}"):
        node.compute()
    assert context.world.friction(material) == (0.7, 0.6)


def test_the_friction_of_a_link_that_is_the_world_cannot_be_changed(play: Player) -> None:
    files = {
        "block.urdf": BLOCK.replace("base_link", "world"),
        "block.yaml": SLIDING["block.yaml"].replace("base_link", "world").replace("urdf:", "base_link: world\nurdf:"),
    }
    with pytest.raises(CheckError, match=f"physics:dynamicFriction of {RUBBER} cannot be changed"):
        play.scene(SLIDING | files)


def test_each_of_the_two_frictions_is_written_alone() -> None:
    context = RecordingContext()
    material = context.world.stage.add(RUBBER, "material", facts=dict(MATERIAL))
    ready(WritePrimAttribute, context, prim=RUBBER, name="physics:staticFriction", value=1).compute()
    assert context.world.friction(material) == (1.0, 0.6)
    ready(WritePrimAttribute, context, prim=RUBBER, name="physics:dynamicFriction", value=0).compute()
    assert context.world.friction(material) == (1.0, 0.0)


LIT = """
<mujoco>
  <worldbody>
    <light name="sun" diffuse="0.5 0.5 0.5"/>
    <body name="box" pos="0 3 1"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/></body>
  </worldbody>
</mujoco>
"""
LIGHTS = """
  Dim: {type: WritePrimAttribute, inputs: {prim: /World/sun, name: 'inputs:intensity', value: 0.25}}
  Tint: {type: WritePrimAttribute, inputs: {prim: /World/sun, name: 'inputs:color', value: [1, 0.5, 0]}}
  Intensity: {type: ReadPrimAttribute, inputs: {prim: /World/sun, name: 'inputs:intensity'}}
  Colour: {type: ReadPrimAttribute, inputs: {prim: /World/sun, name: 'inputs:color'}}
  Text: ToString
  ColourText: ToString
  Print: PrintText
  PrintColour: PrintText
"""
LIGHT_WIRES = """
  - Tick.tick -> Dim.execIn
  - Dim.execOut -> Tint.execIn
  - Tint.execOut -> Print.execIn
  - Print.execOut -> PrintColour.execIn
  - Intensity.value -> Text.value
  - Text.converted -> Print.text
  - Colour.value -> ColourText.value
  - ColourText.converted -> PrintColour.text
"""


def test_a_light_is_read_and_written_until_a_stop(play: Player) -> None:
    playing = arm(play, LIGHTS, LIGHT_WIRES, LIT)
    world = playing.session.services.world
    light = world.stage.find("/World/sun")
    assert world.light(light) == (1.0, (0.5, 0.5, 0.5))
    playing.tick()
    assert (playing.node("Print").text, playing.node("PrintColour").text) == ("0.25", "[1, 0.5, 0]")
    assert world.light(light) == (0.25, (1.0, 0.5, 0.0))
    playing.session.stop()
    assert world.light(light) == (1.0, (0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("inputs:intensity", value) for value in (-1.0, math.nan, math.inf, 1e30, "up")),
        *(("inputs:color", value) for value in ((0.0, -0.1, 0.0), (0.0, 0.0, math.nan), (1e30, 0.0, 0.0), (1.0, 1.0))),
    ],
)
def test_a_light_of_no_sense_is_refused(name: str, value: Any) -> None:
    context = RecordingContext()
    light = context.world.stage.add("/World/sun", "light", facts={"diffuse": (0.5, 0.5, 0.5)})
    node = ready(WritePrimAttribute, context, prim="/World/sun", name=name)
    node.value = value
    with pytest.raises(ContextError, match=f"{name} of /World/sun"):
        node.compute()
    assert context.world.light(light) == (1.0, (0.5, 0.5, 0.5))
