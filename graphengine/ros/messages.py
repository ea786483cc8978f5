"""ROS 2 messages: the Jazzy definitions of rosbags under their ROS names, and their encoding as CDR.

A message is a plain dataclass; its array fields are numpy arrays of the exact dtype. Bytes are one CDR message: a header of
four bytes, then the fields in little endian, padded to whole words of four bytes. Importing this takes about 90 ms.
"""

from __future__ import annotations

import functools
import io
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore
from rosbags.typesys.stores import ros2_jazzy
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

from graphengine.diagnostics import TransportError, did_you_mean

__all__ = [
    "DEFINITIONS",
    "MessageError",
    "check",
    "decode",
    "encode",
    "header",
    "message_class",
    "message_type",
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

DEFINITIONS = Typestore(ros2_jazzy)
"""Fields and constants of every message type, by its ROS name."""

_INT32 = 2**31


class MessageError(TransportError):
    """A message that is not what its type says, or bytes that are no such message."""


@functools.lru_cache(maxsize=16)  # all messages of a tick bear the same stamp
def stamp(seconds: float) -> Time:
    """A time in seconds as ROS writes it: whole nanoseconds towards zero, of which `nanosec` is never negative.

    Messages share it: make another one rather than change it.

    Raises:
        MessageError: the time is beyond what the message can hold.
    """
    if not -_INT32 <= seconds < _INT32:
        raise MessageError(f"a stamp cannot be {seconds} s: ROS 2 counts seconds in 32 bits")
    return Time(*divmod(int(seconds * 1e9), 1_000_000_000))


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
    """The dataclass of a type.

    Raises:
        MessageError: there is no such type in ROS 2 Jazzy's common interfaces.
    """
    _known(message_type)
    return DEFINITIONS.types[message_type]


def encode(message: Any) -> bytes:
    """One CDR message.

    Array fields are copied as they are: one of another type but of the same size is not noticed. `check` notices.

    Raises:
        MessageError: a field does not have the type that the definition says.
    """
    try:
        measure, serialize = _codec(message.__msgtype__)
        size = (measure(0, message, DEFINITIONS) + 7) & -4
        # The bytes of a BytesIO leave it without being copied, and the gap that a seek leaves is zero.
        buffer = io.BytesIO()
        buffer.seek(size - 1)
        buffer.write(b"\0")
        with buffer.getbuffer() as whole, whole[4:] as body:
            whole[1] = 1
            serialize(body, 0, message, DEFINITIONS)
        return buffer.getvalue()
    except Exception as error:
        check(message)
        raise MessageError(f"{message_type(message)} cannot be encoded: {error}") from error


def decode(data: bytes, message_type: str) -> Any:
    """The message that bytes of either byte order hold; arrays are views of them and cannot be written.

    Raises:
        MessageError: the bytes are no such message.
    """
    _known(message_type)
    try:
        return DEFINITIONS.deserialize_cdr(memoryview(data), message_type)
    except Exception as error:
        raise MessageError(f"{len(data)} bytes are no {message_type}: {error}") from error


def check(message: Any) -> None:
    """Compare every field of a message with its definition, arrays by dtype too.

    Raises:
        MessageError: it names the first field that differs, and what it should be.
    """
    name = message_type(message)
    _known(name)
    fault = _fault(message, (Nodetype.NAME, name), name)
    if fault:
        raise MessageError(fault)


@functools.cache
def type_hash(message_type: str) -> str:
    """The REP 2011 hash of a type, by which ROS 2 peers tell versions of a definition apart.

    Raises:
        MessageError: there is no such type.
    """
    _known(message_type)
    return _hashed_definitions().hash_rihs01(message_type)


@functools.cache
def _hashed_definitions() -> Typestore:
    """Definitions with `char` as the alias of `uint8` that it is in ROS 2; rosbags hashes it as a type of its own."""
    store = Typestore(ros2_jazzy)
    for name, (constants, fields) in store.fielddefs.items():
        store.fielddefs[name] = (constants, [(field, _without_char(description)) for field, description in fields])
    return store


def _without_char(description: Any) -> Any:
    kind, detail = description
    if kind == Nodetype.BASE:
        return kind, ("uint8" if detail[0] == "char" else detail[0], detail[1])
    return description if kind == Nodetype.NAME else (kind, (_without_char(detail[0]), detail[1]))


@functools.cache
def _codec(message_type: str) -> tuple[Callable[[int, Any, Typestore], int], Callable[[Any, int, Any, Typestore], int]]:
    """The functions that rosbags generates for a type; to look them up once is half of their own time."""
    definition = DEFINITIONS.get_msgdef(message_type)
    return definition.getsize_cdr, definition.serialize_cdr_le


def _known(message_type: str) -> None:
    if message_type not in DEFINITIONS.types:
        near = did_you_mean(message_type, DEFINITIONS.types)
        raise MessageError(f"no message type {message_type!r}" + (f"\n{near}" if near else ""))


SCALARS = {
    "bool": "?",
    "byte": "b",  # rosbags takes it for signed, ROS 2 does not
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "<h",
    "uint16": "<H",
    "int32": "<i",
    "uint32": "<I",
    "int64": "<q",
    "uint64": "<Q",
    "float32": "<f",
    "float64": "<d",
}
"""How `struct` packs each number of a message."""
_DTYPES: dict[str, tuple[str, ...]] = {"byte": ("uint8", "int8"), "char": ("uint8",)}


def _fault(value: Any, description: Any, place: str) -> str:
    """What is wrong with a value, or the empty string."""
    kind, detail = description
    if kind == Nodetype.NAME:
        if getattr(value, "__msgtype__", None) != detail:
            return f"{place} is {type(value).__name__}, not {detail}"
        fields = DEFINITIONS.get_msgdef(detail).fields
        faults = (_fault(getattr(value, name), field, f"{place}.{name}") for name, field in fields)
        return next(filter(None, faults), "")
    if kind == Nodetype.BASE:
        return _fault_of_scalar(value, detail[0], place)
    element, count = detail
    if kind == Nodetype.ARRAY and hasattr(value, "__len__") and len(value) != count:
        return f"{place} has {len(value)} elements, not {count}"
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        dtypes = _DTYPES.get(element[1][0], (element[1][0],))
        if not isinstance(value, np.ndarray):
            return f"{place} is {type(value).__name__}, not a numpy array of {dtypes[0]}"
        if value.dtype.name not in dtypes or value.ndim != 1 or not value.flags.c_contiguous:
            layout = "" if value.flags.c_contiguous else "non-contiguous "
            return f"{place} is a {layout}{value.ndim}-dimensional array of {value.dtype}, not a row of {dtypes[0]}"
        return ""
    if not isinstance(value, list | tuple):
        return f"{place} is {type(value).__name__}, not a list"
    return next(filter(None, (_fault(item, element, f"{place}[{i}]") for i, item in enumerate(value))), "")


def _fault_of_scalar(value: Any, name: str, place: str) -> str:
    if name == "string":
        return "" if isinstance(value, str) else f"{place} is {type(value).__name__}, not str"
    try:
        struct.pack(SCALARS[name], value)
    except (struct.error, OverflowError):
        return f"{place} is {value!r}, not a {name}"
    return ""
