"""LaserScan from arrays: one row of ranges."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer, Float, Float2, Floats, In, Int, String, UChars, UInt64
from graphengine.nodes.ros2.publisher import SensorPublisher


class ROS2PublishLaserScan(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishLaserScan"):
    """Publishes a row of ranges as sensor_msgs/LaserScan, with the angles and times that the ports say.

    Beams count as fired one after another in a turn of 1 / rotationRate. What is cast here is of one instant: without
    rotationRate, scan_time and time_increment are 0.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/LaserScan"

    frame_id: String = In(default="sim_lidar", setup=True)
    topic_name: String = In(default="scan", setup=True)
    data_ptr: Buffer = In(default=0, doc="no effect: a buffer of the reference's renderer; wire linearDepthData")
    buffer_size: UInt64 = In(default=0)
    horizontal_fov: Float = In(default=0.0, unit="deg", doc="from the first beam to the last")
    horizontal_resolution: Float = In(default=0.0, unit="deg", doc="between two beams")
    depth_range: Float2 = In(default=(0.0, 0.0), unit="m", doc="nearest and farthest distance that counts")
    rotation_rate: Float = In(default=0.0, unit="Hz", doc="turns a second; 0 for beams of one instant")
    linear_depth_data: Floats = In(unit="m", doc="one range a beam, inf where nothing was hit")
    intensities_data: UChars = In(doc="one a beam; empty for 255 where something was hit, else 0")
    num_rows: Int = In(default=0, doc="has to be 1")
    num_cols: Int = In(default=0, doc="beams")
    azimuth_range: Float2 = In(default=(0.0, 0.0), unit="deg", doc="of the first and the last beam")

    def message(self) -> messages.LaserScan:
        """The row.

        Raises:
            BadValueError: the arrays are not those of one row.
        """
        if self.num_rows != 1:
            raise BadValueError("numRows", self.num_rows, "1, as a LaserScan is one row of beams")
        beams = len(self.linear_depth_data)
        if not beams or beams != self.num_cols:
            raise BadValueError("linearDepthData, numCols", [beams, self.num_cols], "as many, and not none")
        turn = 1.0 / self.rotation_rate if self.rotation_rate else 0.0
        near, far = self.depth_range
        first, last = self.azimuth_range
        return messages.LaserScan(
            self.header(),
            math.radians(first),
            math.radians(last),
            math.radians(self.horizontal_resolution),
            self.horizontal_fov / 360.0 * turn / beams,
            turn,
            near,
            far,
            self.linear_depth_data,
            self.intensities(beams),
        )

    def intensities(self, beams: int) -> NDArray[np.float32]:
        """One a beam, 0 to 255.

        Raises:
            BadValueError: there are others than one a beam.
        """
        given, ranges = self.intensities_data, self.linear_depth_data
        if not len(given):
            return np.where((ranges > 0.0) & np.isfinite(ranges), np.float32(255), np.float32(0))
        if len(given) != beams:
            raise BadValueError("intensitiesData, linearDepthData", [len(given), beams], "one a beam")
        return given.astype(np.float32)
