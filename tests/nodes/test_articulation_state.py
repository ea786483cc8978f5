"""IsaacArticulationState, IsaacReadJointState and IsaacJointNameResolver."""

from __future__ import annotations

import numpy as np
import pytest

from graphengine.devices.dry_world import ArticulationStub
from graphengine.format.errors import PrimError
from graphengine.nodes.core.articulation import IsaacArticulationState, IsaacJointNameResolver
from graphengine.nodes.physics_sensors import IsaacReadJointState
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes import scenes
from tests.nodes.harness import Player, computed, ready

JOINTS = ("shoulder", "elbow", "finger")
G = 9.81


@pytest.fixture
def context() -> RecordingContext:
    made = RecordingContext()
    robot = made.world.add_robot("/arm", JOINTS, prismatic=(False, False, True))
    robot.state.update(position=[1.0, 2.0, 3.0], velocity=[0.1, 0.2, 0.3], effort=[10.0, 20.0, 30.0])
    return made


# IsaacArticulationState


def test_the_state_of_all_joints_is_in_the_articulations_order(context: RecordingContext) -> None:
    node = computed(IsaacArticulationState, context, target_prim="/arm")
    assert node.joint_names_out == JOINTS
    assert node.joint_positions.tolist() == [1.0, 2.0, 3.0]
    assert node.joint_velocities.tolist() == [0.1, 0.2, 0.3]
    assert node.measured_joint_efforts.tolist() == [10.0, 20.0, 30.0]
    assert node.measured_joint_forces.shape == node.measured_joint_torques.shape == (3, 3)


def test_the_state_of_selected_joints_is_in_the_order_of_the_selection(
    context: RecordingContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrenches = np.arange(9.0).reshape(3, 3), np.arange(9.0, 18.0).reshape(3, 3)
    monkeypatch.setattr(ArticulationStub, "wrenches", lambda _: wrenches)
    node = computed(IsaacArticulationState, context, robot_path="/arm", joint_names=["finger", "shoulder"])
    assert node.joint_names_out == ("finger", "shoulder")
    assert node.joint_positions.tolist() == [3.0, 1.0]
    assert node.measured_joint_efforts.tolist() == [30.0, 10.0]
    assert node.measured_joint_forces.tolist() == [[6.0, 7.0, 8.0], [0.0, 1.0, 2.0]]
    assert node.measured_joint_torques.tolist() == [[15.0, 16.0, 17.0], [9.0, 10.0, 11.0]]


def test_in_a_simulation_the_joints_of_an_arm_measure_their_load(play: Player) -> None:
    # Two links of 0.5 kg on joints about the vertical, 0.1 m apart; the centre of mass of each is 0.1 m beyond its joint.
    files = scenes.arm(["one", "two"], stiffness=100.0, damping=10.0)
    files["graph.yaml"] = """
        graph: graph
        nodes:
          Tick: OnPlaybackTick
          State: {type: ArticulationState, inputs: {targetPrim: /robot}}
          Wrenches:
            type: PublishTransformTree
            inputs: {parentFrames: [a, b], childFrames: [c, d], orientations: [[0, 0, 0, 1], [0, 0, 0, 1]]}
        connections:
          - Tick.tick -> State.execIn
          - Tick.tick -> Wrenches.execIn
          - State.measuredJointForces -> Wrenches.translations
        """
    playing = play.scene(files).tick(60)
    node = playing.node("State")
    np.testing.assert_allclose(node.measured_joint_forces, [[0, 0, G], [0, 0, G / 2]], atol=0.01)
    np.testing.assert_allclose(
        node.measured_joint_torques, [[0, -G / 2 * (0.1 + 0.2), 0], [0, -G / 2 * 0.1, 0]], atol=0.01
    )
    np.testing.assert_allclose(node.measured_joint_efforts, [0.0, 0.0], atol=0.01)


def test_unwired_forces_and_torques_are_not_computed(play: Player, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(ArticulationStub, "wrenches")
    world = RecordingWorld()
    world.add_robot("/arm", JOINTS)
    text = "nodes: {Tick: OnPlaybackTick, State: {type: ArticulationState, inputs: {targetPrim: /arm}}"
    playing = play.graph(text + "}\nconnections: [Tick.tick -> State.execIn]", world).tick()
    assert playing.node("State").joint_positions.tolist() == [0.0, 0.0, 0.0]
    assert playing.node("State").measured_joint_forces.tolist() == []


# IsaacReadJointState


def test_joint_states_are_those_of_the_tick_with_its_time(context: RecordingContext) -> None:
    node = ready(IsaacReadJointState, context, prim="/arm")
    assert (node.stage_meters_per_unit, node.joint_names) == (0.0, ())
    context.tick(30)
    node.compute()
    assert (node.sensor_time, node.joint_names, node.stage_meters_per_unit) == (0.5, JOINTS, 1.0)
    assert node.joint_positions.tolist() == [1.0, 2.0, 3.0]
    assert node.joint_velocities.tolist() == [0.1, 0.2, 0.3]
    assert node.joint_efforts.tolist() == [10.0, 20.0, 30.0]
    assert node.joint_dof_types.tolist() == [0, 0, 1]
    assert node.joint_dof_types.dtype == np.uint8


def test_joint_states_have_the_names_of_the_robot_description(context: RecordingContext) -> None:
    context.world.stage.add("/arm/Physics/elbow", "joint", name_override="bend", facts={"joint": "elbow"})
    node = computed(IsaacReadJointState, context, prim="/arm")
    assert node.joint_names == JOINTS


def test_joint_states_feed_the_publisher(play: Player) -> None:
    world = RecordingWorld()
    robot = world.add_robot("/arm", JOINTS, prismatic=(False, False, True))
    robot.state["position"] = [1.0, 2.0, 3.0]
    wires = ["sensorTime", "jointNames", "jointPositions", "jointVelocities", "jointEfforts", "jointDofTypes"]
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Read: {{type: ReadJointState, inputs: {{prim: /arm}}}}
          Publish: PublishJointState
        connections:
          - Tick.tick -> Read.execIn
          - Read.execOut -> Publish.execIn
          {"".join(f"- Read.{wire} -> Publish.{wire}{chr(10)}          " for wire in [*wires, "stageMetersPerUnit"])}
        """,
        world,
    ).tick(3)
    newest = playing.published("/joint_states")[-1]
    assert (newest.name, newest.position.tolist()) == (list(JOINTS), [1.0, 2.0, 3.0])
    assert newest.header.stamp.nanosec == 50_000_000


def test_a_prim_that_does_not_identify_a_robot_is_refused(context: RecordingContext) -> None:
    context.world.stage.add("/table", "body")
    with pytest.raises(PrimError, match="is not the root prim, base link or articulation root of a robot"):
        ready(IsaacReadJointState, context, prim="/table")


# IsaacJointNameResolver


@pytest.fixture
def renamed(context: RecordingContext) -> RecordingContext:
    for joint, override in (("shoulder", "j1"), ("elbow", ""), ("finger", "j3")):
        context.world.stage.add(f"/arm/Physics/{joint}", "joint", name_override=override, facts={"joint": joint})
    return context


def test_published_names_become_names_of_the_description_and_other_names_stay(renamed: RecordingContext) -> None:
    node = computed(IsaacJointNameResolver, renamed, target_prim="/arm", joint_names=["j3", "elbow", "j1", "stranger"])
    assert node.joint_names_out == ("finger", "elbow", "shoulder", "stranger")
    assert node.robot_path_out == "/arm"


def test_literal_names_are_resolved_before_the_first_tick(renamed: RecordingContext) -> None:
    assert ready(IsaacJointNameResolver, renamed, target_prim="/arm", joint_names=["j1"]).joint_names_out == (
        "shoulder",
    )


def test_the_resolver_inverts_the_mapping_to_published_names(renamed: RecordingContext) -> None:
    node = ready(IsaacJointNameResolver, renamed, target_prim="/arm", joint_names=renamed.joint_names("/arm"))
    assert node.joint_names_out == JOINTS


def test_in_a_graph_a_controller_takes_the_resolved_names_and_path(play: Player) -> None:
    world = RecordingWorld()
    robot = world.add_robot("/arm", JOINTS)
    world.stage.add("/arm/Physics/finger", "joint", name_override="j3", facts={"joint": "finger"})
    play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Names: {type: JointNameResolver, inputs: {targetPrim: /arm, jointNames: [j3, elbow]}}
          Control: {type: ArticulationController, inputs: {velocityCommand: [3.0, 2.0]}}
        connections:
          - Tick.tick -> Names.execIn
          - Names.execOut -> Control.execIn
          - Names.jointNames -> Control.jointNames
          - Names.robotPath -> Control.robotPath
        """,
        world,
    ).tick()
    assert np.array_equal(robot.targets["velocity"], [np.nan, 2.0, 3.0], equal_nan=True)
