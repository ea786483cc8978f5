"""The helper node that publishes a lidar's samples while the simulation plays, and the node that selects metadata of points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.lidar import Lidar, Scan
from graphengine.format.wording import listing
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, ContextError, In, Node, Out, String, Token, Tokens
from graphengine.nodes.lidar import beams_of_a_ring, level_ring
from graphengine.nodes.point_metadata import output_inputs
from graphengine.nodes.ros2.helper import SkippingHelper
from graphengine.nodes.ros2.point_cloud import BUFFERS, FIELDS, point_cloud

_METADATA = ("Intensity", "Timestamp", "EmitterId", "ChannelId", "Ring", "Time")
"""Kinds of point metadata that a simulated lidar provides."""


class ROS2RtxLidarHelper(SkippingHelper, type="isaacsim.ros2.bridge.ROS2RtxLidarHelper"):
    """Publishes samples of a lidar as LaserScan or PointCloud2, from the first execution until stop.

    A LaserScan has one range per beam of the ring nearest to the lidar's xy plane and covers exactly the lidar's field of view.
    A PointCloud2 has the points of all rings. With `selectedMetadata: [Intensity, Ring, Time]`, its points have the layout of
    Velodyne's driver (x, y, z, intensity, ring, time). Lidar SLAM such as LIO-SAM expects this layout. Isaac Sim does
    not have `Ring` and `Time`. `Ring` is the index of the ring, 0 for the lowest one (uint16). `Time` is the time in s since the
    stamp (float32); it is always 0, because all beams of a sample are cast at the same time. Switch off motion correction in SLAM
    software that treats 0 as a missing time.

    If `nodeNamespace` is empty, the topic's namespace comes from `isaac:namespace` of the lidar's prim and its ancestors.
    Without subscribers, no rays are cast.
    """

    frame_id: String = In(default="sim_lidar", setup=True)
    topic_name: String = In(default="scan", setup=True)
    type_in: Token = In(
        default="laser_scan",
        name="type",
        setup=True,
        tokens=("laser_scan", "point_cloud"),
        doc="message to publish: LaserScan or PointCloud2",
    )
    full_scan: bool = In(default=True, doc="deprecated: samples are always full scans")
    show_debug_view: bool = In(default=False, doc="no effect: there is no window")
    selected_metadata: Tokens = In(setup=True, doc=f"further fields of points in a PointCloud2: {', '.join(_METADATA)}")
    enable_object_id_map: bool = In(default=False, doc="no effect: rays do not identify objects")
    object_id_map_topic_name: String = In(default="object_id_map")
    no_return: Token = In(
        default="inf", tokens=("inf", "max", "minus_one"), extension=True, doc="range of a miss: inf, range_max or -1"
    )

    lidar: Lidar = Bound()
    publisher: Publisher = Bound()
    level: slice | None = Bound()

    def setup(self, context: Context) -> None:
        """Look up the lidar at `renderProductPath` and create the publisher on `topicName`."""
        unknown = [name for name in self.selected_metadata if name not in _METADATA]
        if unknown:
            text = f"the metadata {unknown[0]!r} in selectedMetadata is not available"
            raise ContextError(text, unknown[0], listing(_METADATA))
        if self.enable_object_id_map:
            context.log("warning", "enableObjectIdMap has no effect: rays do not identify objects")
        super().setup(context)
        self.lidar = context.device(Lidar, self.render_product_path)
        self.level = level_ring(self.lidar) if len(self.lidar.elevations) > 1 else None
        kind = "sensor_msgs/msg/LaserScan" if self.type_in == "laser_scan" else "sensor_msgs/msg/PointCloud2"
        self.publisher = self.open_for(context, self.lidar, kind, self.topic_name, frame_id=self.frame_id)

    def update(self) -> None:
        """Publish the sample of this tick, if there is one and the topic has subscribers."""
        if not self.lidar.due or self.left_out(self.lidar.index) or not self.publisher.wanted:
            return
        scan = self.lidar.scan()
        self.publisher.publish(self.laser_scan(scan) if self.type_in == "laser_scan" else self.point_cloud(scan))

    def laser_scan(self, scan: Scan) -> messages.LaserScan:
        """Return a LaserScan with one range per beam; `time_increment` is 0, because all beams are cast at once."""
        first, last, increment = self.lidar.angles
        near, far = self.lidar.ranges
        ranges, intensities = scan.ranges, scan.intensities
        if self.level is not None:
            ranges, intensities = ranges[self.level], intensities[self.level]
        return messages.LaserScan(
            messages.header(self.stamp(scan.time), self.publisher.claim.frame_id),
            first,
            last,
            increment,
            0.0,
            1.0 / self.lidar.rate,
            near,
            far,
            self.reported(ranges, far),
            intensities,
        )

    def reported(self, ranges: NDArray[np.float32], far: float) -> NDArray[np.float32]:
        """Return the ranges to publish: a beam without a hit gets the range that `noReturn` selects.

        Args:
            ranges: range of each beam, m; inf for a beam without a hit.
            far: maximum range of the lidar, m.
        """
        if self.no_return == "inf":
            return ranges
        return np.where(np.isinf(ranges), np.float32(far if self.no_return == "max" else -1.0), ranges)

    def point_cloud(self, scan: Scan) -> messages.PointCloud2:
        """Return a PointCloud2 with the hit points in the lidar's frame; all points have the same time."""
        time, hit = self.stamp(scan.time), np.flatnonzero(np.isfinite(scan.ranges))
        make: dict[str, Callable[[], NDArray[Any]]] = {
            "Intensity": lambda: scan.intensities[hit],
            "Timestamp": lambda: np.full(len(hit), int(time * 1e9), "<u8"),
            "EmitterId": lambda: hit.astype("<u4"),
            "ChannelId": lambda: (hit // beams_of_a_ring(self.lidar)).astype("<u4"),
            "Ring": lambda: (hit // beams_of_a_ring(self.lidar)).astype("<u2"),
            "Time": lambda: np.zeros(len(hit), "<f4"),
        }
        header = messages.header(time, self.publisher.claim.frame_id)
        return point_cloud(header, scan.points_of(hit), {name: make[name]() for name in self.selected_metadata})


class ROS2RtxLidarPointCloudConfig(Node, type="isaacsim.ros2.bridge.ROS2RtxLidarPointCloudConfig"):
    """Selects the metadata of a lidar's points; wire the output to `selectedMetadata` of a ROS2RtxLidarHelper."""

    vars().update(output_inputs(name for name in BUFFERS if name != "radialVelocityMS"))
    output_ring: bool = In(default=False, extension=True)
    output_time: bool = In(default=False, extension=True)
    selected_metadata: Tokens = Out(doc="names of the selected metadata, in the order in which they follow x, y and z")

    def compute(self) -> None:
        """Output the names of the metadata whose inputs are true."""
        chosen = {port.name for port in type(self).fields.values() if getattr(self, port.field) is True}
        self.selected_metadata = tuple(name for name in FIELDS if f"output{name}" in chosen)
