"""Finds the properties of a robot that Nav2's configuration needs: topics, frames, footprint, lidars and motion limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass

import numpy as np

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.bringup.calibration.robot_interface import ACKERMANN, COMMAND_TYPES, ODOMETRY, TWIST, claims_of
from graphengine.bringup.nav2.motion_limits import MotionLimits, motion_limits
from graphengine.bringup.nav2.scan_source import ScanSource, scan_sources
from graphengine.descriptions.engine import Floats
from graphengine.devices.rotation import yaw_of
from graphengine.devices.stage import Prim, Stage
from graphengine.format.errors import UsageError
from graphengine.format.prim_paths import at_or_below
from graphengine.format.wording import listing
from graphengine.messages.endpoints import EndpointClaim
from graphengine.physics.model.footprint import Point, circle_radius, collider_points, convex_hull, radii, simplified
from graphengine.physics.model.robot import RobotInstance

TRANSFORMS = "tf2_msgs/msg/TFMessage"
_ODOMETRY_NODE = "isaacsim.ros2.bridge.ROS2PublishOdometry"
_LIDAR_WORDS = ("scan", "laser", "lidar")
"""Words in the names of links that are suggested as mounts of a lidar."""


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """Properties of a robot for the configuration of Nav2.

    Attributes:
        name: name of the robot in the scene.
        namespace: namespace of the robot's topics, without slashes at the ends; can be empty.
        command_topic: topic on which the robot receives velocity commands.
        stamped: whether the type of the command topic is TwistStamped; otherwise it is Twist.
        odometry_topic: topic of the odometry.
        odometry_frame: parent frame of the odometry (`odom`).
        base_frame: frame of the robot's base, a child of the odometry frame in TF.
        tf_topic: topic of the transforms.
        tf_static_topic: topic of the static transforms.
        scans: LaserScan topics; the topic with the widest field of view comes first.
        pose: x, y (m) and yaw (rad) of the base frame in the world at time 0.
        footprint: corners (x, y) of the robot's outline in the base frame, m.
        radius: radius of the outline if it is a circle about the base frame's origin, m; None for any other outline.
        floor: z of the robot's lowest point in the world, m, where the floor is assumed.
        height: height of the robot's highest point above the floor, m.
        limits: motion limits of the robot.
    """

    name: str
    namespace: str
    command_topic: str
    stamped: bool
    odometry_topic: str
    odometry_frame: str
    base_frame: str
    tf_topic: str
    tf_static_topic: str
    scans: tuple[ScanSource, ...]
    pose: tuple[float, float, float]
    footprint: tuple[Point, ...]
    radius: float | None
    floor: float
    height: float
    limits: MotionLimits

    @property
    def radii(self) -> tuple[float, float]:
        """Inscribed and circumscribed radius of the footprint, m."""
        return radii(self.footprint) if self.radius is None else (self.radius, self.radius)

    def topic(self, name: str) -> str:
        """Return the full name of a topic in the robot's namespace."""
        return "/".join(["", *filter(None, [self.namespace]), name])


def robot_facts(scene: Scene, robot: RobotInstance) -> RobotFacts:
    """Return the properties of a robot that Nav2's configuration needs.

    Raises:
        UsageError: Nav2 cannot drive the robot; the message lists all missing topics and transforms with remedies.
    """
    claims = _claims_of(scene, robot)
    missing: list[str] = []
    command = _command(claims, missing)
    edges = [edge for claim in claims if claim.message_type == TRANSFORMS for edge in claim.transforms]
    odometry = _odometry(scene, claims, {parent for parent, _ in edges})
    if odometry is None:
        missing.append("no nav_msgs/Odometry: publish it with ROS2PublishOdometry, as graphs/wheel_odometry.yaml does")
    base_frame = _base_frame(robot, odometry, edges)
    if odometry is not None and base_frame is None:
        frame = odometry.frame_id or "odom"
        remedy = f"publish it with ROS2PublishRawTransformTree, parentFrameId {frame}"
        missing.append(f"no transform from {frame!r} to the base: {remedy}")
    scans = scan_sources(scene, claims)
    if not scans:
        missing.append(_no_scan(robot, world_of(scene).stage, claims))
    elif base_frame is not None:
        reached = _connected(base_frame, [*edges, *_description_edges(claims, robot)])
        remedy = "publish it with ROS2PublishTransformTree, or run with --robot-state"
        lacking = [f"{scan.frame!r}, the frame of {scan.topic}" for scan in scans if scan.frame not in reached]
        missing += [f"no transform from {base_frame!r} to {frame}: {remedy}" for frame in lacking]
    if missing or command is None or odometry is None or base_frame is None:
        raise UsageError("\n  ".join([f"{robot.name}: Nav2 cannot drive this robot", *missing]))
    frame_prim = _frame_prim(scene, robot, base_frame)
    position, orientation = world_of(scene).simulation.frame(frame_prim).pose()
    yaw = yaw_of(orientation)
    points = _outline_points(scene, robot)
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    outline = convex_hull((points[:, :2] - position[:2]) @ turn)
    floor = float(points[:, 2].min())
    tf_topic, tf_static_topic = _transform_topics(claims)
    return RobotFacts(
        robot.name,
        scene.robots[robot.name].namespace.strip("/"),
        command.topic,
        command.message_type != TWIST,
        odometry.topic,
        odometry.frame_id,
        base_frame,
        tf_topic,
        tf_static_topic,
        tuple(scan.above(floor) for scan in scans),
        (position[0], position[1], yaw),
        tuple(simplified(outline)),
        circle_radius(outline),
        floor,
        float(points[:, 2].max()) - floor,
        motion_limits(scene, robot, {claim.graph for claim in claims}),
    )


def unknown_covariances(scene: Scene, robot: RobotFacts) -> Iterator[str]:
    """Yield a note if a robot's odometry has covariances of zero, which filters such as robot_localization misread."""
    claim = next(one for one in scene.topics if (one.topic, one.direction) == (robot.odometry_topic, "publish"))
    for node in _nodes_without_covariances(scene, claim):
        yield (
            f"the covariances of {claim.topic} are all zero: AMCL ignores them, but robot_localization takes the "
            "odometry for exact; publish wheel odometry with its covariances, as graphs/wheel_odometry.yaml does, or set "
            f"poseCovariance and twistCovariance of {node}"
        )


def _nodes_without_covariances(scene: Scene, claim: EndpointClaim) -> Iterator[str]:
    """Yield the name of the ROS2PublishOdometry node of an endpoint if all its covariances are zero."""
    for graph in loaded_of(scene).planned:
        for instance in graph.instances:
            if f"{graph.prim_path}/{instance.id}" != claim.node or instance.cls.type_name != _ODOMETRY_NODE:
                continue
            ports = ("pose_covariance", "twist_covariance")
            wired = any((instance.id, instance.cls.fields[port].name) in graph.wired_ports for port in ports)
            if not wired and not any(np.any(instance.value(port)) for port in ports):
                yield f"{graph.name}/{instance.id}"


def _odometry(scene: Scene, claims: Sequence[EndpointClaim], parents: Set[str]) -> EndpointClaim | None:
    """Return the odometry of a robot, preferably with a frame among the `parents` in TF, and then with covariances."""

    def rank(claim: EndpointClaim) -> tuple[bool, bool]:
        return (claim.frame_id or "odom") not in parents, any(_nodes_without_covariances(scene, claim))

    return min(claims_of(claims, "publish", ODOMETRY), key=rank, default=None)


def _claims_of(scene: Scene, robot: RobotInstance) -> list[EndpointClaim]:
    """Return the topics of a robot's nodes, or of all nodes if the scene has only one robot.

    Topics whose names have fewer parts come first.
    """
    alone = len(world_of(scene).robots) == 1
    own = [claim for claim in scene.topics if alone or at_or_below(claim.node, robot.prim_path)]
    return sorted(own, key=lambda claim: (claim.topic.count("/"), claim.topic, claim.node))


def _command(claims: Sequence[EndpointClaim], missing: list[str]) -> EndpointClaim | None:
    """Return the subscription that drives the robot; add an error text to `missing` unless exactly one topic drives it."""
    found = claims_of(claims, "subscribe", *COMMAND_TYPES)
    driven = [one for one in found if one.message_type != ACKERMANN]
    named = [one for one in driven if one.topic.rpartition("/")[2] == "cmd_vel"]
    topics = sorted({one.topic for one in named or driven})
    if len(topics) > 1:
        missing.append(f"several topics take velocities; Nav2 can use one: {listing(topics, 'topics')}")
    elif not topics and found:
        remedy = "drive the robot with ROS2SubscribeTwist, as graphs/base/ackermann.yaml does"
        missing.append(f"{found[0].topic} takes AckermannDriveStamped, and Nav2 sends Twist: {remedy}")
    elif not topics:
        remedy = "subscribe to cmd_vel with ROS2SubscribeTwist, as graphs/base/differential.yaml does"
        missing.append(f"no topic takes velocities: {remedy}")
    return next(iter(named or driven), None)


def _description_edges(claims: Sequence[EndpointClaim], robot: RobotInstance) -> Iterator[tuple[str, str]]:
    """Yield the transforms (parent, child) of the robot description if a topic publishes the description."""
    if any(claim.topic.endswith("/robot_description") for claim in claims):
        yield from ((joint.parent, joint.child) for joint in robot.description.joints.values())


def _base_frame(robot: RobotInstance, odometry: EndpointClaim | None, edges: Sequence[tuple[str, str]]) -> str | None:
    """Return a child of the odometry frame in TF, preferably the robot's base link; None without a child."""
    if odometry is None:
        return None
    children = [child for parent, child in edges if parent == odometry.frame_id]
    base = robot.spec.base_link
    return next((child for child in children if child.rpartition("/")[2] == base), next(iter(children), None))


def _connected(frame: str, edges: Sequence[tuple[str, str]]) -> set[str]:
    """Return all frames connected to a frame, including this frame, by the transforms `edges`, which are (parent, child)."""
    reached, size = {frame}, 0
    while len(reached) > size:
        size = len(reached)
        for edge in edges:
            if not reached.isdisjoint(edge):
                reached.update(edge)
    return reached


def _no_scan(robot: RobotInstance, stage: Stage, claims: Sequence[EndpointClaim]) -> str:
    """Return the error text for a robot without a LaserScan topic, with a remedy, as YAML lines if possible."""
    if clouds := claims_of(claims, "publish", "sensor_msgs/msg/PointCloud2"):
        return (
            f"no sensor_msgs/LaserScan: {clouds[0].topic} is a PointCloud2; publish a scan with ROS2RtxLidarHelper, type "
            "laser_scan, or with ROS2PublishLaserScan, or convert it with pointcloud_to_laserscan"
        )
    prims = [prim for prim in stage.find(robot.prim_path).descendants() if prim.kind == "link"]
    named = [prim for prim in prims if any(word in prim.name.lower() for word in _LIDAR_WORDS)]
    link = (named or prims)[0]
    path = link.path.removeprefix(f"{robot.prim_path}/")
    position = "" if named else ", position: [0.0, 0.0, 0.2]"
    return (
        f"no sensor_msgs/LaserScan: add a lidar to {robot.file.document().path.name}, such as\n"
        f"    sensors:\n      lidar: {{type: lidar, profile: lidar_360, parent: {link.name}{position}}}\n"
        "    graphs:\n      scan: {use: graphs/publishers/scan.yaml, parameters: "
        f"{{lidar: {path}/lidar/Lidar, topic: scan, frame: {link.name}}}}}"
    )


def _transform_topics(claims: Sequence[EndpointClaim]) -> tuple[str, str]:
    """Return the topics of the transforms and of the static transforms.

    If no graph publishes static transforms, their topic is the topic of the transforms with the suffix `_static`.
    """
    topics = [claim.topic for claim in claims if claim.message_type == TRANSFORMS]
    moving = next(topic for topic in [*topics, "/tf"] if not topic.endswith("_static"))
    return moving, next((topic for topic in topics if topic.endswith("_static")), f"{moving}_static")


def _frame_prim(scene: Scene, robot: RobotInstance, frame: str) -> Prim:
    """Return the robot's prim with this TF frame name, or the base link's prim if no prim has it."""
    prim = world_of(scene).stage.find(robot.prim_path)
    name = frame.rpartition("/")[2]
    found = [one for one in prim.descendants() if one.frame_name == name and one.carrier()[0]]
    return found[0] if found else world_of(scene).stage.find(prim.facts["base_link"])


def _outline_points(scene: Scene, robot: RobotInstance) -> Floats:
    simulation = world_of(scene).simulation
    points = collider_points(simulation.model, simulation.data, robot.name)
    if len(points) < 3:
        raise UsageError(f"{robot.name}: without colliders, the robot's footprint is unknown; add collision geometry")
    return points
