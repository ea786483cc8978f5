"""Nodes that output lidar samples as arrays (`isaacsim.sensors.rtx` and `isaacsim.sensors.physx`)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.lidar import Lidar, Scan
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.node.types import Buffer, Float, Float2, Floats, Int, Point3fs, Target, Token, UChars, UInt64


def beams_of_a_ring(lidar: Lidar) -> int:
    """Number of beams in each ring of a lidar."""
    return len(lidar.directions) // len(lidar.elevations)


def level_ring(lidar: Lidar) -> slice:
    """The indices, in a sample, of the ring nearest to the sensor's xy plane."""
    ring, beams = int(np.argmin(np.abs(lidar.elevations))), beams_of_a_ring(lidar)
    return slice(ring * beams, (ring + 1) * beams)


def points_of(lidar: Lidar, scan: Scan, beams: NDArray[np.intp]) -> NDArray[np.float64]:
    """Points hit by the given beams of a sample, in the sensor's frame, m, shape (n, 3)."""
    points: NDArray[np.float64] = lidar.directions[beams] * scan.ranges[beams, None]
    return points


class LidarNode(Node):
    """Base of nodes that fire once for each sample of a lidar; a subclass binds `lidar` and defines `exec_out` and `put_out`."""

    exec_out: ClassVar[ExecOut]

    lidar: Lidar = Bound()
    last: int = State(default=-1)

    def compute(self) -> Fire:
        """Output the sample of this tick and fire, if there is a new one."""
        if not self.lidar.due or self.lidar.index == self.last:
            return None
        scan = self.lidar.scan()
        self.last = scan.index
        self.put_out(scan)
        return self.exec_out

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from a sample."""
        raise NotImplementedError


class BeamsNode(LidarNode):
    """Base of nodes that output ranges and the angles of their beams."""

    horizontal_fov: Float = Out(default=0.0, unit="deg", doc="angle from the first beam to the last")
    horizontal_resolution: Float = Out(default=0.0, unit="deg", doc="angle between two beams")
    depth_range: Float2 = Out(default=(0.0, 0.0), unit="m", doc="smallest and largest range")
    rotation_rate: Float = Out(default=0.0, unit="Hz", doc="samples per second; all beams are cast at one instant")
    linear_depth_data: Floats = Out(unit="m", doc="range of each beam, row by row; infinite without a hit")
    intensities_data: UChars = Out(doc="intensity of each beam, row by row")
    num_cols: Int = Out(default=0, doc="number of beams in a row")
    azimuth_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="azimuth of the first and the last beam")

    def put_out_beams(self, scan: Scan, beams: slice) -> None:
        """Set the outputs from the given beams of a sample."""
        first, last, increment = np.degrees(self.lidar.angles).tolist()
        self.horizontal_fov, self.horizontal_resolution, self.azimuth_range = last - first, increment, (first, last)
        self.depth_range, self.rotation_rate = self.lidar.ranges, self.lidar.rate
        self.num_cols = beams_of_a_ring(self.lidar)
        self.linear_depth_data = scan.ranges[beams]
        self.intensities_data = np.rint(scan.intensities[beams]).astype(np.uint8)


class IsaacComputeRTXLidarFlatScan(BeamsNode, type="isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan", gated=True):
    """Reads the ring nearest to a lidar's xy plane; fires once for each sample.

    The render product determines the lidar. Inputs for buffers of the reference's renderer have no effect.
    """

    exec_in = ExecIn(name="exec")
    render_product_path: Token = In(
        required=True, setup=True, doc="path from IsaacCreateRenderProduct, or a lidar's prim path"
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
    exec_out = ExecOut(name="exec", doc="fires for each sample")

    level: slice = Bound()

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.render_product_path)
        self.level = level_ring(self.lidar)

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from the ring."""
        self.put_out_beams(scan, self.level)


class IsaacReadLidarBeams(BeamsNode, type="isaacsim.sensors.physx.IsaacReadLidarBeams", gated=True):
    """Reads the ranges of all rings of a lidar, one ring per row; fires once for each sample."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True)
    vertical_fov: Float = Out(default=0.0, unit="deg", doc="angle from the lowest ring to the highest")
    vertical_resolution: Float = Out(default=0.0, unit="deg", doc="mean angle between two rings")
    beam_time_data: Floats = Out(unit="s", doc="time of each beam after the sample's time; always 0")
    num_rows: Int = Out(default=0, doc="number of rings")
    zenith_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="elevation of the lowest and the highest ring")
    exec_out = ExecOut(doc="fires for each sample")

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from all rings."""
        self.put_out_beams(scan, slice(None))
        rings = np.degrees(self.lidar.elevations)
        low, high = float(rings.min()), float(rings.max())
        self.num_rows, self.zenith_range, self.vertical_fov = len(rings), (low, high), high - low
        self.vertical_resolution = (high - low) / (len(rings) - 1) if len(rings) > 1 else 0.0
        self.beam_time_data = np.zeros(len(scan.ranges), np.float32)


class IsaacReadLidarPointCloud(LidarNode, type="isaacsim.sensors.physx.IsaacReadLidarPointCloud", gated=True):
    """Reads the points hit by a lidar, in the sensor's frame; fires once for each sample."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True)
    exec_out = ExecOut(doc="fires for each sample")
    data: Point3fs = Out(unit="m", doc="hit points of all rings")

    def setup(self, context: Context) -> None:
        """Bind the lidar."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Set the output to the points."""
        self.data = points_of(self.lidar, scan, np.flatnonzero(np.isfinite(scan.ranges))).astype(np.float32)
