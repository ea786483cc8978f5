"""A lidar's samples as arrays (`isaacsim.sensors.rtx` and `isaacsim.sensors.physx`)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.lidar import Lidar, Scan
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.node.types import Buffer, Float, Float2, Floats, Int, Point3fs, Target, Token, UChars, UInt64


def beams_of_a_ring(lidar: Lidar) -> int:
    """How many beams each ring of a lidar has."""
    return len(lidar.directions) // len(lidar.elevations)


def level_ring(lidar: Lidar) -> slice:
    """Where a sample holds the ring that is nearest to the sensor's xy plane."""
    ring, beams = int(np.argmin(np.abs(lidar.elevations))), beams_of_a_ring(lidar)
    return slice(ring * beams, (ring + 1) * beams)


def points_of(lidar: Lidar, scan: Scan, beams: NDArray[np.intp]) -> NDArray[np.float64]:
    """Where some beams of a sample hit, in the sensor's frame, m, shape (n, 3)."""
    points: NDArray[np.float64] = lidar.directions[beams] * scan.ranges[beams, None]
    return points


class LidarNode(Node):
    """A node that fires once for each sample of a lidar; a subclass binds `lidar`, has an `exec_out` and gives `put_out`."""

    exec_out: ClassVar[ExecOut]

    lidar: Lidar = Bound()
    last: int = State(default=-1)

    def compute(self) -> Fire:
        """Hand on the sample of this tick, if there is one and it was not yet."""
        if not self.lidar.due or self.lidar.index == self.last:
            return None
        scan = self.lidar.scan()
        self.last = scan.index
        self.put_out(scan)
        return self.exec_out

    def put_out(self, scan: Scan) -> None:
        """Hand on a sample."""
        raise NotImplementedError


class BeamsNode(LidarNode):
    """A node that puts out ranges, and the angles they were taken at."""

    horizontal_fov: Float = Out(default=0.0, unit="deg", doc="from the first beam to the last")
    horizontal_resolution: Float = Out(default=0.0, unit="deg", doc="between two beams")
    depth_range: Float2 = Out(default=(0.0, 0.0), unit="m", doc="nearest and farthest distance reported")
    rotation_rate: Float = Out(default=0.0, unit="Hz", doc="samples a second; all beams of one are of one instant")
    linear_depth_data: Floats = Out(unit="m", doc="row after row, one range a beam, inf where nothing was hit")
    intensities_data: UChars = Out(doc="one a beam")
    num_cols: Int = Out(default=0, doc="beams of a row")
    azimuth_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="of the first and the last beam")

    def put_out_beams(self, scan: Scan, beams: slice) -> None:
        """Hand on some rows of a sample."""
        first, last, increment = np.degrees(self.lidar.angles).tolist()
        self.horizontal_fov, self.horizontal_resolution, self.azimuth_range = last - first, increment, (first, last)
        self.depth_range, self.rotation_rate = self.lidar.ranges, self.lidar.rate
        self.num_cols = beams_of_a_ring(self.lidar)
        self.linear_depth_data = scan.ranges[beams]
        self.intensities_data = np.rint(scan.intensities[beams]).astype(np.uint8)


class IsaacComputeRTXLidarFlatScan(BeamsNode, type="isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan", gated=True):
    """Ranges of the ring nearest to a lidar's plane; fires once for each sample.

    They come from the lidar behind the render product: buffers of the reference's renderer have no effect.
    """

    exec_in = ExecIn(name="exec")
    render_product_path: Token = In(
        required=True, setup=True, doc="of IsaacCreateRenderProduct, or a lidar's prim path"
    )
    data_ptr: Buffer = In(default=0)
    cuda_device_index: Int = In(default=-1)
    buffer_size: UInt64 = In(default=0)
    azimuth_ptr: Buffer = In(default=0)
    azimuth_data_type: Float = In(default=4.0)
    azimuth_buffer_size: UInt64 = In(default=0)
    distance_ptr: Buffer = In(default=0)
    distance_data_type: Float = In(default=4.0)
    distance_buffer_size: UInt64 = In(default=0)
    intensity_ptr: Buffer = In(default=0)
    intensity_data_type: Float = In(default=0.0)
    intensity_buffer_size: UInt64 = In(default=0)
    num_rows: Int = Out(default=1)
    exec_out = ExecOut(name="exec", doc="fires on a sample")

    level: slice = Bound()

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.render_product_path)
        self.level = level_ring(self.lidar)

    def put_out(self, scan: Scan) -> None:
        """Hand on the ring."""
        self.put_out_beams(scan, self.level)


class IsaacReadLidarBeams(BeamsNode, type="isaacsim.sensors.physx.IsaacReadLidarBeams", gated=True):
    """Ranges of all rings of a lidar, one ring a row; fires once for each sample. All beams are of one instant."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True)
    vertical_fov: Float = Out(default=0.0, unit="deg", doc="from the lowest ring to the highest")
    vertical_resolution: Float = Out(default=0.0, unit="deg", doc="between two rings, on average")
    beam_time_data: Floats = Out(unit="s", doc="since the sample's time, one a beam")
    num_rows: Int = Out(default=0, doc="rings")
    zenith_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="of the lowest and the highest ring")
    exec_out = ExecOut(doc="fires on a sample")

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Hand on all rings."""
        self.put_out_beams(scan, slice(None))
        rings = np.degrees(self.lidar.elevations)
        low, high = float(rings.min()), float(rings.max())
        self.num_rows, self.zenith_range, self.vertical_fov = len(rings), (low, high), high - low
        self.vertical_resolution = (high - low) / (len(rings) - 1) if len(rings) > 1 else 0.0
        self.beam_time_data = np.zeros(len(scan.ranges), np.float32)


class IsaacReadLidarPointCloud(LidarNode, type="isaacsim.sensors.physx.IsaacReadLidarPointCloud", gated=True):
    """Points that a lidar hit, in its own frame; fires once for each sample."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True)
    exec_out = ExecOut(doc="fires on a sample")
    data: Point3fs = Out(unit="m", doc="points of all rings")

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Hand on the points."""
        self.data = points_of(self.lidar, scan, np.flatnonzero(np.isfinite(scan.ranges))).astype(np.float32)
