"""A node that finds the nearest range in a sector of a lidar scan."""

from __future__ import annotations

import math

import numpy as np

from graphengine.compiler.lint_registry import LintContext, lint
from graphengine.node import Float, Float2, Floats, In, Node, Out
from graphengine.nodes.known_inputs import known_inputs


class NearestRange(Node, type="graphengine.data.NearestRange"):
    """Finds the nearest range in a sector of a lidar scan.

    The beams must be evenly spaced from the first to the last azimuth, as in one ring of a scan from IsaacReadLidarBeams. Before
    the first scan, `ranges` is empty and the distance is infinite.
    """

    ranges: Floats = In(unit="m", doc="measured range of each beam, in order of azimuth; infinity and NaN are ignored")
    azimuth_range: Float2 = In(default=(-180.0, 180.0), unit="deg", doc="azimuths of the first and the last beam")
    sector: Float2 = In(default=(-180.0, 180.0), unit="deg", doc="azimuths to search, [right, left]; 0 is ahead")
    distance: Float = Out(default=math.inf, unit="m", doc="nearest range in the sector; infinite if there is none")
    azimuth: Float = Out(default=0.0, unit="deg", doc="azimuth of the nearest range; 0 if there is none")

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


@lint("W216")
def lint_sectors(context: LintContext) -> None:
    """Warn about sectors that contain no azimuth of a beam, and about angles that seem to be in radians."""
    for inputs, node in known_inputs(context, NearestRange):
        known = [name for name in ("sector", "azimuth_range") if inputs.value(name) is not None]
        radians = [name for name in known if _seem_radians(*inputs.value(name))]
        for name in radians:
            low, high = inputs.value(name)
            degrees = f"[{math.degrees(low):.3g}, {math.degrees(high):.3g}]"
            port = inputs.instance.cls.fields[name].name
            message = f"{port} is in degrees: [{low:g}, {high:g}] is {abs(high - low):.3g} deg wide"
            inputs.warn_of_value(name, message, f"if the numbers are in radians, write {degrees}")
        if radians or "sector" not in known:
            continue
        (right, left), ends = node.sector, node.azimuth_range
        if right > left:
            message = f"sector is empty, because {right:g} is above {left:g}: no range is ever found"
            inputs.warn_of_value("sector", message, f"write [{left:g}, {right:g}]; for a sector behind, use two nodes")
        elif "azimuth_range" in known and (left < min(ends) or right > max(ends)):
            message = f"sector [{right:g}, {left:g}] contains no beam: no range is ever found"
            remedy = f"the beams are from {min(ends):g} to {max(ends):g} deg (azimuthRange)"
            inputs.warn_of_value("sector", message, remedy)


def _seem_radians(low: float, high: float) -> bool:
    """Return whether two angles are probably in radians: both are within half a turn, and one is not a whole number."""
    return max(abs(low), abs(high)) <= 3.15 and not (float(low).is_integer() and float(high).is_integer())
