"""ROS 2 messages: rosbags' definitions for Jazzy under their ROS names, and their CDR encoding.

A message is a plain dataclass; its array fields are numpy arrays of the exact dtype. Bytes are one CDR message: a header of
four bytes, then the fields in little endian, padded to whole words of four bytes. Common messages such as `Twist` are
attributes of this module, imported from rosbags at their first use, which takes 50 ms.
"""

from __future__ import annotations

import functools
import io
from typing import TYPE_CHECKING, Any

from rosbags.interfaces import Nodetype

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.message_validation import find_fault

if TYPE_CHECKING:
    from rosbags.typesys.stores import ros2_jazzy

    Time = ros2_jazzy.builtin_interfaces__msg__Time
    Point = ros2_jazzy.geometry_msgs__msg__Point
    Pose = ros2_jazzy.geometry_msgs__msg__Pose
    PoseWithCovariance = ros2_jazzy.geometry_msgs__msg__PoseWithCovariance
    Quaternion = ros2_jazzy.geometry_msgs__msg__Quaternion
    Transform = ros2_jazzy.geometry_msgs__msg__Transform
    TransformStamped = ros2_jazzy.geometry_msgs__msg__TransformStamped
    Twist = ros2_jazzy.geometry_msgs__msg__Twist
    TwistStamped = ros2_jazzy.geometry_msgs__msg__TwistStamped
    TwistWithCovariance = ros2_jazzy.geometry_msgs__msg__TwistWithCovariance
    Vector3 = ros2_jazzy.geometry_msgs__msg__Vector3
    Odometry = ros2_jazzy.nav_msgs__msg__Odometry
    Log = ros2_jazzy.rcl_interfaces__msg__Log
    ParticipantEntitiesInfo = ros2_jazzy.rmw_dds_common__msg__ParticipantEntitiesInfo
    Clock = ros2_jazzy.rosgraph_msgs__msg__Clock
    CameraInfo = ros2_jazzy.sensor_msgs__msg__CameraInfo
    CompressedImage = ros2_jazzy.sensor_msgs__msg__CompressedImage
    Image = ros2_jazzy.sensor_msgs__msg__Image
    Imu = ros2_jazzy.sensor_msgs__msg__Imu
    JointState = ros2_jazzy.sensor_msgs__msg__JointState
    LaserScan = ros2_jazzy.sensor_msgs__msg__LaserScan
    PointCloud2 = ros2_jazzy.sensor_msgs__msg__PointCloud2
    PointField = ros2_jazzy.sensor_msgs__msg__PointField
    RegionOfInterest = ros2_jazzy.sensor_msgs__msg__RegionOfInterest
    Header = ros2_jazzy.std_msgs__msg__Header
    String = ros2_jazzy.std_msgs__msg__String
    TFMessage = ros2_jazzy.tf2_msgs__msg__TFMessage

_EARLIEST, _LATEST = -(2.0**31), 2.0**31
"""Seconds that a stamp can hold, the last one not included: it counts them in 32 bits."""
_ENCAPSULATIONS = (b"\0\0", b"\0\1")
"""What CDR messages begin with, by their byte order: the larger end first, or the smaller."""


class MessageError(TransportError):
    """A message that is not what its type says, or bytes that are no such message."""


def __getattr__(name: str) -> Any:
    """The class of a message of Jazzy by the last part of its type's name, as in `Twist`."""
    if name[0].isupper():
        from rosbags.typesys.stores import ros2_jazzy

        for full_name, found in vars(ros2_jazzy).items():
            if full_name.endswith(f"__msg__{name}"):
                globals()[name] = found
                return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@functools.lru_cache(maxsize=16)  # all messages of a tick bear the same stamp
def stamp(seconds: float) -> Time:
    """A time in seconds as ROS writes it: whole nanoseconds towards zero, of which `nanosec` is never negative.

    Messages share it: make another one rather than change it.

    Raises:
        MessageError: the time is beyond what the message can hold.
    """
    if not _EARLIEST <= seconds < _LATEST:
        raise MessageError(f"a stamp cannot be {seconds} s: ROS 2 counts seconds in 32 bits")
    time: Time = message_class("builtin_interfaces/msg/Time")(*divmod(int(seconds * 1e9), 1_000_000_000))
    return time


def seconds(time: Time) -> float:
    """A time of ROS in seconds."""
    return time.sec + time.nanosec / 1e9


def header(seconds: float, frame_id: str) -> Header:
    """A header with that time and frame."""
    made: Header = message_class("std_msgs/msg/Header")(stamp(seconds), frame_id)
    return made


def message_type(message: Any) -> str:
    """The ROS name of a message's type, as in `nav_msgs/msg/Odometry`.

    Raises:
        MessageError: it is no message.
    """
    name = getattr(message, "__msgtype__", None)
    if not isinstance(name, str):
        raise MessageError(f"{type(message).__name__} is no ROS message")
    return name


@functools.cache
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
