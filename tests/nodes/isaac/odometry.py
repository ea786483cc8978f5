"""Cases of IsaacComputeOdometry and ROS2PublishOdometry, and of robots that drive."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.nodes.core.odometry import IsaacComputeOdometry
from graphengine.nodes.ros2.state import ROS2PublishOdometry
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes import scenes
from tests.nodes.harness import Player, quaternion, ready, twist, vector, yaw
from tests.nodes.isaac.book import Case, at, made, runs

ODOMETRY = "isaacsim.core.nodes.IsaacComputeOdometry"
PUBLISH_ODOMETRY = "isaacsim.ros2.bridge.ROS2PublishOdometry"


def moved(position: Any = (0.0, 0.0, 0.0), orientation: Any = (0.0, 0.0, 0.0, 1.0)) -> Any:
    """A context, a body there, and a node that has seen it there."""
    context = RecordingContext()
    body = context.world.add_body("/cube", tuple(position), tuple(orientation))
    node = ready(IsaacComputeOdometry, context, chassis_prim="/cube")
    return context, body, node


def seen(context: RecordingContext, node: IsaacComputeOdometry) -> None:
    context.tick()
    node.compute()


@runs(ODOMETRY, "defaults before play")
def before_play_odometry_is_at_rest(case: Case, play: Player) -> None:
    _, _, node = moved()
    for port in IsaacComputeOdometry.fields.values():
        if port.side == "outputs" and not port.is_exec:
            kind = "orientation" if port.field == "orientation" else "vectors"
            assert list(getattr(node, port.field)) == case["expect"][kind]


@runs(ODOMETRY, "cube at rest 180 frames")
def a_cube_at_rest_has_neither_velocity_nor_acceleration(case: Case, play: Player) -> None:
    playing = play.scene(scenes.cube_on_the_floor(height=0.25)).tick(180)
    node, tolerance = playing.node("Compute"), case["tolerance"]
    for port in IsaacComputeOdometry.fields.values():
        if port.side == "outputs" and str(port.type) == "vectord[3]":
            assert np.allclose(getattr(node, port.field), 0.0, atol=tolerance), port.name


@runs(ODOMETRY, "position relative to start")
def the_first_position_is_the_origin(case: Case, play: Player) -> None:
    context, _, node = moved(map(float, case["inputs"]["start"]))
    for _ in range(case["inputs"]["frames"]):
        seen(context, node)
    assert node.position == pytest.approx(case["expect"]["position"], abs=case["tolerance"])


@runs(ODOMETRY, "body moves down 1.5 m/s for 30 frames")
def a_fall_is_a_way_down_from_the_start(case: Case, play: Player) -> None:
    x, y, z = map(float, case["inputs"]["start"])
    context, body, node = moved((x, y, z))
    for frame in range(30):
        body.position = (x, y, z - 1.5 * frame / 60)
        seen(context, node)
    assert node.position[2] < case["expect"]["position.z"]["lt"]
    assert node.position[:2] == pytest.approx((case["expect"]["position.x"], case["expect"]["position.y"]))


@runs(ODOMETRY, "body yawed +90deg moving world +x: local = (0,-1,0)")
def velocity_in_the_bodys_frame(case: Case, play: Player) -> None:
    context, body, node = moved()
    w, x, y, z = case["inputs"]["orientation_wxyz"]
    body.orientation = (x, y, z, w)
    body.linear = tuple(map(float, case["inputs"]["linear_velocity_world"]))
    body.angular = tuple(case["inputs"]["angular_velocity_world"])
    seen(context, node)
    found = {
        "linearVelocity": node.linear_velocity,
        "globalLinearVelocity": node.global_linear_velocity,
        "angularVelocity": node.angular_velocity,
    }
    for name, expected in case["expect"].items():
        assert found[name] == pytest.approx(expected, abs=case["tolerance"])


@runs(ODOMETRY, "pose in start frame: start yaw 90, world displacement +y 2 -> position (2,0,0)")
def pose_in_the_start_frame(case: Case, play: Player) -> None:
    start, now = case["inputs"]["start_pose"], case["inputs"]["current_pose"]
    context, body, node = moved(*start)
    seen(context, node)
    body.position, body.orientation = tuple(map(float, now[0])), tuple(map(float, now[1]))
    seen(context, node)
    assert node.position == pytest.approx(case["expect"]["position"], abs=case["tolerance"])
    assert node.orientation == pytest.approx(case["expect"]["orientation(xyzw)"], abs=case["tolerance"])


@runs(PUBLISH_ODOMETRY, "cube dropped 1.0 -> rest 0.25")
def a_cube_that_falls_and_comes_to_rest(case: Case, play: Player) -> None:
    playing = play.scene(scenes.cube_on_the_floor(case["inputs"]["start_z"], case["inputs"]["cube_scale"])).tick(150)
    newest = playing.published("/odom")[-1]
    assert vector(newest.pose.pose.position) == pytest.approx(
        case["expect"]["pose.position"], abs=case["tolerance"]["z"]
    )
    for part in (newest.twist.twist.linear, newest.twist.twist.angular):
        assert vector(part) == pytest.approx((case["expect"]["twist"],) * 3, abs=case["tolerance"]["twist"])


@runs(PUBLISH_ODOMETRY, "world velocity commands")
def velocities_of_the_world_stay_those_of_the_world(case: Case, play: Player) -> None:
    world = RecordingWorld()
    body = world.add_body("/cube", orientation=yaw(1.0))
    body.linear = at(case["inputs"]["lin_world"])
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Compute: {{type: ComputeOdometry, inputs: {{chassisPrim: /cube}}}}
          Publish: {{type: PublishOdometry, inputs: {{robotFront: {case["inputs"]["robotFront"]}}}}}
        connections:
          - Tick.tick -> Compute.execIn
          - Compute.execOut -> Publish.execIn
          - Compute.{case["inputs"]["connected"]} -> Publish.linearVelocity
        """,
        world,
    ).tick(2)
    newest = playing.published("/odom")[-1]
    assert vector(newest.twist.twist.linear) == pytest.approx(case["expect"]["twist.linear"], abs=case["tolerance"])


@runs(PUBLISH_ODOMETRY, "robotFront (0,1,0), raw=False", "raw=True ignores robotFront")
def the_front_turns_the_twist_unless_it_is_raw(case: Case, play: Player) -> None:
    node = made(ROS2PublishOdometry, case)
    node.setup(RecordingContext())
    message = node.message()
    assert vector(message.twist.twist.linear) == pytest.approx(case["expect"]["twist.linear"], abs=case["tolerance"])


@runs("diff drive closed loop", "carter 0.1 m/s 3 s")
def a_drive_straight_ahead(case: Case, play: Player) -> None:
    given, places = case["inputs"], 0.5 * 10.0 ** -case["tolerance"]["places"]
    # It falls 0.25 m and lands, which is a part of the pose that the case expects; then it drives.
    geometry = {"wheelRadius": scenes.CARTER_WHEEL_RADIUS, "wheelDistance": scenes.CARTER_WHEEL_DISTANCE}
    playing = play.scene(scenes.carter(given["start"], given["yaw_deg"], geometry)).tick(120)
    playing.transport.inject("/cmd_vel", twist(*map(float, given["cmd"])))
    playing.tick(given["seconds"] * 60)
    odom = playing.published("/odom")[-1].pose.pose
    (edge,) = playing.published("/tf")[-1].transforms
    found = [*vector(odom.position), *quaternion(odom.orientation)]
    assert found == pytest.approx(case["expect"]["odom"], abs=places)
    found = [*vector(edge.transform.translation), *quaternion(edge.transform.rotation)]
    assert found == pytest.approx(case["expect"]["tf"], abs=places)


@runs("diff drive closed loop", "spin 0.2 rad/s 2 s, wheelRadius 0.1 wheelDistance 0.5")
def a_turn_on_the_spot_with_wheels_of_other_sizes_than_the_robots(case: Case, play: Player) -> None:
    given, places = case["inputs"], 0.5 * 10.0 ** -case["tolerance"]["places"]
    playing = play.scene(scenes.carter((0.0, 0.0, 0.0), 0.0, {"wheelRadius": 0.1, "wheelDistance": 0.5}))
    playing.transport.inject("/cmd_vel", twist(*map(float, given["cmd"])))
    playing.tick(given["seconds"] * 60)
    orientation = playing.published("/odom")[-1].pose.pose.orientation
    assert orientation.z == pytest.approx(case["expect"]["odom.orientation.z"], abs=places)
    assert orientation.w == pytest.approx(case["expect"]["w"], abs=places)


@runs("leatherback odometry", "straight 1 m/s 2 s", "circle")
def a_car_on_a_circle_or_straight_ahead(case: Case, play: Player) -> None:
    # The car is an ideal one, put where it would be in each tick: what steers the reference's is AckermannController.
    given, expect = case["inputs"], case["expect"]
    speed, rate = given["speed"], given["speed"] * math.tan(given["steer"]) / given.get("wheelbase", 0.37)
    world = RecordingWorld()
    car = world.add_body("/car")
    playing = play.graph(scenes.odometry("/car"), world)
    ticks = given.get("seconds", 2) * 60
    for tick in range(ticks + 1):
        turned = rate * tick / 60
        radius = speed / rate if rate else 0.0
        way = (radius * math.sin(turned), radius * (1 - math.cos(turned))) if rate else (speed * tick / 60, 0.0)
        car.position, car.orientation = (*way, 0.0), yaw(turned)
        car.linear, car.angular = (speed * math.cos(turned), speed * math.sin(turned), 0.0), (0.0, 0.0, rate)
        playing.tick()
    newest = playing.published("/odom")[-1]
    assert newest.twist.twist.linear.x == pytest.approx(speed)
    if "twist.angular.z" in expect:
        assert newest.twist.twist.angular.z == pytest.approx(expect["twist.angular.z"], abs=case["tolerance"])
    else:
        assert newest.twist.twist.linear.x == pytest.approx(expect["twist.linear.x"], abs=case["tolerance"]["v"])
        away = math.hypot(*vector(newest.pose.pose.position)[:2])
        assert away == pytest.approx(expect["xy displacement"], abs=case["tolerance"]["d"])
