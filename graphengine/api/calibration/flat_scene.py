"""Makes a scene in which one robot of another scene stands alone on a flat floor."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from graphengine.descriptions.description_reader import is_text
from graphengine.format.atomic_write import write_together
from graphengine.format.yaml_text import flow
from graphengine.physics.model.robot import RobotInstance
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene

WORLD = "worlds/flat_grid.xml"
_PLACES = ("position", "orientation", "count", "spacing", "per_row", "places", "namespace")
"""Keys of a robot's entry in a scene file that place and name the robot or its fleet; the new scene does not copy these keys."""


@contextmanager
def on_flat_floor(scene: LoadedScene, robot: RobotInstance) -> Iterator[LoadedScene]:
    """Yield a scene with only this robot at the origin of a flat floor; the robot has the graphs of its robot file.

    The graphs of the scene file are left out, because they may command the robot.

    Raises:
        CheckError: the robot or one of its graphs has errors.
    """
    assert scene.world is not None
    document = scene.world.scenery.scene.document
    use = document.find("robots", robot.placement.key)
    assert use is not None
    kept = {key: value for key, value in use.to_data().items() if key not in _PLACES}
    if not is_text(kept["use"]):
        kept["use"] = str(scene.files.find(kept["use"], document.path.parent).absolute())
    kept["position"] = [0.0, 0.0, robot.placement.pose[0][2]]
    if robot.placement.namespace is not None:
        kept["namespace"] = robot.placement.namespace
    data = {
        "format": 1,
        "scene": "calibration",
        "world": WORLD,
        "settle": True,
        "physics": document.data.get("physics", {}),
        "robots": {robot.name: kept},
    }
    allowed = [*scene.options.allowed, document.path.absolute().parent]
    options = replace(scene.options, allowed=allowed, scene=None, rays="mujoco")  # of which none is cast without need
    with tempfile.TemporaryDirectory(prefix="graphengine-") as folder:
        path = Path(folder, f"{scene.path.stem}.yaml")
        write_together({path: "".join(f"{key}: {flow(value)}\n" for key, value in data.items()).encode()})
        loaded = build.load(path, options)
        loaded.findings.raise_errors()
        yield loaded
