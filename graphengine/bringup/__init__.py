"""Brings robots up for Nav2: imports descriptions as robot files, calibrates robots, makes maps, writes Nav2's files.

After `from graphengine import bringup`, call the functions as in `bringup.occupancy_map(scene)`.
"""

from __future__ import annotations

from graphengine.bringup.calibration.figures import Calibration
from graphengine.bringup.scenes import calibrate, localizability, occupancy_map

__all__ = ["occupancy_map", "localizability", "calibrate", "Calibration"]
