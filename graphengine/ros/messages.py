"""ROS 2 messages: the Jazzy definitions of rosbags under their ROS names, and their encoding as CDR.

A message is a plain dataclass; its array fields are numpy arrays of the exact dtype. Bytes are one CDR message: a header of
four bytes, then the fields in little endian, padded to whole words of four bytes. Importing this takes about 90 ms.
"""

from __future__ import annotations

import functools
import io
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.stores.ros2_jazzy import builtin_interfaces__msg__Duration as Duration
from rosbags.typesys.stores.ros2_jazzy import builtin_interfaces__msg__Time as Time
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Point as Point
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Pose as Pose
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__PoseStamped as PoseStamped
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__PoseWithCovariance as PoseWithCovariance
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Quaternion as Quaternion
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Transform as Transform
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__TransformStamped as TransformStamped
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Twist as Twist
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__TwistStamped as TwistStamped
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__TwistWithCovariance as TwistWithCovariance
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Vector3 as Vector3
from rosbags.typesys.stores.ros2_jazzy import nav_msgs__msg__OccupancyGrid as OccupancyGrid
from rosbags.typesys.stores.ros2_jazzy import nav_msgs__msg__Odometry as Odometry
from rosbags.typesys.stores.ros2_jazzy import nav_msgs__msg__Path as Path
from rosbags.typesys.stores.ros2_jazzy import rcl_interfaces__msg__Log as Log
from rosbags.typesys.stores.ros2_jazzy import rmw_dds_common__msg__Gid as Gid
from rosbags.typesys.stores.ros2_jazzy import rmw_dds_common__msg__NodeEntitiesInfo as NodeEntitiesInfo
from rosbags.typesys.stores.ros2_jazzy import rmw_dds_common__msg__ParticipantEntitiesInfo as ParticipantEntitiesInfo
from rosbags.typesys.stores.ros2_jazzy import rosgraph_msgs__msg__Clock as Clock
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__CameraInfo as CameraInfo
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__CompressedImage as CompressedImage
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__Image as Image
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__Imu as Imu
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__JointState as JointState
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__LaserScan as LaserScan
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__PointCloud2 as PointCloud2
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__PointField as PointField
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__RegionOfInterest as RegionOfInterest
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__Bool as Bool
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__Float64 as Float64
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__Header as Header
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__String as String
from rosbags.typesys.stores.ros2_jazzy import tf2_msgs__msg__TFMessage as TFMessage

from graphengine.diagnostics import TransportError
from graphengine.ros.definitions import DEFINITIONS, Definitions
from graphengine.ros.faults import find_fault
from graphengine.ros.interfaces import MessageTypeError

__all__ = [
    "DEFINITIONS",
    "Definitions",
    "MessageError",
    "MessageTypeError",
    "check",
    "decode",
    "encode",
    "header",
    "message_class",
    "message_type",
    "seconds",
    "stamp",
    "type_hash",
    "Bool",
    "CameraInfo",
    "Clock",
    "CompressedImage",
    "Duration",
    "Float64",
    "Gid",
    "Header",
    "Image",
    "Imu",
    "JointState",
    "LaserScan",
    "Log",
    "NodeEntitiesInfo",
    "OccupancyGrid",
    "Odometry",
    "ParticipantEntitiesInfo",
    "Path",
    "Point",
    "PointCloud2",
    "PointField",
    "Pose",
    "PoseStamped",
    "PoseWithCovariance",
    "Quaternion",
    "RegionOfInterest",
    "String",
    "TFMessage",
    "Time",
    "Transform",
    "TransformStamped",
    "Twist",
    "TwistStamped",
    "TwistWithCovariance",
    "Vector3",
]

_EARLIEST, _LATEST = -(2.0**31), 2.0**31
"""Seconds that a stamp can hold, the last one not included: it counts them in 32 bits."""
_ENCAPSULATIONS = (b"\0\0", b"\0\1")
"""What CDR messages begin with, by their byte order: the larger end first, or the smaller."""


class MessageError(TransportError):
    """A message that is not what its type says, or bytes that are no such message."""


@functools.lru_cache(maxsize=16)  # all messages of a tick bear the same stamp
def stamp(seconds: float) -> Time:
    """A time in seconds as ROS writes it: whole nanoseconds towards zero, of which `nanosec` is never negative.

    Messages share it: make another one rather than change it.

    Raises:
        MessageError: the time is beyond what the message can hold.
    """
    if not _EARLIEST <= seconds < _LATEST:
        raise MessageError(f"a stamp cannot be {seconds} s: ROS 2 counts seconds in 32 bits")
    return Time(*divmod(int(seconds * 1e9), 1_000_000_000))


def seconds(time: Time) -> float:
    """A time of ROS in seconds."""
    return time.sec + time.nanosec / 1e9


def header(seconds: float, frame_id: str) -> Header:
    """A header with that time and frame."""
    return Header(stamp(seconds), frame_id)


def message_type(message: Any) -> str:
    """The ROS name of a message's type, as in `nav_msgs/msg/Odometry`.

    Raises:
        MessageError: it is no message.
    """
    name = getattr(message, "__msgtype__", None)
    if not isinstance(name, str):
        raise MessageError(f"{type(message).__name__} is no ROS message")
    return name


def message_class(message_type: str) -> type[Any]:
    """The dataclass of a type that is known without folders of a user.

    Raises:
        MessageTypeError: there is no such type.
    """
    return DEFINITIONS.message_class(message_type)


def encode(message: Any, definitions: Definitions = DEFINITIONS) -> bytes:
    """One CDR message.

    Array fields are copied as they are: one of another type but of the same size is not noticed. `check` notices.

    Raises:
        MessageError: a field does not have the type that the definition says.
    """
    try:
        store = definitions.store
        codec = store.get_msgdef(message.__msgtype__)
        size = (codec.getsize_cdr(0, message, store) + 7) & -4
        # The bytes of a BytesIO leave it without being copied, and the gap that a seek leaves is zero.
        buffer = io.BytesIO()
        buffer.seek(size - 1)
        buffer.write(b"\0")
        with buffer.getbuffer() as whole, whole[4:] as body:
            whole[1] = 1
            codec.serialize_cdr_le(body, 0, message, store)
        return buffer.getvalue()
    except Exception as error:
        check(message, definitions)
        raise MessageError(f"{message_type(message)} cannot be encoded: {error}") from error


def decode(data: bytes, message_type: str, definitions: Definitions = DEFINITIONS) -> Any:
    """The message that bytes of either byte order hold; arrays are views of them and cannot be written.

    Bytes after it are let pass, as ROS 2 does: rmw_fastrtps_cpp encodes some messages into more bytes than they take.

    Raises:
        MessageError: the bytes are no such message.
        MessageTypeError: there is no such type.
    """
    definitions.definition(message_type)
    store = definitions.store
    try:
        if data[:2] not in _ENCAPSULATIONS:
            raise ValueError("their encapsulation is not that of CDR")
        codec = store.get_msgdef(message_type)
        read = codec.deserialize_cdr_le if data[1] else codec.deserialize_cdr_be
        return read(memoryview(data)[4:], 0, codec.cls, store)[0]
    except Exception as error:
        raise MessageError(f"{len(data)} bytes are no {message_type}: {error}") from error


def check(message: Any, definitions: Definitions = DEFINITIONS) -> None:
    """Compare every field of a message with its definition, arrays by dtype and length too.

    Raises:
        MessageError: it names the first field that differs, and what it should be.
        MessageTypeError: there is no such type.
    """
    name = message_type(message)
    fault = find_fault(message, (Nodetype.NAME, name), name, definitions.fields)
    if fault:
        raise MessageError(fault)


def type_hash(message_type: str) -> str:
    """The REP 2011 hash of a type that is known without folders of a user.

    Raises:
        MessageTypeError: there is no such type.
    """
    return DEFINITIONS.type_hash(message_type)
