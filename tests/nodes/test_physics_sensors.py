"""IsaacReadIMU, IsaacReadContactSensor and IsaacReadEffortSensor."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.contact import ContactReading, ContactSensorStub
from graphengine.devices.imu import ImuSample, ImuStub
from graphengine.format.errors import PrimError
from graphengine.nodes.physics_sensors import IsaacReadContactSensor, IsaacReadEffortSensor, IsaacReadIMU
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, ready, write
from tests.nodes.scenes import CUBE, body, scene

G = 9.81
HALF = math.sqrt(0.5)


# IsaacReadIMU


def measured(index: int) -> ImuSample:
    return ImuSample(0.5, index, (1.0, 2.0, 3.0), (0.0, 0.0, G), (4.0, 5.0, 6.0), (0.0, 0.0, HALF, HALF))


def unit(context: RecordingContext) -> ImuStub:
    context.world.add_robot("/robot")
    return context.world.add_device(ImuStub, "/robot/Imu")


@pytest.mark.parametrize(("read_gravity", "upwards"), [(True, 3.0 + G), (False, 3.0)])
def test_an_imu_sample_is_output_with_or_without_gravity(read_gravity: bool, upwards: float) -> None:
    context = RecordingContext()
    unit(context).measured = measured(0)
    node = ready(IsaacReadIMU, context, imu_prim="/robot/Imu", read_gravity=read_gravity)
    assert node.compute() == node.exec_out
    assert node.lin_acc == (1.0, 2.0, upwards)
    assert node.ang_vel == (4.0, 5.0, 6.0)
    assert node.orientation == (0.0, 0.0, HALF, HALF)
    assert node.sensor_time == 0.5


def test_each_sample_fires_once_and_missed_samples_are_skipped(context: RecordingContext) -> None:
    imu = unit(context)
    node = ready(IsaacReadIMU, context, imu_prim="/robot/Imu")
    fired = []
    for index in (0, 0, 1, 1, 4, 4):
        imu.measured = measured(index)
        fired.append(node.compute() == node.exec_out)
    assert fired == [True, False, True, False, True, False]


def test_before_the_first_sample_of_an_imu_nothing_fires(context: RecordingContext) -> None:
    unit(context).measured = measured(-1)
    node = ready(IsaacReadIMU, context, imu_prim="/robot/Imu")
    assert node.compute() is None
    assert node.sensor_time == 0.0


def test_after_a_stop_sample_0_fires_again(context: RecordingContext) -> None:
    unit(context)
    node = computed(IsaacReadIMU, context, imu_prim="/robot/Imu")
    context.stop(node)
    assert (node.lin_acc, node.orientation) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert node.compute() == node.exec_out


def test_the_error_of_a_prim_that_is_not_an_imu_lists_the_imus_below(context: RecordingContext) -> None:
    unit(context)
    with pytest.raises(PrimError, match="is a robot, not an imu\nbelow it: /robot/Imu"):
        ready(IsaacReadIMU, context, imu_prim="/robot")


def sensing(nodes: str, sensor: dict[str, str], runs: str = "tick") -> dict[str, str]:
    """A box of 2 kg on the floor, with a sensor, and a graph."""
    urdf = f'<robot name="box"><link name="base_link">{body(2.0, 0.1, CUBE)}</link></robot>'
    sensors = {"sensors": {"sensor": {"parent": "base_link", **sensor}}}
    return scene(urdf, sensors, f"graph: graph\nruns: {runs}\n{nodes}", (0.0, 0.0, 0.1))


@pytest.mark.parametrize(
    ("runs", "event", "rate", "samples"),
    [
        ("tick", "OnPlaybackTick", 20, 21),
        ("tick", "OnPlaybackTick", 200, 60),
        ("physics_step", "OnPhysicsStep", 200, 201),
    ],
)
def test_in_a_simulation_samples_arrive_at_the_imus_rate_up_to_the_rate_of_the_graph(
    play: Player, runs: str, event: str, rate: int, samples: int
) -> None:
    # In the first second, its end included, falls sample 0 and one for each 1 / rate.
    graph = f"""
nodes: {{Event: {event}, Imu: {{type: ReadIMU, inputs: {{imuPrim: /robot/base_link/sensor}}}}, Out: PublishImu}}
connections:
  - Event.{"tick" if runs == "tick" else "step"} -> Imu.execIn
  - Imu.execOut -> Out.execIn
  - Imu.linAcc -> Out.linearAcceleration
  - Imu.sensorTime -> Out.timeStamp
"""
    write(play.folder, {"sensors/own.yaml": f"{{format: 1, sensor: own, imu: {{rate: {rate}.0}}}}"})
    playing = play.scene(sensing(graph, {"type": "imu", "profile": "own"}, runs)).tick(60)
    sent = playing.published("/imu")
    assert len(sent) == samples
    assert sent[-1].linear_acceleration.z == pytest.approx(G, abs=0.02)
    stamps = [message.header.stamp.sec + message.header.stamp.nanosec / 1e9 for message in sent]
    assert stamps == sorted(set(stamps))
    assert stamps[-1] == 1.0


# IsaacReadContactSensor


def test_a_contact_reading_is_output_at_every_execution(context: RecordingContext) -> None:
    context.world.add_robot("/robot")
    sensor = context.world.add_device(ContactSensorStub, "/robot/Bumper")
    node = computed(IsaacReadContactSensor, context, cs_prim="/robot/Bumper")
    assert (node.in_contact, node.value) == (False, 0.0)
    sensor.felt = ContactReading(0.25, True, 12.5)
    node.compute()
    assert (node.sensor_time, node.in_contact, node.value) == (0.25, True, 12.5)
    context.stop(node)
    assert (node.sensor_time, node.in_contact, node.value) == (0.0, False, 0.0)


def test_a_prim_that_is_not_a_contact_sensor_is_refused(context: RecordingContext) -> None:
    unit(context)
    with pytest.raises(PrimError, match="is an imu, not a contact sensor\nprims of this kind: none"):
        ready(IsaacReadContactSensor, context, cs_prim="/robot/Imu")


def test_in_a_simulation_a_box_on_the_floor_feels_its_weight(play: Player) -> None:
    nodes = """
nodes: {Tick: OnPlaybackTick, Bumper: {type: ReadContactSensor, inputs: {csPrim: /robot/base_link/sensor}}}
connections: [Tick.tick -> Bumper.execIn]
"""
    playing = play.scene(sensing(nodes, {"type": "contact"})).tick(60)
    node = playing.node("Bumper")
    assert node.in_contact
    assert node.value == pytest.approx(2 * G, rel=1e-3)
    assert node.sensor_time == 1.0


# IsaacReadEffortSensor


def test_the_effort_is_that_of_the_given_joint(context: RecordingContext) -> None:
    stub = context.world.add_robot("/robot", ["left", "right"])
    context.world.stage.add("/robot/Physics/right", "joint", facts={"joint": "right"})
    stub.state["effort"] = [1.0, -19.5]
    node = computed(
        IsaacReadEffortSensor, context, prim="/robot/Physics/right", enabled=False
    )  # deprecated, and ignored
    assert (node.value, node.sensor_time) == (-19.5, context.clock.time)
    context.stop(node)
    assert (node.value, node.sensor_time) == (0.0, 0.0)


def test_a_fixed_joint_is_refused(context: RecordingContext) -> None:
    context.world.add_robot("/robot", ["left"])
    context.world.stage.add("/robot/Physics/mount", "joint", facts={"joint": "mount"})
    with pytest.raises(PrimError, match="is not a movable joint\nmovable joints: left"):
        ready(IsaacReadEffortSensor, context, prim="/robot/Physics/mount")


@pytest.mark.parametrize(("load", "torque"), [(0.0, 2.0), (1.0, 3.5)])
def test_in_a_simulation_an_arm_holds_its_load(play: Player, load: float, torque: float) -> None:
    """Isaac Sim's test: an arm of 2 kg, whose centre of mass is 1 m from its joint, and a cube of 1 kg at 1.5 m."""
    links = f'<link name="base_link">{body(50.0, 5.0, CUBE, collides=False)}</link><link name="arm">'
    links += f"{body(2.0, 0.1, CUBE, '1 0 0', collides=False)}</link>"
    joint = '<joint name="shoulder" type="revolute"><parent link="base_link"/><child link="arm"/><axis xyz="0 1 0"/>'
    joint += '<limit lower="-1" upper="1" effort="500" velocity="9"/></joint>'
    if load:
        links += f'<link name="cube">{body(load, 0.001, CUBE, collides=False)}</link>'
        joint += (
            '<joint name="grip" type="fixed"><parent link="arm"/><child link="cube"/><origin xyz="1.5 0 0"/></joint>'
        )
    graph = """
graph: graph
nodes: {Tick: OnPlaybackTick, Effort: {type: ReadEffortSensor, inputs: {prim: /robot/Physics/shoulder}}}
connections: [Tick.tick -> Effort.execIn]
"""
    robot = {"fixed_base": True, "joints": {"shoulder": {"drive": {"stiffness": 1e5, "damping": 1e4}}}}
    playing = play.scene(scene(f'<robot name="arm">{links}{joint}</robot>', robot, graph, (0.0, 0.0, 2.0))).tick(60)
    node = playing.node("Effort")
    assert node.value == pytest.approx(-torque * G, abs=0.05)  # as in that test: positive turns the arm down
    assert node.sensor_time == pytest.approx(1.0)
