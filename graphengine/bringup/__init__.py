"""Brings robots up for Nav2: imports descriptions as robot files, calibrates robots, makes maps, writes Nav2's files.

After `import graphengine as ge`, call the functions as in `ge.bringup.occupancy_map(scene)`.
"""

from __future__ import annotations

from graphengine.bringup.scenes import calibrate, localizability, occupancy_map

__all__ = ["occupancy_map", "localizability", "calibrate"]
