"""The nearest range of a scan."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import Float, Float2, Floats, In, Node, Out


class NearestRange(Node, type="graphengine.data.NearestRange"):
    """The nearest range of a scan within a sector, and its azimuth.

    The ranges are spread evenly from the first azimuth to the last, as IsaacReadLidarBeams outputs them for one ring.
    """

    ranges: Floats = In(unit="m", doc="ranges from the first azimuth to the last; infinity and NaN are ignored")
    azimuth_range: Float2 = In(default=(-180.0, 180.0), unit="deg", doc="azimuth of the first and the last range")
    sector: Float2 = In(
        default=(-180.0, 180.0), unit="deg", doc="lowest and highest azimuth; 0 is ahead, positive is left"
    )
    distance: Float = Out(default=math.inf, unit="m", doc="nearest range; infinite if the sector has none")
    azimuth: Float = Out(default=0.0, unit="deg", doc="azimuth of the nearest range; 0 if the sector has none")

    def compute(self) -> None:
        """Find the smallest range of the sector."""
        azimuths = np.linspace(*self.azimuth_range, len(self.ranges))
        right, left = self.sector
        seen = np.flatnonzero((right <= azimuths) & (azimuths <= left) & np.isfinite(self.ranges))
        if not len(seen):
            self.distance, self.azimuth = math.inf, 0.0
            return
        nearest = seen[np.argmin(self.ranges[seen])]
        self.distance, self.azimuth = float(self.ranges[nearest]), float(azimuths[nearest])
