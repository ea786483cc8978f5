"""Converts QoS profiles and endpoints between rclpy and graphengine, and finds the Python classes of ROS 2 types."""

from __future__ import annotations

import contextlib
import importlib
import re
from collections.abc import Mapping
from typing import Any

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import settled
from graphengine.ros.network_graph import Endpoint
from graphengine.ros.transports.rcl.installation import folders_of

UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"
"""Node name in rclpy for an endpoint whose process has not announced its nodes yet."""
_NO_NODE = "_CREATED_BY_BARE_DDS_APP_"
"""Node name in rclpy for an endpoint of a process that is not a ROS 2 program."""


def to_profile(qos: QoS) -> Any:
    """Return the rclpy profile for a QoS."""
    from rclpy.duration import Duration
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

    qos = settled(qos)
    return QoSProfile(
        history=HistoryPolicy[_NAMES[qos.history]],
        depth=qos.depth,
        reliability=ReliabilityPolicy[_NAMES[qos.reliability]],
        durability=DurabilityPolicy[_NAMES[qos.durability]],
        deadline=Duration(seconds=qos.deadline),
        lifespan=Duration(seconds=qos.lifespan),
        liveliness=LivelinessPolicy[_NAMES[qos.liveliness]],
        liveliness_lease_duration=Duration(seconds=qos.lease_duration),
    )


def to_endpoint(topic: str, info: Any) -> Endpoint:
    """Return an endpoint of a topic from rclpy's `TopicEndpointInfo`."""
    owned = info.node_name not in (UNKNOWN_NODE, _NO_NODE)
    return Endpoint(
        gid=bytes(info.endpoint_gid),
        direction="publish" if info.endpoint_type.name == "PUBLISHER" else "subscribe",
        topic=topic,
        message_type=info.topic_type,
        qos=_qos(info.qos_profile),
        type_hash=str(info.topic_type_hash),
        node=info.node_name if owned else "",
        namespace=info.node_namespace if owned else "",
    )


def _qos(profile: Any) -> QoS:
    kinds = (profile.history, profile.reliability, profile.durability, profile.liveliness)
    history, reliability, durability, liveliness = (_WORDS.get(kind.name, "systemDefault") for kind in kinds)
    return QoS(
        history=history,
        depth=profile.depth,
        reliability=reliability,
        durability=durability,
        deadline=_seconds(profile.deadline),
        lifespan=_seconds(profile.lifespan),
        liveliness=liveliness,
        lease_duration=_seconds(profile.liveliness_lease_duration),
    )


_VALUES = ("keepLast", "keepAll", "reliable", "bestEffort", "volatile", "transientLocal", "automatic", "manualByTopic")
_NAMES: Mapping[str, str] = {value: re.sub("(?=[A-Z])", "_", value).upper() for value in _VALUES}
"""rclpy's name of each value of a QoS policy, such as KEEP_LAST for `keepLast`."""
_WORDS: Mapping[str, Any] = {name: value for value, name in _NAMES.items()}
"""Value of a QoS policy for each of rclpy's names; all other names, such as UNKNOWN, mean `systemDefault`."""


def _seconds(time: Any) -> float:
    """Return an rclpy duration in seconds; an infinite duration becomes 0."""
    from rclpy.duration import Infinite

    return 0.0 if time == Infinite else time.nanoseconds / 1e9


_PARTS_OF_ACTIONS = {
    "SendGoal": "SendGoalService",
    "GetResult": "GetResultService",
    "FeedbackMessage": "FeedbackMessage",
}
"""Attribute of a Python action class's `Impl` for each suffix of a service or message type."""


def ros_class(kind: str, *, service: bool) -> Any:
    """Return the Python class of a message or service type, or of a part of an action such as `…/action/Fibonacci_SendGoal`.

    Only packages that rosidl generated are imported, because a type name may come from the network.

    Raises:
        AttributeError, ImportError: the package or the type is not installed.
        ValueError: the type is not a service, or not a message.
    """
    module, _, name = kind.rpartition("/")
    package = module.partition("/")[0]
    libraries = f"{package}_s__rosidl_typesupport_*"
    if not package.isidentifier() or not any(any(folder.glob(libraries)) for folder in folders_of(package)):
        raise ImportError(f"no package of ROS 2 types named {package!r} is installed")
    found = importlib.import_module(module.replace("/", "."))
    action, _, part = name.rpartition("_")
    if module.endswith("/action") and part in _PARTS_OF_ACTIONS:
        found = getattr(getattr(found, action).Impl, _PARTS_OF_ACTIONS[part])
    else:
        found = getattr(found, name)
    if not hasattr(found, "Request" if service else "get_fields_and_field_types"):
        raise ValueError(f"it is not a {'service' if service else 'message'}")
    return found


def is_installed(kind: str) -> bool:
    """Return whether `ros_class` finds a message or a service class."""
    for service in (False, True):
        with contextlib.suppress(AttributeError, ImportError, ValueError):
            return ros_class(kind, service=service) is not None
    return False
