"""Raycast sensors (`isaacsim.sensors.physics`) and light beams (`isaacsim.sensors.physx`)."""

from __future__ import annotations

import numpy as np

from graphengine.devices.light_beam import LightBeam
from graphengine.devices.raycast import RaycastSensor
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out
from graphengine.node.types import Bools, Float, Floats, Int, Point3fs, Target, Tokens, UInt


class IsaacReadRaycastSensor(Node, type="isaacsim.sensors.physics.IsaacReadRaycastSensor"):
    """Casts the rays of a raycast sensor and outputs their hits; fires at every execution.

    Rays pass through the sensor's own robot. All are cast at the time of the execution: `rayTimeOffsets` of Isaac Sim's prim
    is not available. `hitPrimPaths` contains paths of bodies; it is empty for geometry of the world that belongs to no body.
    """

    exec_in = ExecIn()
    raycast_sensor_prim: Target = In(required=True, setup=True, doc="prim of the raycast sensor")
    exec_out = ExecOut()
    sensor_time: Float = Out(default=0.0, unit="s", doc="simulation time of the reading")
    depths: Floats = Out(
        unit="m", doc="distance from each ray's origin to its hit; the sensor's range if there is no hit"
    )
    hit_positions: Floats = Out(
        unit="m",
        doc="x, y, z of all hits in one array, in the sensor's or world frame (`output_frame` of the sensor); 0 without a hit",
    )
    hit_normals: Floats = Out(
        doc="x, y, z of all surface normals in one array, in the frame of `hitPositions`; 0 if there is no hit"
    )
    hit_prim_paths: Tokens = Out(
        doc="path of the body that each ray hits, empty if there is no hit; an empty array if the sensor does not report paths"
    )
    num_rays: UInt = Out(default=0, doc="number of rays")
    beam_origins: Point3fs = Out(unit="m", doc="origin of each ray in the world frame")
    beam_end_points: Point3fs = Out(unit="m", doc="end of each ray in the world frame: its hit, or the sensor's range")

    sensor: RaycastSensor = Bound()

    def setup(self, context: Context) -> None:
        """Bind the sensor."""
        self.sensor = context.device(RaycastSensor, self.raycast_sensor_prim[0])

    def compute(self) -> None:
        """Cast the rays."""
        reading = self.sensor.reading()
        self.sensor_time, self.num_rays, self.hit_prim_paths = reading.time, len(reading.depths), reading.hit_prims
        self.depths = reading.depths.astype(np.float32)
        self.hit_positions = reading.hit_positions.astype(np.float32).ravel()
        self.hit_normals = reading.hit_normals.astype(np.float32).ravel()
        self.beam_origins, self.beam_end_points = reading.origins.astype(np.float32), reading.ends.astype(np.float32)


class IsaacReadLightBeam(Node, type="isaacsim.sensors.physx.IsaacReadLightBeam"):
    """Casts the beams of a light beam sensor and outputs which beams are broken; fires at every execution.

    Beams pass through the sensor's own robot and end at the distance `max_range` from the sensor; in Isaac Sim, they are longer
    by `min_range`.
    """

    exec_in = ExecIn()
    lightbeam_prim: Target = In(required=True, setup=True, doc="prim of the light beam sensor")
    exec_out = ExecOut()
    num_rays: Int = Out(default=0, doc="number of beams")
    beam_hit_data: Bools = Out(doc="whether each beam is broken")
    linear_depth_data: Floats = Out(
        unit="m", doc="distance from the sensor to each hit along the beam; the sensor's range if there is no hit"
    )
    hit_pos_data: Point3fs = Out(unit="m", doc="end of each beam in the sensor's frame: its hit, or the sensor's range")
    beam_origins: Point3fs = Out(unit="m", doc="start of each beam in the world frame")
    beam_end_points: Point3fs = Out(unit="m", doc="end of each beam in the world frame: its hit, or the sensor's range")

    sensor: LightBeam = Bound()

    def setup(self, context: Context) -> None:
        """Bind the sensor."""
        self.sensor = context.device(LightBeam, self.lightbeam_prim[0])

    def compute(self) -> None:
        """Cast the beams."""
        reading = self.sensor.reading()
        self.num_rays, self.beam_hit_data = len(reading.hits), reading.hits
        self.linear_depth_data = reading.depths.astype(np.float32)
        self.hit_pos_data = reading.hit_positions.astype(np.float32)
        self.beam_origins, self.beam_end_points = reading.origins.astype(np.float32), reading.ends.astype(np.float32)
