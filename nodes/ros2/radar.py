"""The helper node that publishes the detections of a radar while the simulation plays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.radar import Detections, Radar
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, In, String
from graphengine.nodes.ros2.helper import SensorHelper
from graphengine.nodes.ros2.point_cloud import point_cloud


class ROS2RtxRadarHelper(SensorHelper, type="isaacsim.ros2.bridge.ROS2RtxRadarHelper"):
    """Publishes the detections of a radar as PointCloud2, from the first execution until stop.

    A point has x, y and z in the radar's frame, and the fields that inputs select, in this order: `intensity` (float32, dB),
    `timestamp` (two uint32, ns, low half first), `radial_velocity_ms` (float32, m/s, positive for objects that move away).

    Isaac Sim's RTX radar traces radio waves against materials; here, rays are cast at the collision geometry, and noise is added.
    Each ray that hits a surface gives one point. The intensity depends only on the distance: it is the received power relative
    to the power from the same target at the radar's maximum range. The radar is a sensor of type `radar` in a robot file.

    If `nodeNamespace` is empty, the topic's namespace comes from `isaac:namespace` of the radar's prim and its ancestors.
    Without subscribers, no rays are cast.
    """

    frame_id: String = In(default="sim_radar", setup=True)
    topic_name: String = In(default="radar_point_cloud", setup=True)
    show_debug_view: bool = In(default=False, doc="no effect: there is no window")
    output_radial_velocity_ms: bool = In(
        default=False, name="outputRadialVelocityMS", doc="add the field `radial_velocity_ms` to each point, m/s"
    )
    output_intensity: bool = In(default=False, doc="add the field `intensity` to each point: its received power, dB")
    output_timestamp: bool = In(default=False, doc="add the field `timestamp` to each point: time of the message, ns")

    radar: Radar = Bound()
    publisher: Publisher = Bound()

    def setup(self, context: Context) -> None:
        """Look up the radar at `renderProductPath` and create the publisher on `topicName`."""
        super().setup(context)
        self.radar = context.device(Radar, self.render_product_path)
        kind = "sensor_msgs/msg/PointCloud2"
        self.publisher = self.open_for(context, self.radar, kind, self.topic_name, frame_id=self.frame_id)

    def update(self) -> None:
        """Publish the sample of this tick, if there is one and the topic has subscribers."""
        if self.radar.due and self.publisher.wanted:
            self.publisher.publish(self.message(self.radar.detections()))

    def message(self, sample: Detections) -> messages.PointCloud2:
        """Return a PointCloud2 with the detections of a sample."""
        time = self.stamp(sample.time)
        known: dict[str, NDArray[np.generic]] = {}
        if self.output_intensity:
            known["Intensity"] = sample.intensities
        if self.output_timestamp:
            known["Timestamp"] = np.full(len(sample.points), int(time * 1e9), "<u8")
        if self.output_radial_velocity_ms:
            known["RadialVelocityMS"] = sample.radial_velocities
        return point_cloud(messages.header(time, self.publisher.claim.frame_id), sample.points, known)
