"""Finds the sensors of a robot by the names that users give them."""

from __future__ import annotations

from graphengine.devices.stage import Prim, Stage
from graphengine.format.kinds import DEVICES


def sensors_of(stage: Stage, robot: Prim) -> dict[str, Prim]:
    """Return a dict from the names of a robot's sensors to their prims, in the order of the robot file."""
    kinds = {kind for kind, device in DEVICES.all.items() if device.sample is not None}
    sensors: dict[str, Prim] = {}
    for mount, path in robot.facts["mounts"].items():
        prims = [prim for prim in stage.find(path).descendants() if prim.kind in kinds] if path else []
        for prim in prims:
            sensors[mount if len(prims) == 1 else f"{mount}{prim.path.removeprefix(path)}"] = prim
    return sensors
