"""Nodes that read raycast sensors (`isaacsim.sensors.physics`) and light beam sensors (`isaacsim.sensors.physx`)."""

from __future__ import annotations

import numpy as np

from graphengine.devices.light_beam import LightBeam
from graphengine.devices.raycast import RaycastSensor
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out
from graphengine.node.types import Bools, Float, Floats, Int, Point3fs, Target, Tokens, UInt


class IsaacReadRaycastSensor(Node, type="isaacsim.sensors.physics.IsaacReadRaycastSensor"):
    """Casts the rays of a raycast sensor and outputs their hits; fires at every execution.

    All rays are cast at the time of the execution; Isaac Sim's attribute `rayTimeOffsets` is not available. If a ray hits
    geometry of the world that belongs to no body, the path in `hitPrimPaths` is empty.
    """

    exec_in = ExecIn()
    raycast_sensor_prim: Target = In(required=True, setup=True, doc="prim of the raycast sensor")
    exec_out = ExecOut()
    sensor_time: Float = Out(default=0.0, unit="s", doc="simulation time of the reading")
    depths: Floats = Out(unit="m", doc="distance from each origin to the hit; `max_range` without a hit")
    hit_positions: Floats = Out(
        unit="m",
        doc="x, y, z of all hits in one array, 0 for rays without a hit; `output_frame` of the sensor selects the sensor's "
        "frame or the world frame",
    )
    hit_normals: Floats = Out(
        doc="x, y, z of the surface normals at all hits in one array, in the frame of `hitPositions`; 0 for rays without a hit"
    )
    hit_prim_paths: Tokens = Out(
        doc="for each ray, path of the body that it hits, empty if there is no hit; no elements if the sensor does not report "
        "paths"
    )
    num_rays: UInt = Out(default=0, doc="number of rays")
    beam_origins: Point3fs = Out(unit="m", doc="origin of each ray in the world frame")
    beam_end_points: Point3fs = Out(unit="m", doc="end of each ray in the world frame: hit, or point at `max_range`")

    sensor: RaycastSensor = Bound()

    def setup(self, context: Context) -> None:
        """Look up the raycast sensor at `raycastSensorPrim` and keep its handle."""
        self.sensor = context.device(RaycastSensor, self.raycast_sensor_prim[0])

    def compute(self) -> None:
        """Cast the rays and output their hits."""
        reading = self.sensor.reading()
        self.sensor_time, self.num_rays, self.hit_prim_paths = reading.time, len(reading.depths), reading.hit_prims
        self.depths = reading.depths.astype(np.float32)
        self.hit_positions = reading.hit_positions.astype(np.float32).ravel()
        self.hit_normals = reading.hit_normals.astype(np.float32).ravel()
        self.beam_origins, self.beam_end_points = reading.origins.astype(np.float32), reading.ends.astype(np.float32)


class IsaacReadLightBeam(Node, type="isaacsim.sensors.physx.IsaacReadLightBeam"):
    """Casts the beams of a light beam sensor and outputs which beams are broken; fires at every execution.

    A beam that is not broken ends at the distance `max_range` from its origin; in Isaac Sim, at `max_range` + `min_range`.
    """

    exec_in = ExecIn()
    lightbeam_prim: Target = In(required=True, setup=True, doc="prim of the light beam sensor")
    exec_out = ExecOut()
    num_rays: Int = Out(default=0, doc="number of beams")
    beam_hit_data: Bools = Out(doc="whether each beam is broken")
    linear_depth_data: Floats = Out(unit="m", doc="distance from each origin to the hit; `max_range` without a hit")
    hit_pos_data: Point3fs = Out(unit="m", doc="end of each beam in the sensor's frame: hit, or point at `max_range`")
    beam_origins: Point3fs = Out(unit="m", doc="start of each beam in the world frame")
    beam_end_points: Point3fs = Out(unit="m", doc="end of each beam in the world frame: hit, or point at `max_range`")

    sensor: LightBeam = Bound()

    def setup(self, context: Context) -> None:
        """Look up the light beam sensor at `lightbeamPrim` and keep its handle."""
        self.sensor = context.device(LightBeam, self.lightbeam_prim[0])

    def compute(self) -> None:
        """Cast the beams and output their hits."""
        reading = self.sensor.reading()
        self.num_rays, self.beam_hit_data = len(reading.hits), reading.hits
        self.linear_depth_data = reading.depths.astype(np.float32)
        self.hit_pos_data = reading.hit_positions.astype(np.float32)
        self.beam_origins, self.beam_end_points = reading.origins.astype(np.float32), reading.ends.astype(np.float32)
