"""Creates, checks, encodes and decodes ROS 2 messages.

A message is a plain dataclass; its array fields are numpy arrays with the exact dtype. Encoded messages are CDR: a header of four
bytes, then the fields in little endian, padded to a multiple of four bytes. The classes of Jazzy's messages, such as `Twist`, are
attributes of this module; their import from rosbags at the first use takes 50 ms.
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
"""Range of times that a stamp can hold, s: its seconds are a signed 32-bit number. `_LATEST` is out of range."""
LITTLE_ENDIAN = b"\0\1"
"""First two bytes of a CDR message in little endian."""
_ENCAPSULATIONS = (b"\0\0", LITTLE_ENDIAN)
"""First two bytes of a CDR message in big endian and in little endian."""


class MessageError(TransportError):
    """A message does not fit its type, or bytes cannot be decoded as a message of a type."""


def __getattr__(name: str) -> Any:
    """Return the class of a Jazzy message by the last part of its type name, such as `Twist`."""
    if name[0].isupper():
        from rosbags.typesys.stores import ros2_jazzy

        for full_name, found in vars(ros2_jazzy).items():
            if full_name.endswith(f"__msg__{name}"):
                globals()[name] = found
                return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@functools.lru_cache(maxsize=16)  # all messages of a tick bear the same stamp
def stamp(seconds: float) -> Time:
    """Convert a time in seconds to a ROS time, truncated to nanoseconds.

    The result is shared between messages and must not be changed.

    Raises:
        MessageError: the time is out of the range of builtin_interfaces/Time.
    """
    if not _EARLIEST <= seconds < _LATEST:
        raise MessageError(f"a stamp cannot be {seconds} s: ROS 2 stores seconds in 32 bits")
    time: Time = message_class("builtin_interfaces/msg/Time")(*divmod(int(seconds * 1e9), 1_000_000_000))
    return time


def seconds(time: Time) -> float:
    """Convert a ROS time or duration to seconds."""
    return time.sec + time.nanosec / 1e9


def header(seconds: float, frame_id: str) -> Header:
    """Return a std_msgs/Header with a time in seconds and a frame."""
    made: Header = message_class("std_msgs/msg/Header")(stamp(seconds), frame_id)
    return made


def message_type(message: Any) -> str:
    """Return the ROS name of a message's type, such as `nav_msgs/msg/Odometry`.

    Raises:
        MessageError: the object is not a message.
    """
    name = getattr(message, "__msgtype__", None)
    if not isinstance(name, str):
        raise MessageError(f"{type(message).__name__} is not a ROS message")
    return name


@functools.cache
def message_class(message_type: str) -> type[Any]:
    """Return the dataclass of a message type of Jazzy or `share/`; types in a user's folders are not found.

    Raises:
        MessageTypeError: the type is unknown.
    """
    return DEFINITIONS.message_class(message_type)


def encode(message: Any, definitions: Definitions = DEFINITIONS) -> bytes:
    """Return a message as CDR bytes.

    Arrays are copied without conversion, so an array whose dtype is wrong but has the right size is not detected; `check`
    detects it.

    Raises:
        MessageError: a field has the wrong type.
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
    """Decode a message from CDR bytes in either byte order; its arrays are read-only views of the bytes.

    As in ROS 2, additional bytes at the end are ignored: rmw_fastrtps_cpp encodes some messages into more bytes than necessary.

    Raises:
        MessageError: the bytes cannot be decoded as this type.
        MessageTypeError: the type is unknown.
    """
    definitions.definition(message_type)
    store = definitions.store
    try:
        if data[:2] not in _ENCAPSULATIONS:
            raise ValueError("the encapsulation is not CDR")
        codec = store.get_msgdef(message_type)
        read = codec.deserialize_cdr_le if data[1] else codec.deserialize_cdr_be
        return read(memoryview(data)[4:], 0, codec.cls, store)[0]
    except Exception as error:
        raise MessageError(f"{len(data)} bytes cannot be decoded as {message_type}: {error}") from error


def check(message: Any, definitions: Definitions = DEFINITIONS) -> None:
    """Check all fields of a message against its definition, including dtype and length of arrays.

    Raises:
        MessageError: a value does not fit its field; the error names the first such field and the expected type or length.
        MessageTypeError: the type is unknown.
    """
    name = message_type(message)
    fault = find_fault(message, (Nodetype.NAME, name), name, definitions.fields)
    if fault:
        raise MessageError(fault)
