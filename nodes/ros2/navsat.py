"""A node that publishes the position fixes of a navsat receiver as sensor_msgs/NavSatFix."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from graphengine.devices.navsat import NavSat
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Bound, Context, In, String, Target
from graphengine.nodes.ros2.publisher import header
from graphengine.nodes.ros2.samples import SamplePublisher

_NO_FIX = -1
_FIXES = {"fix": 0, "sbas_fix": 1, "gbas_fix": 2}
_GPS = 1
"""Service of the fixes, as in sensor_msgs/NavSatStatus."""
_UNKNOWN, _DIAGONAL_KNOWN = 0, 2
"""Types of covariances."""


class NavSatPublisher(SamplePublisher, type="graphengine.ros2.NavSatPublisher"):
    """Publishes each sample of a navsat receiver (GPS) as sensor_msgs/NavSatFix.

    Latitude and longitude are degrees on the WGS84 ellipsoid, and the altitude is the height above it, m. The covariance (m2) has
    the variances of the receiver's noise to the east, to the north and upwards. Without a fix, the status is -1, and the
    coordinates are NaN.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/NavSatFix"

    nav_sat_prim: Target = In(required=True, setup=True, doc="prim of the receiver, which is at its antenna")
    frame_id: String = In(default="sim_navsat", setup=True)
    topic_name: String = In(default="fix", setup=True)

    receiver: NavSat = Bound()

    def setup(self, context: Context) -> None:
        """Look up the receiver at `navSatPrim` and create the publisher on `topicName`."""
        self.receiver = context.device(NavSat, self.nav_sat_prim[0])
        self.publish_samples(context, self.receiver)

    def values(self) -> tuple[Any, ...]:
        """Return the fields of the message with the newest fix."""
        receiver = self.receiver
        reading = receiver.reading()
        head, fixed = header(reading.time, self.publisher.claim.frame_id), not math.isnan(reading.latitude)
        level, height = (noise**2 if fixed else 0.0 for noise in (receiver.horizontal_noise, receiver.vertical_noise))
        fix, known = (_FIXES[receiver.fix], _DIAGONAL_KNOWN) if fixed else (_NO_FIX, _UNKNOWN)
        status = DEFINITIONS.message_class("sensor_msgs/msg/NavSatStatus")(fix, _GPS)
        place = reading.latitude, reading.longitude, reading.altitude
        return head, status, *place, np.diag((level, level, height)).ravel(), known
