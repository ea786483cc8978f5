"""Builds and publishes sensor_msgs/PointCloud2 messages, whose points may have metadata."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer, In, Int, Point3fs, String, UInt, UInt64
from graphengine.nodes.point_metadata import metadata_ports, output_inputs
from graphengine.nodes.ros2.publisher import SensorPublisher, bytes_in

METADATA: dict[str, list[Any]] = {
    "Intensity": [("intensity", "<f4")],
    "Timestamp": [("timestamp", "<u4", (2,))],
    "EmitterId": [("emitter_id", "<u4")],
    "ChannelId": [("channel_id", "<u4")],
    "MaterialId": [("material_id", "<u4")],
    "TickId": [("tick_id", "<u4")],
    "HitNormal": [("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4")],
    "Velocity": [("vx", "<f4"), ("vy", "<f4"), ("vz", "<f4")],
    "ObjectId": [("object_id", "<u4", (4,))],
    "EchoId": [("echo_id", "u1")],
    "TickState": [("tick_state", "u1")],
    "RadialVelocityMS": [("radial_velocity_ms", "<f4")],
}
"""Fields of each kind of metadata that Isaac Sim has. In a point, they follow x, y and z in the order of this dict.

A timestamp is in ns and consists of two uint32, low half first.
"""

FIELDS: dict[str, list[Any]] = METADATA | {"Ring": [("ring", "<u2")], "Time": [("time", "<f4")]}
"""Fields of each kind of metadata, with the extensions Ring and Time.

With Intensity, Ring and Time, a point has the layout of Velodyne's driver, which lidar SLAM expects.
"""

_RGB: dict[str, list[Any]] = {"Rgb": [("rgb", "<f4")]}
"""The colour of a point as PCL and depth_image_proc write it: bits 0x00rrggbb in a float32."""

_KNOWN = FIELDS | _RGB
BUFFERS = {
    "intensity": ("", "buffer with one float32 per point, 0 to 255"),
    "timestamp": ("ns", "buffer with one uint64 per point"),
    **dict.fromkeys(("emitterId", "channelId", "materialId", "tickId"), ("", "buffer with one uint32 per point")),
    "hitNormal": ("", "buffer with three float32 per point"),
    "velocity": ("m/s", "buffer with three float32 per point"),
    "objectId": ("", "buffer with four uint32 per point"),
    **dict.fromkeys(("echoId", "tickState"), ("", "buffer with one uint8 per point")),
    "radialVelocityMS": ("m/s", "buffer with one float32 per point"),
}
"""A dict from the name of each kind of metadata in METADATA to the unit and description of its input."""
_DATATYPES = {"f4": 7, "u4": 6, "u2": 4, "u1": 2}
"""Values of `datatype` in sensor_msgs/PointField, by numpy type."""


@functools.cache
def layout(metadata: tuple[str, ...]) -> tuple[np.dtype[Any], list[messages.PointField]]:
    """Return the layout of a point with x, y, z and the given metadata, as a dtype and as a list of PointFields.

    All messages with the same metadata share the list.
    """
    extra = [field for name in metadata for field in _KNOWN[name]]
    packed = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), *extra])
    fields = []
    for name, (kind, offset, *_) in (packed.fields or {}).items():
        datatype = _DATATYPES[kind.base.str[1:]]
        fields.append(messages.PointField(name, offset, datatype, int(np.prod(kind.shape, dtype=int))))
    return packed, fields


def point_cloud(
    header: messages.Header, positions: NDArray[np.floating[Any]], metadata: Mapping[str, Buffer] | None = None
) -> messages.PointCloud2:
    """Return a point cloud message.

    Args:
        header: time and frame.
        positions: points in the header's frame, m. The shape is (n, 3) for finite points in one row, or (height, width, 3) for an
            organized cloud, in which pixels without a return are NaN.
        metadata: a dict from a name in FIELDS to a buffer with one packed record per point; `Rgb` is a colour per point.

    Raises:
        BadValueError: a buffer does not have one record per point.
    """
    given = metadata or {}
    names = tuple(name for name in _KNOWN if name in given)
    packed, fields = layout(names)
    height, width = (1, *positions.shape)[-3:-1]
    dense = positions.ndim == 2 or not bool(np.isnan(positions).any())
    positions = positions.reshape(-1, 3)
    if names:
        points = np.empty(len(positions), packed)
        points["x"], points["y"], points["z"] = positions.T
        for name in names:
            _fill(points, name, given[name])
        data = points.view(np.uint8)
    else:
        data = np.ascontiguousarray(positions, "<f4").reshape(-1).view(np.uint8)
    step = packed.itemsize
    return messages.PointCloud2(header, height, width, fields, False, step, step * width, data, dense)


def _fill(points: NDArray[Any], name: str, buffer: Buffer) -> None:
    kind, data = np.dtype(_KNOWN[name]), bytes_in(buffer)
    if len(data) != kind.itemsize * len(points):
        legal = f"consistent, with a buffer of {kind.itemsize} bytes for each of {len(points)} points"
        raise BadValueError(f"{_port(name)}, data, dataPtr", len(data), legal)
    records = data.view(kind)
    for field in records.dtype.names or ():
        points[field] = records[field]


def _port(name: str) -> str:
    """Return the name of the input port that takes the buffer of a kind of metadata."""
    return f"{name[0].lower()}{name[1:]}Ptr"


def _points_in(buffer: Buffer) -> NDArray[np.float32]:
    data = bytes_in(buffer)
    if len(data) % 12:
        raise BadValueError("dataPtr", len(data), "a multiple of 12 bytes, three float32 per point")
    return data.view("<f4").reshape(-1, 3)


class ROS2PublishPointCloud(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishPointCloud"):
    """Publishes points as sensor_msgs/PointCloud2.

    The points are an array or a buffer of x, y, z in single precision. Each kind of metadata is a buffer with one record per
    point; it is published if its `output...` input is true. The inputs for data types and buffer sizes have no effect: the types
    are fixed, and the size of a buffer is known from the buffer itself.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/PointCloud2"

    frame_id: String = In(default="sim_lidar", setup=True)
    topic_name: String = In(default="point_cloud", setup=True)
    vars().update(output_inputs(BUFFERS))
    data_ptr: Buffer = In(default=0, doc="buffer of points, x, y, z as float32, used if `data` is empty")
    data: Point3fs = In(unit="m", doc="points in the frame `frameId`")
    cuda_device_index: Int = In(default=-1, doc="no effect: buffers are in host memory")
    buffer_size: UInt = In(default=0)
    vars().update(metadata_ports(In, BUFFERS))
    timestamp_data_type: UInt64 = In(default=8)

    def message(self) -> messages.PointCloud2:
        """Return the message with the points and their metadata."""
        points = self.data
        if not len(points) and not isinstance(self.data_ptr, int):
            points = _points_in(self.data_ptr)
        return point_cloud(self.header(), points, self.metadata())

    def metadata(self) -> dict[str, Buffer]:
        """Return a dict from the name in METADATA of each kind of metadata to publish to its buffer.

        Raises:
            BadValueError: an input such as `outputAzimuth` is true, but the buffer of this metadata is missing.
        """
        ports, chosen = type(self).ports, dict[str, Buffer]()
        for name in METADATA:
            if getattr(self, ports[f"inputs:output{name}"].field):
                buffer = chosen[name] = getattr(self, ports[f"inputs:{_port(name)}"].field)
                if isinstance(buffer, int):
                    legal = f"a buffer, because output{name} is true"
                    raise BadValueError(f"output{name}, {_port(name)}", buffer, legal)
        return chosen
