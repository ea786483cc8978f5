"""The helper that publishes a lidar for as long as the simulation plays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.context import Clock, Context, Lidar, Publisher, Scan
from graphengine.diagnostics import ContextError, listing
from graphengine.node import ExecIn, In, Node, State
from graphengine.ros import messages
from graphengine.types import String, Token, Tokens, UInt, UInt64

_METADATA: dict[str, list[Any]] = {
    "Intensity": [("intensity", "<f4")],
    "Timestamp": [("timestamp", "<u4", (2,))],
    "EmitterId": [("emitter_id", "<u4")],
    "ChannelId": [("channel_id", "<u4")],
}
"""Fields that selectedMetadata adds to a point cloud after x, y and z, in this order."""

_FLOAT32, _UINT32 = 7, 6  # sensor_msgs/PointField


class ROS2RtxLidarHelper(Node, type="isaacsim.ros2.bridge.ROS2RtxLidarHelper"):
    """Publishes a lidar's samples as LaserScan or PointCloud2, from its first execution until stop.

    The scan covers exactly the sensor's field of view, one range a beam. The topic's namespace is collected from the sensor's
    prim. A sample that nobody wants is not cast.
    """

    exec_in = ExecIn()
    enabled: bool = In(default=True, doc="when false, an execution ends the publishing")
    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="used as it is; empty for `isaac:namespace` of the prims above the sensor"
    )
    frame_id: String = In(default="sim_lidar", setup=True)
    topic_name: String = In(default="scan", setup=True)
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, queueSize"
    )
    queue_size: UInt64 = In(default=10, setup=True, doc="history depth, when no QoS profile is given")
    render_product_path: Token = In(
        required=True, setup=True, doc="of IsaacCreateRenderProduct, or a lidar's prim path"
    )
    type_in: Token = In(default="laser_scan", name="type", setup=True, tokens=("laser_scan", "point_cloud"))
    reset_simulation_time_on_stop: bool = In(default=True, doc="stamps count from play; else over stop and play")
    full_scan: bool = In(default=True, doc="deprecated: samples are always whole")
    show_debug_view: bool = In(default=False, doc="no effect: there is no viewport")
    use_system_time: bool = In(default=False, doc="stamps are wall time, and no two runs are alike")
    frame_skip_count: UInt = In(default=0, doc="deprecated: samples to leave out after each one")
    selected_metadata: Tokens = In(setup=True, doc=f"more fields of a point cloud: {', '.join(_METADATA)}")
    enable_object_id_map: bool = In(default=False, doc="no effect: rays do not tell objects apart")
    object_id_map_topic_name: String = In(default="object_id_map")
    no_return: Token = In(
        default="inf", tokens=("inf", "max", "minus_one"), extension=True, doc="what a beam reports that hits nothing"
    )

    lidar: Lidar = State()
    clock: Clock = State()
    publisher: Publisher = State()

    def setup(self, context: Context) -> None:
        """Bind the sensor and open the topic."""
        unknown = [name for name in self.selected_metadata if name not in _METADATA]
        if unknown:
            raise ContextError(f"selectedMetadata {unknown[0]!r} is not available", unknown[0], listing(_METADATA))
        if self.enable_object_id_map:
            context.log("warning", "enableObjectIdMap has no effect: rays do not tell objects apart")
        self.clock = context.clock
        self.lidar = context.lidar(self.render_product_path)
        self.publisher = context.publisher(
            "sensor_msgs/msg/LaserScan" if self.type_in == "laser_scan" else "sensor_msgs/msg/PointCloud2",
            self.topic_name,
            namespace=self.node_namespace,
            namespace_from=self.lidar.prim_path,
            qos_profile=self.qos_profile,
            queue_size=self.queue_size,
            ros_context=self.context,
            rate=self.lidar.rate / (self.frame_skip_count + 1),
            frame_id=self.frame_id,
        )

    def compute(self) -> None:
        """Begin, or end, to publish."""
        self.active = self.enabled

    def update(self) -> None:
        """Publish the sample of this tick, if there is one and anybody wants it."""
        if not (self.lidar.due and self.publisher.wanted):
            return
        scan = self.lidar.scan()
        if scan.index % (self.frame_skip_count + 1) == 0:
            self.publisher.publish(self.laser_scan(scan) if self.type_in == "laser_scan" else self.point_cloud(scan))

    def stamp(self, scan: Scan) -> float:
        """Time of a sample, s."""
        if self.use_system_time:
            return self.clock.wall_time
        since_play = self.clock.monotonic_time - self.clock.time
        return scan.time if self.reset_simulation_time_on_stop else scan.time + since_play

    def laser_scan(self, scan: Scan) -> messages.LaserScan:
        """One range a beam; all beams are of one instant, so time_increment is 0."""
        first, last, increment = self.lidar.angles
        near, far = self.lidar.ranges
        return messages.LaserScan(
            messages.header(self.stamp(scan), self.frame_id),
            first,
            last,
            increment,
            0.0,
            1.0 / self.lidar.rate,
            near,
            far,
            self.reported(scan.ranges, far),
            scan.intensities,
        )

    def reported(self, ranges: NDArray[np.float32], far: float) -> NDArray[np.float32]:
        """Ranges with misses as `noReturn` says."""
        if self.no_return == "inf":
            return ranges
        return np.where(np.isinf(ranges), np.float32(far if self.no_return == "max" else -1.0), ranges)

    def point_cloud(self, scan: Scan) -> messages.PointCloud2:
        """The points that were hit, in the sensor's frame."""
        hit = np.flatnonzero(np.isfinite(scan.ranges))
        names = [name for name in _METADATA if name in self.selected_metadata]
        layout = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), *(field for name in names for field in _METADATA[name])]
        points = np.zeros(len(hit), dtype=layout)
        positions = self.lidar.directions[hit] * scan.ranges[hit, None]
        points["x"], points["y"], points["z"] = positions.T
        if "Intensity" in names:
            points["intensity"] = scan.intensities[hit]
        if "Timestamp" in names:
            nanoseconds = int(scan.time * 1e9)
            points["timestamp"] = (nanoseconds & 0xFFFFFFFF, nanoseconds >> 32)
        if "EmitterId" in names:
            points["emitter_id"] = hit
        if "ChannelId" in names:
            points["channel_id"] = hit
        fields = []
        for name in points.dtype.names or ():
            kind, offset = points.dtype[name], points.dtype.fields[name][1]  # type: ignore[index]
            code = _FLOAT32 if kind.base.kind == "f" else _UINT32
            fields.append(messages.PointField(name, offset, code, int(np.prod(kind.shape, dtype=int))))
        data = points.view(np.uint8).reshape(-1) if len(points) else np.zeros(0, np.uint8)
        size = points.dtype.itemsize
        header = messages.header(self.stamp(scan), self.frame_id)
        return messages.PointCloud2(header, 1, len(points), fields, False, size, size * len(points), data, True)
