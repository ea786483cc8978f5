"""A node that publishes arrays of ranges and intensities as sensor_msgs/LaserScan."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer, Float, Float2, Floats, In, Int, String, UChars, UInt64
from graphengine.nodes.ros2.publisher import SensorPublisher


class ROS2PublishLaserScan(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishLaserScan"):
    """Publishes a row of ranges as sensor_msgs/LaserScan, with angles and times from the inputs.

    If `rotationRate` is not 0, `scan_time` is 1 / `rotationRate` and `time_increment` is the time between two beams at this
    rate. If `rotationRate` is 0, both times are 0: all beams were fired at one instant.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/LaserScan"

    frame_id: String = In(default="sim_lidar", setup=True)
    topic_name: String = In(default="scan", setup=True)
    data_ptr: Buffer = In(default=0, doc="no effect: Isaac Sim's RTX renderer fills this buffer; use `linearDepthData`")
    buffer_size: UInt64 = In(default=0, doc="no effect: `dataPtr` is not read")
    horizontal_fov: Float = In(
        default=0.0, ge=0.0, le=360.0, unit="deg", doc="horizontal field of view; used for the time between beams"
    )
    horizontal_resolution: Float = In(default=0.0, unit="deg", doc="angle between adjacent beams")
    depth_range: Float2 = In(default=(0.0, 0.0), ge=0.0, unit="m", doc="smallest and largest valid distance")
    rotation_rate: Float = In(
        default=0.0, ge=0.0, unit="Hz", doc="turns of the lidar per second; 0: all beams are fired at one instant"
    )
    linear_depth_data: Floats = In(unit="m", doc="range of each beam; inf for a miss")
    intensities_data: UChars = In(doc="intensity of each beam; if empty, 255 for hits and 0 for misses")
    num_rows: Int = In(ge=1, le=1, unset=True, doc="number of rows of beams; must be 1")
    num_cols: Int = In(ge=1, unset=True, doc="number of beams")
    azimuth_range: Float2 = In(default=(0.0, 0.0), unit="deg", doc="azimuth of the first and the last beam")

    def message(self) -> messages.LaserScan:
        """Return the message with the row of ranges.

        Raises:
            BadValueError: `numRows` is not 1, `numCols` is not the number of ranges, or the number of intensities is wrong.
        """
        if self.num_rows != 1:
            raise BadValueError("numRows", self.num_rows, "1, because a LaserScan is one row of beams")
        beams = len(self.linear_depth_data)
        if not beams or beams != self.num_cols:
            legal = "a non-empty array of ranges and its length"
            raise BadValueError("linearDepthData, numCols", [beams, self.num_cols], legal)
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
        """Return the intensity of each beam, 0 to 255.

        Raises:
            BadValueError: there are intensities, but not one per beam.
        """
        given, ranges = self.intensities_data, self.linear_depth_data
        if not len(given):
            return np.where((ranges > 0.0) & np.isfinite(ranges), np.float32(255), np.float32(0))
        if len(given) != beams:
            raise BadValueError("intensitiesData, linearDepthData", [len(given), beams], "one intensity per beam")
        return given.astype(np.float32)
