"""Nodes that output lidar samples as arrays (`isaacsim.sensors.rtx` and `isaacsim.sensors.physx`)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphengine.devices.lidar import Lidar, Scan
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.node.types import Buffer, Float, Float2, Floats, Int, Point3fs, Target, Token, UChars, UInt64
from graphengine.nodes.point_metadata import metadata_ports


def beams_of_a_ring(lidar: Lidar) -> int:
    """Return the number of beams in each ring of a lidar."""
    return len(lidar.directions) // len(lidar.elevations)


def level_ring(lidar: Lidar) -> slice:
    """Return the slice that selects, from the arrays of a sample, the beams of the ring nearest to the lidar's xy plane."""
    ring, beams = int(np.argmin(np.abs(lidar.elevations))), beams_of_a_ring(lidar)
    return slice(ring * beams, (ring + 1) * beams)


class LidarNode(Node):
    """Base of nodes that fire once per lidar sample. A subclass sets `lidar` in `setup`, and defines `exec_out` and `put_out`."""

    exec_out: ClassVar[ExecOut]

    lidar: Lidar = Bound()
    last: int = State(default=-1)

    def compute(self) -> Fire:
        """Set the outputs and fire if the lidar has a new sample in this tick."""
        if not self.lidar.due or self.lidar.index == self.last:
            return None
        scan = self.lidar.scan()
        self.last = scan.index
        self.put_out(scan)
        return self.exec_out

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from a lidar sample."""
        raise NotImplementedError


class BeamsNode(LidarNode):
    """Base of nodes that output the ranges, intensities and angles of lidar beams."""

    horizontal_fov: Float = Out(default=0.0, unit="deg", doc="angle between the first beam and the last beam of a ring")
    horizontal_resolution: Float = Out(default=0.0, unit="deg", doc="angle between neighbouring beams of a ring")
    depth_range: Float2 = Out(default=(0.0, 0.0), unit="m", doc="[shortest range, longest range] of the lidar")
    rotation_rate: Float = Out(default=0.0, unit="Hz", doc="samples per second; all beams are cast at once")
    linear_depth_data: Floats = Out(unit="m", doc="range of each beam, ring by ring; infinite if the beam hits nothing")
    intensities_data: UChars = Out(doc="intensity of each beam, ring by ring, 0 to 255")
    num_cols: Int = Out(default=0, doc="number of beams in a ring")
    azimuth_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="azimuths of a ring's first and last beam")

    def put_out_beams(self, scan: Scan, beams: slice) -> None:
        """Set the outputs of this class; `beams` selects the beams of the sample to output."""
        first, last, increment = np.degrees(self.lidar.angles).tolist()
        self.horizontal_fov, self.horizontal_resolution, self.azimuth_range = last - first, increment, (first, last)
        self.depth_range, self.rotation_rate = self.lidar.ranges, self.lidar.rate
        self.num_cols = beams_of_a_ring(self.lidar)
        self.linear_depth_data = scan.ranges[beams]
        self.intensities_data = np.rint(scan.intensities[beams]).astype(np.uint8)


_NO_EFFECT = "no effect; in Isaac Sim it describes a buffer of the RTX renderer"
_UNUSED = dict.fromkeys(("azimuth", "distance", "intensity"), ("", _NO_EFFECT))


class IsaacComputeRTXLidarFlatScan(BeamsNode, type="isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan", gated=True):
    """Outputs the ranges and intensities of the ring nearest to the lidar's xy plane; fires once per lidar sample.

    `renderProductPath` selects the lidar. The inputs for pointers, sizes and data types (`dataPtr`, `bufferSize`, …) have no
    effect: in Isaac Sim, they describe buffers of the RTX renderer.
    """

    exec_in = ExecIn(name="exec")
    render_product_path: Token = In(
        required=True, setup=True, doc="lidar: path from IsaacCreateRenderProduct, or prim path"
    )
    data_ptr: Buffer = In(default=0, doc=_NO_EFFECT)
    cuda_device_index: Int = In(default=-1, doc=_NO_EFFECT)
    buffer_size: UInt64 = In(default=0, doc=_NO_EFFECT)
    vars().update(metadata_ports(In, _UNUSED, _NO_EFFECT, _NO_EFFECT))
    num_rows: Int = Out(default=1, doc="number of rings that are output; always 1")
    exec_out = ExecOut(name="exec", doc="fires once per lidar sample")

    level: slice = Bound()

    def setup(self, context: Context) -> None:
        """Look up the lidar that `renderProductPath` selects, and its ring nearest to the xy plane."""
        self.lidar = context.device(Lidar, self.render_product_path)
        self.level = level_ring(self.lidar)

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from the ring nearest to the lidar's xy plane."""
        self.put_out_beams(scan, self.level)


class IsaacReadLidarBeams(BeamsNode, type="isaacsim.sensors.physx.IsaacReadLidarBeams", gated=True):
    """Outputs the ranges and intensities of all rings of a lidar, ring by ring; fires once per lidar sample."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True, doc="prim of the lidar")
    vertical_fov: Float = Out(default=0.0, unit="deg", doc="angle between the lowest ring and the highest ring")
    vertical_resolution: Float = Out(default=0.0, unit="deg", doc="mean angle between neighbouring rings")
    beam_time_data: Floats = Out(
        unit="s", doc="time of each beam relative to the time of the sample; always 0, as all beams are cast at once"
    )
    num_rows: Int = Out(default=0, doc="number of rings")
    zenith_range: Float2 = Out(default=(0.0, 0.0), unit="deg", doc="elevations of the lowest and of the highest ring")
    exec_out = ExecOut(doc="fires once per lidar sample")

    def setup(self, context: Context) -> None:
        """Look up the lidar at `lidarPrim` and keep its handle."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Set the outputs from all rings of a lidar sample."""
        self.put_out_beams(scan, slice(None))
        rings = np.degrees(self.lidar.elevations)
        low, high = float(rings.min()), float(rings.max())
        self.num_rows, self.zenith_range, self.vertical_fov = len(rings), (low, high), high - low
        self.vertical_resolution = (high - low) / (len(rings) - 1) if len(rings) > 1 else 0.0
        self.beam_time_data = np.zeros(len(scan.ranges), np.float32)


class IsaacReadLidarPointCloud(LidarNode, type="isaacsim.sensors.physx.IsaacReadLidarPointCloud", gated=True):
    """Outputs the hit points of a lidar in the lidar's frame; fires once per lidar sample."""

    exec_in = ExecIn()
    lidar_prim: Target = In(required=True, setup=True, doc="prim of the lidar")
    exec_out = ExecOut(doc="fires once per lidar sample")
    data: Point3fs = Out(unit="m", doc="hit points in the lidar's frame, ring by ring; beams without a hit are skipped")

    def setup(self, context: Context) -> None:
        """Look up the lidar at `lidarPrim` and keep its handle."""
        self.lidar = context.device(Lidar, self.lidar_prim[0])

    def put_out(self, scan: Scan) -> None:
        """Set `data` to the hit points of a lidar sample."""
        self.data = scan.points_of(np.flatnonzero(np.isfinite(scan.ranges))).astype(np.float32)
