"""A node that finds the nearest range in a sector of a lidar scan."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import Float, Float2, Floats, In, Node, Out


class NearestRange(Node, type="graphengine.data.NearestRange"):
    """Finds the nearest range in a sector of a lidar scan.

    The beams must be evenly spaced from the first to the last azimuth, as in one ring of a scan from IsaacReadLidarBeams. Before
    the first scan, `ranges` is empty and the distance is infinite, as if nothing were in range.
    """

    ranges: Floats = In(unit="m", doc="measured range of each beam, in order of azimuth; infinity and NaN are ignored")
    azimuth_range: Float2 = In(default=(-180.0, 180.0), unit="deg", doc="azimuths of the first and the last beam")
    sector: Float2 = In(
        default=(-180.0, 180.0),
        unit="deg",
        doc="lowest and highest azimuth to search; 0 is ahead, positive is left",
    )
    distance: Float = Out(
        default=math.inf, unit="m", doc="nearest range in the sector; infinite if there is no finite range"
    )
    azimuth: Float = Out(default=0.0, unit="deg", doc="azimuth of the nearest range; 0 if there is no finite range")

    def compute(self) -> None:
        """Set the outputs to the smallest finite range in the sector and to its azimuth."""
        azimuths = np.linspace(*self.azimuth_range, len(self.ranges))
        right, left = self.sector
        seen = np.flatnonzero((right <= azimuths) & (azimuths <= left) & np.isfinite(self.ranges))
        if not len(seen):
            self.distance, self.azimuth = math.inf, 0.0
            return
        nearest = seen[np.argmin(self.ranges[seen])]
        self.distance, self.azimuth = float(self.ranges[nearest]), float(azimuths[nearest])
