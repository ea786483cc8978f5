"""Parameters of robot_state_publisher for the robots of a scene: URDF, topics, namespace and frame prefix."""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.scene.loaded_scene import LoadedScene

_JOINT_STATE = "sensor_msgs/msg/JointState"


@dataclass(frozen=True, slots=True)
class RobotState:
    """Parameters of robot_state_publisher for one robot.

    Attributes:
        name: name of the robot in the scene.
        namespace: absolute namespace of the robot's topics; `/` if there is none.
        joint_states: topic of the robot's joint states; empty if its graphs publish no joint states.
        robot_description: topic for the URDF.
        tf: topic for the transforms of movable joints.
        tf_static: topic for the transforms of fixed joints.
        frame_prefix: prefix of the frame names, with a trailing slash; empty if there is none.
        published: whether the simulation publishes these topics itself, because the scene has `robot_state: true`.
        urdf: content of the URDF, with absolute paths to meshes; empty if the robot has no URDF.
    """

    name: str
    namespace: str
    joint_states: str
    robot_description: str
    tf: str
    tf_static: str
    frame_prefix: str
    published: bool
    urdf: str


def robot_states(scene: LoadedScene) -> list[RobotState]:
    """Return the parameters of each robot, in the order of the scene, which must be loaded with the option `robot_state`."""
    if scene.world is None:
        return []
    return [_robot_state(scene, name) for name in scene.world.robots]


def _robot_state(scene: LoadedScene, name: str) -> RobotState:
    assert scene.world is not None
    robot = scene.world.robots[name]
    claims = [claim for claim in scene.claims if claim.graph.startswith(f"{name}/") and claim.direction == "publish"]
    own = [claim for claim in claims if claim.graph == f"{name}/robot_state"]
    topics = {claim.topic.rpartition("/")[2]: claim.topic for claim in own}
    prefixes = (child.rpartition("/") for claim in own for _, child in claim.transforms)
    joints = [claim.topic for claim in claims if claim.message_type == _JOINT_STATE]
    return RobotState(
        name=name,
        namespace=topics["robot_description"].rpartition("/")[0] or "/",
        joint_states=joints[0] if joints else "",
        robot_description=topics["robot_description"],
        tf=topics["tf"],
        tf_static=topics["tf_static"],
        frame_prefix=next((f"{above}{slash}" for above, slash, _ in prefixes), ""),
        published=robot.placement.use.robot_state,
        urdf=str(scene.world.stage.find(robot.prim_path).facts.get("urdf", "")),
    )
