"""Nodes that output the points of a lidar or radar as buffers (`isaacsim.sensors.rtx`), for ROS2PublishPointCloud.

In Isaac Sim, these nodes read a buffer of the RTX renderer. Here `renderProductPath` selects the sensor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.device import TickSensor
from graphengine.devices.lidar import Lidar
from graphengine.devices.motion import Frame
from graphengine.devices.radar import Radar
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.node.types import Buffer, Float, Float3, Int, Matrix4d, Token, UInt, UInt64
from graphengine.nodes.lidar import beams_of_a_ring
from graphengine.nodes.point_metadata import metadata_ports, output_inputs, output_name
from graphengine.nodes.prims import matrix_of

_BUFFER = "no effect; in Isaac Sim, a buffer of the RTX renderer"
_DEPRECATED = "no effect; deprecated in Isaac Sim"
_TYPE = "value has no meaning: the type of the buffer's elements is fixed"
_SIZE = "size of the buffer in bytes"
_NONE = "ray casting does not provide this metadata: the output is always 0"
_MISSING = ("materialId", "tickId", "hitNormal", "velocity", "objectId", "echoId", "tickState")
"""Names of the point metadata that exist in Isaac Sim, but that ray casting does not provide."""
_BUFFERS = {
    "azimuth": ("deg", "azimuths: buffer with one float32 per point"),
    "elevation": ("deg", "elevations: buffer with one float32 per point"),
    "distance": ("m", "distances from the sensor: buffer with one float32 per point"),
    "intensity": ("", "intensities, 0 to 255 for a lidar, in dB for a radar: buffer with one float32 per point"),
    "timestamp": ("ns", "simulation time of the sample, repeated: buffer with one uint64 per point"),
    "emitterId": ("", "indices of the lidar's beams, from 0: buffer with one uint32 per point"),
    "channelId": ("", "indices of the lidar's rings, from 0 in the lidar's order: buffer with one uint32 per point"),
    **dict.fromkeys(_MISSING, ("", _NONE)),
    "radialVelocityMS": ("m/s", "radial velocities, only of a radar: buffer with one float32 per point"),
}
"""A dict from each kind of point metadata to the unit and the description of its buffer."""
_SELECTORS = {
    **dict.fromkeys(_MISSING, _NONE),
    "emitterId": "true: output emitter IDs, which only a lidar has",
    "channelId": "true: output channel IDs, which only a lidar has",
    "radialVelocityMS": "true: output radial velocities, which only a radar has",
}
"""Descriptions of inputs that select a kind of point metadata."""


@dataclass(frozen=True, slots=True)
class _Returns:
    """The points of one lidar or radar sample, with their metadata."""

    time: float
    """Simulation time of the sample, s."""
    points: NDArray[np.float32]
    """Positions in the sensor's frame, m, shape (n, 3)."""
    values: Mapping[str, NDArray[Any]]
    """A dict from each kind of metadata that the sensor provides to an array with one element per point."""

    def metadata(self, name: str) -> NDArray[Any] | None:
        """Return one kind of metadata, with one element per point, or None if the sensor does not provide it.

        Azimuth, elevation and distance are computed from the points; every point has the time of the sample as its timestamp.
        """
        x, y, z = self.points.T
        found: NDArray[Any] | None
        match name:
            case "azimuth":
                found = np.degrees(np.arctan2(y, x))
            case "elevation":
                found = np.degrees(np.arctan2(z, np.hypot(x, y)))
            case "distance":
                found = np.linalg.norm(self.points, axis=1)
            case "timestamp":
                found = np.full(len(self.points), int(self.time * 1e9), np.uint64)
            case _:
                found = self.values.get(name)
        return found


def _of_lidar(lidar: Lidar) -> _Returns:
    """Return the hit points of the newest lidar sample; beams without a hit give no point."""
    scan = lidar.scan()
    hit = np.flatnonzero(np.isfinite(scan.ranges))
    rings = (hit // beams_of_a_ring(lidar)).astype(np.uint32)
    values = {"intensity": scan.intensities[hit], "emitterId": hit.astype(np.uint32), "channelId": rings}
    return _Returns(scan.time, scan.points_of(hit).astype(np.float32), values)


def _of_radar(radar: Radar) -> _Returns:
    """Return the detections of the newest radar sample as points."""
    sample = radar.detections()
    values = {"intensity": sample.intensities, "radialVelocityMS": sample.radial_velocities}
    return _Returns(sample.time, sample.points, values)


class PointBuffersNode(Node):
    """Base of nodes that output the points of each lidar or radar sample. A subclass defines `exec_out` and `is_selected`."""

    exec_out: ClassVar[ExecOut]

    exec_in = ExecIn(name="exec")
    data_ptr: Buffer = In(default=0, doc=_BUFFER)
    cuda_device_index: Int = In(default=-1, doc="no effect: buffers are in host memory")
    data_ptr_out: Buffer = Out(
        default=0, name="dataPtr", unit="m", doc="points in the sensor's frame: buffer of x, y, z as float32"
    )
    cuda_device_index_out: Int = Out(default=-1, name="cudaDeviceIndex", doc="always -1: host memory")
    buffer_size: UInt64 = Out(default=0, doc=_SIZE)
    transform: Matrix4d = Out(
        doc="pose of the sensor in the world frame: 4 x 4 matrix for row vectors, with the position (m) in its last row"
    )
    width: UInt = Out(default=0, doc="number of points in the sample")
    height: UInt = Out(default=1, doc="always 1, as the points have no rows")
    vars().update(metadata_ports(Out, _BUFFERS, _TYPE, _SIZE))

    sensor: TickSensor = Bound()
    read: Callable[[], _Returns] = Bound()
    frame: Frame = Bound()
    last: int = State(default=-1)

    def bind(self, context: Context, path: str) -> None:
        """Look up the lidar or radar at a path, and keep handles to it and its frame.

        Args:
            context: context of the node.
            path: path of the sensor's prim or of a render product.
        """
        if context.kind(path) == "radar":
            radar = context.device(Radar, path)
            self.sensor, self.read = radar, lambda: _of_radar(radar)
        else:
            lidar = context.device(Lidar, path)
            self.sensor, self.read = lidar, lambda: _of_lidar(lidar)
        self.frame = context.frame(self.sensor.prim_path)

    def compute(self) -> Fire:
        """Set the outputs and fire if the sensor has a new sample in this tick."""
        sensor = self.sensor
        if not sensor.due or sensor.index == self.last:
            return None
        self.last = sensor.index
        self.put_out(self.read())
        return self.exec_out

    def put_out(self, returns: _Returns) -> None:
        """Set the outputs to the points of a sample and to the selected metadata."""
        self.data_ptr_out, self.buffer_size = returns.points, returns.points.nbytes
        self.width, self.transform = len(returns.points), matrix_of(self.frame.pose())
        for name, (buffer, size) in _METADATA.items():
            values = returns.metadata(name) if self.is_selected(name) else None
            if values is not None:
                setattr(self, buffer, values)
                setattr(self, size, values.nbytes)

    def is_selected(self, name: str) -> bool:
        """Return whether to output the metadata with this name, such as `azimuth`."""
        raise NotImplementedError


_METADATA = {
    name: tuple(PointBuffersNode.ports[f"outputs:{name}{what}"].field for what in ("Ptr", "BufferSize"))
    for name in _BUFFERS
    if name not in _MISSING
}
"""A dict from each kind of metadata that a sensor provides to the Python names of two outputs: the buffer and its size."""


class OgnIsaacExtractRTXSensorPointCloud(
    PointBuffersNode, type="isaacsim.sensors.rtx.nodes.OgnIsaacExtractRTXSensorPointCloud", gated=True
):
    """Outputs the points of a lidar or radar and their metadata as buffers; fires once per sample of the sensor.

    `renderProductPath` selects the sensor. The input `dataPtr` has no effect; in Isaac Sim, it is a buffer of the RTX renderer.
    Each kind of metadata, such as the azimuth, has two outputs: a buffer and the size of the buffer. The node sets both outputs
    if at least one of them is wired and ray casting provides this metadata; otherwise both stay 0. All points of a sample have
    the same time.
    """

    render_product_path: Token = In(
        required=True,
        setup=True,
        extension=True,
        doc="lidar or radar: path from IsaacCreateRenderProduct, or prim path",
    )
    exec_out = ExecOut(name="exec", doc="fires once per sample of the sensor")

    wired: frozenset[str] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the sensor that `renderProductPath` selects, and find out which metadata outputs are wired."""
        self.bind(context, self.render_product_path)
        self.wired = frozenset(name for name, fields in _METADATA.items() if any(map(context.wired, fields)))

    def is_selected(self, name: str) -> bool:
        """Return whether the buffer of this metadata, or the size of the buffer, is wired."""
        return name in self.wired


class IsaacCreateRTXLidarScanBuffer(
    PointBuffersNode, type="isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer", gated=True
):
    """Outputs the points of a lidar or radar and selected metadata as buffers; fires once per sample of the sensor.

    `renderProductPath` selects the sensor. The input `dataPtr` has no effect; in Isaac Sim, it is a buffer of the RTX renderer.
    Outputs for metadata that is not selected, or that ray casting does not provide, stay 0. All points of a sample have the same
    time.
    """

    keep_only_positive_distance: bool = In(default=True, doc=_DEPRECATED)
    transform_points: bool = In(default=False, doc=_DEPRECATED)
    accuracy_error_azimuth_deg: Float = In(default=0.0, unit="deg", doc=_DEPRECATED)
    accuracy_error_elevation_deg: Float = In(default=0.0, unit="deg", doc=_DEPRECATED)
    accuracy_error_position: Float3 = In(default=(0.0, 0.0, 0.0), unit="m", doc=_DEPRECATED)
    render_product_path: Token = In(
        required=True, setup=True, doc="path from IsaacCreateRenderProduct, or the prim path of a lidar or radar"
    )
    vars().update(output_inputs(_BUFFERS, _SELECTORS))
    enable_per_frame_output: bool = In(default=False, doc=_DEPRECATED)
    exec_out = ExecOut(name="exec", doc="fires once per sample of the sensor")

    def setup(self, context: Context) -> None:
        """Look up the sensor that `renderProductPath` selects, and warn about metadata that ray casting does not provide."""
        self.bind(context, self.render_product_path)
        lost = ", ".join(output_name(name) for name in _MISSING if self.is_selected(name))
        if lost:
            text = "ray casting does not provide the metadata of these inputs, so they have no effect"
            context.log("warning", f"{text}: {lost}")

    def is_selected(self, name: str) -> bool:
        """Return whether the input that selects this metadata is true."""
        selected: bool = getattr(self, type(self).ports[f"inputs:{output_name(name)}"].field)
        return selected
