"""SurfaceGripper and IsaacGripperController, by the rules of Isaac Sim's nodes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.dry_world import ArticulationStub
from graphengine.devices.surface_gripper import GripperStatus, SurfaceGripperStub
from graphengine.format.errors import BadValueError, PrimError
from graphengine.nodes.grippers import IsaacGripperController, SurfaceGripper
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, Playing, ready
from tests.nodes.scenes import body

# SurfaceGripper

CUP = "/robot/Cup"


def cup(context: RecordingContext) -> SurfaceGripperStub:
    context.world.add_robot("/robot")
    return context.world.add_device(SurfaceGripperStub, CUP)


def fire(node: Any, *pins: str) -> None:
    for pin in ("toggle", "open_in", "close_in", "exec_in", "stop"):
        if hasattr(type(node), pin):
            setattr(node, pin, int(pin in pins))
    node.compute()


@pytest.mark.parametrize(
    ("pins", "was_open", "was_closed"),
    [
        (["close_in"], "Closed", "Closed"),
        (["open_in"], "Open", "Open"),
        (["toggle"], "Closed", "Open"),
        (["open_in", "toggle"], "Open", "Open"),
        (["close_in", "toggle"], "Closed", "Closed"),
        (["close_in", "open_in", "toggle"], "Closed", "Closed"),
    ],
)
def test_close_takes_precedence_over_open_and_open_over_toggle(
    context: RecordingContext, pins: list[str], was_open: GripperStatus, was_closed: GripperStatus
) -> None:
    gripper = cup(context)
    node = ready(SurfaceGripper, context, surface_gripper=CUP)
    states: list[tuple[GripperStatus, GripperStatus]] = [("Open", was_open), ("Closed", was_closed)]
    for before, after in states:
        gripper.status = before
        fire(node, *pins)
        assert gripper.status == after


def test_a_toggle_opens_a_gripper_that_is_closing(context: RecordingContext) -> None:
    gripper = cup(context)
    node = ready(SurfaceGripper, context, surface_gripper=CUP)
    gripper.status = "Closing"
    fire(node, "toggle")
    assert str(gripper.status) == "Open"


def test_a_disabled_gripper_node_does_nothing(context: RecordingContext) -> None:
    gripper = cup(context)
    node = ready(SurfaceGripper, context, surface_gripper=CUP, enabled=False)
    fire(node, "close_in")
    assert gripper.status == "Open"


def test_a_prim_that_is_not_a_gripper_is_refused(context: RecordingContext) -> None:
    cup(context)
    with pytest.raises(PrimError, match="'/robot' is a robot, not a surface gripper\nbelow it: /robot/Cup"):
        ready(SurfaceGripper, context, surface_gripper="/robot")


GANTRY = f"""<robot name="gantry"><link name="base_link"/>
  <link name="hand">{body(1.0, 0.01, '<box size="0.04 0.04 0.04"/>')}</link>
  <joint name="lift" type="prismatic"><parent link="base_link"/><child link="hand"/><origin xyz="0 0 .13"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1000" velocity="1"/></joint></robot>"""
HOIST = {
    "robot.urdf": GANTRY,
    "robot.yaml": """
        robot: robot
        urdf: robot.urdf
        fixed_base: true
        joints: {lift: {drive: {stiffness: 20000.0, damping: 600.0, max_velocity: 0.2, max_acceleration: 2.0}}}
        sensors:
          cup: {type: surface_gripper, parent: hand, position: [0.0, 0.0, -0.02], orientation: {rpy_deg: [0.0, 90.0, 0.0]}}
        """,
    "world.xml": """
        <mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/>
        <body name="box" pos="0 0 .05"><freejoint/><geom type="box" size=".05 .05 .05" mass="1"/></body></worldbody></mujoco>
        """,
    "scene.yaml": """
        scene: case
        world: world.xml
        physics: {tick_rate: 60, substeps: 4}
        robots: {robot: {use: robot.yaml}}
        graphs: {graph: {use: graph.yaml, at: /World/graph}}
        """,
    "graph.yaml": """
        graph: graph
        nodes:
          Close: {type: OnImpulseEvent}
          Open: {type: OnImpulseEvent}
          Tick: OnPlaybackTick
          Cup: {type: SurfaceGripper, inputs: {SurfaceGripper: /robot/hand/cup}}
          Status: {type: ReadPrimAttribute, inputs: {prim: /robot/hand/cup, name: "isaac:status"}}
          Print: {type: PrintText, inputs: {toScreen: false}}
          Text: ToString
          Lift: {type: ArticulationController, inputs: {targetPrim: /robot, jointNames: [lift], positionCommand: [-0.009]}}
        connections:
          - Close.execOut -> Cup.Close
          - Open.execOut -> Cup.Open
          - Tick.tick -> Lift.execIn
          - Tick.tick -> Print.execIn
          - Status.value -> Text.value
          - Text.converted -> Print.text
        """,
}


def height(playing: Playing) -> float:
    return playing.session.services.world.entities.state("box").position[2]


def test_a_box_is_picked_up_and_dropped_when_it_is_pulled_off(play: Player) -> None:
    """The cup that ships holds 42 N: the box of 1 kg and 25 N, not the box and 40 N."""
    playing = play.scene(HOIST).tick(60)
    playing.command("impulse", node="/World/graph/Close")
    playing.tick(2)
    assert playing.node("Status").value == "Closed"
    playing.set("Lift", "position_command", np.array([0.3]))
    playing.tick(180)
    assert height(playing) > 0.3
    saved = playing.session.checkpoint()
    heights = []
    for pull in (25.0, 40.0):
        playing.session.services.world.entities.push("box", (0.0, 0.0, -pull), 0.5)
        playing.tick(90)
        heights.append(height(playing))
    assert heights[0] > 0.3
    assert heights[1] == pytest.approx(0.05, abs=1e-3)
    assert playing.node("Status").value == "Open"
    playing.session.restore(saved)
    assert height(playing) > 0.3
    playing.tick()
    assert playing.node("Status").value == "Closed"
    playing.command("impulse", node="/World/graph/Open")
    playing.tick(90)
    assert height(playing) == pytest.approx(0.05, abs=1e-3)


# IsaacGripperController

FINGERS = {"articulation_root_prim": "/hand", "joint_names_in": ["left", "right"]}


def hand(context: RecordingContext | RecordingWorld, positions: list[float]) -> ArticulationStub:
    """Two fingers besides a wrist; the upper limit of both is 0.04 m, the lower one 0 m."""
    world = context.world if isinstance(context, RecordingContext) else context
    ranges = ((-math.inf, math.inf), (0.0, 0.04), (0.0, 0.04))
    stub = world.add_robot("/hand", ["wrist", "left", "right"], ranges=ranges)
    stub.state["position"] = [9.0, *positions]
    return stub


def controller(context: RecordingContext, speed: float = 0.015, **inputs: Any) -> IsaacGripperController:
    return ready(IsaacGripperController, context, **FINGERS, gripper_speed=[speed], **inputs)


def positions(node: IsaacGripperController) -> list[list[float]]:
    """Commands of the next executions by `execIn`, up to the first that repeats the one before."""
    found: list[list[float]] = []
    while len(found) < 2 or found[-1] != found[-2]:
        fire(node, "exec_in")
        found.append(node.position_commands.tolist())
    return found[:-1]


def near(*rows: list[float]) -> list[Any]:
    return [pytest.approx(row) for row in rows]


def test_the_first_execution_holds_the_fingers(context: RecordingContext) -> None:
    hand(context, [0.01, 0.02])
    node = controller(context)
    fire(node, "exec_in")
    assert node.position_commands.tolist() == [0.01, 0.02]
    assert node.joint_names_out == ("left", "right")


def test_fingers_open_and_close_between_their_limits_by_their_speed_per_execution(context: RecordingContext) -> None:
    hand(context, [0.0, 0.02])
    node = controller(context)
    fire(node, "open_in")
    assert node.position_commands.tolist() == pytest.approx([0.015, 0.035])
    assert positions(node) == near([0.03, 0.04], [0.04, 0.04])
    fire(node, "close_in")
    assert node.position_commands.tolist() == pytest.approx([0.025, 0.025])
    assert positions(node) == near([0.01, 0.01], [0.0, 0.0])


def test_given_positions_are_one_for_all_joints_or_one_per_joint(context: RecordingContext) -> None:
    hand(context, [0.0, 0.0])
    node = controller(context, open_position=[0.02], close_position=[0.01, 0.005])
    fire(node, "open_in")
    assert positions(node)[-1] == [0.02, 0.02]
    fire(node, "close_in")
    assert positions(node)[-1] == [0.01, 0.005]


def test_a_gripper_whose_joints_open_downwards_opens_downwards(context: RecordingContext) -> None:
    hand(context, [0.03, 0.03])
    node = controller(context, open_position=[0.0, 0.01], close_position=[0.04])
    fire(node, "open_in")
    assert positions(node) == near([0.0, 0.01])


def test_stop_commands_the_measured_positions(context: RecordingContext) -> None:
    stub = hand(context, [0.0, 0.0])
    node = controller(context)
    fire(node, "open_in")
    stub.state["position"] = [9.0, 0.007, 0.008]
    fire(node, "stop", "open_in")
    assert positions(node) == [[0.007, 0.008]]


def test_after_a_session_stops_the_gripper_stands_still(context: RecordingContext) -> None:
    hand(context, [0.0, 0.0])
    node = controller(context)
    fire(node, "open_in")
    context.stop(node)
    assert positions(node) == [[0.0, 0.0]]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"gripper_speed": [0.0]}, "gripperSpeed must be greater than 0"),
        ({"gripper_speed": [0.1, 0.1, 0.1]}, "gripperSpeed must be one finite number, or one for each of 2 joints"),
        ({"open_position": [math.nan]}, "openPosition must be one finite number"),
        (
            {"joint_names_in": ["left", "thumb"]},
            "jointNames must be names of joints of the robot, .* has no joint 'thumb'",
        ),
        (
            {"joint_names_in": ["wrist"]},
            r"openPosition, closePosition must be positions that are not all 0 \(not all of wrist have limits to use instead\)",
        ),
        ({"joint_names_in": []}, "jointNames must be the names of the fingers' joints"),
    ],
)
def test_the_error_of_an_unusable_value_names_the_input(
    context: RecordingContext, inputs: dict[str, Any], message: str
) -> None:
    hand(context, [0.0, 0.0])
    node = ready(IsaacGripperController, context, **{**FINGERS, "gripper_speed": [0.01], **inputs})
    with pytest.raises(BadValueError, match=message):
        fire(node, "open_in")
    assert node.commanded == ()


GRAPH = """
nodes:
  Tick: OnPlaybackTick
  Open: OnImpulseEvent
  Hand:
    type: GripperController
    inputs: {articulationRootPrim: /hand, jointNames: [left, right], gripperSpeed: [0.015]}
MORE
connections: [Tick.tick -> Hand.execIn, Open.execOut -> Hand.openWIRES]
"""
OTHER = "  Arm: {type: ArticulationController, inputs: {targetPrim: /hand, jointNames: [left, right]}}\n"


@pytest.mark.parametrize("is_wired", [False, True])
def test_the_node_commands_the_joints_unless_position_commands_is_wired(play: Player, is_wired: bool) -> None:
    world = RecordingWorld()
    stub = hand(world, [0.0, 0.0])
    wires = ", Hand.positionCommands -> Arm.positionCommand" if is_wired else ""
    playing = play.graph(GRAPH.replace("MORE", OTHER if is_wired else "").replace("WIRES", wires), world).tick()
    playing.command("impulse", node="/World/graph/Open")
    playing.tick(2)
    expected = [math.nan] * 3 if is_wired else [math.nan, 0.03, 0.03]
    assert stub.targets["position"] == pytest.approx(expected, nan_ok=True)
    assert playing.node("Hand").position_commands.tolist() == pytest.approx([0.03, 0.03])


def finger(side: str, way: int) -> str:
    return f"""<link name="{side}">{body(0.1, 0.001, '<box size="0.02 0.02 0.1"/>', f"0 {0.01 * way} 0")}</link>
      <joint name="{side}" type="prismatic"><parent link="base_link"/><child link="{side}"/><axis xyz="0 {way} 0"/>
      <limit lower="0" upper="0.04" effort="20" velocity="1"/></joint>"""


def test_fingers_of_a_robot_open_and_close_on_a_box(play: Player) -> None:
    block = body(1.0, 0.1, '<box size="0.1 0.2 0.1"/>', "0 0 .1")
    palm = f'<link name="base_link">{block}</link>'
    playing = play.scene(
        {
            **HOIST,
            "robot.urdf": f'<robot name="hand">{palm}{finger("left", 1)}{finger("right", -1)}</robot>',
            "robot.yaml": """
                robot: robot
                urdf: robot.urdf
                fixed_base: true
                joints:
                  left: {drive: {stiffness: 500.0, damping: 20.0}, start: 0.03}
                  right: {drive: {stiffness: 500.0, damping: 20.0}, start: 0.03}
                """,
            "world.xml": """
                <mujoco><worldbody><geom type="plane" size="0 0 1"/>
                <body name="box" pos="0 0 .45"><freejoint/><geom type="box" size=".01 .02 .03" mass=".05"/></body>
                <body pos="0 0 .41"><geom type="box" size=".01 .01 .01"/></body></worldbody></mujoco>
                """,
            "scene.yaml": HOIST["scene.yaml"].replace("use: robot.yaml", "use: robot.yaml, position: [0, 0, 0.5]"),
            "graph.yaml": """
                graph: graph
                nodes:
                  Tick: OnPlaybackTick
                  Open: OnImpulseEvent
                  Close: OnImpulseEvent
                  Hand:
                    type: GripperController
                    inputs: {articulationRootPrim: /robot, jointNames: [left, right], gripperSpeed: [0.001]}
                connections: [Tick.tick -> Hand.execIn, Open.execOut -> Hand.open, Close.execOut -> Hand.close]
                """,
        }
    )
    playing.command("impulse", node="/World/graph/Open")
    playing.tick(60)
    joints = playing.session.services.world.articulation(playing.session.services.world.stage.find("/robot"))
    assert joints.positions().tolist() == pytest.approx([0.04, 0.04], abs=1e-3)
    playing.command("impulse", node="/World/graph/Close")
    playing.tick(60)
    assert joints.positions().tolist() == pytest.approx([0.02, 0.02], abs=2e-3)  # the width of the box
    assert (joints.efforts() < -5.0).all()
