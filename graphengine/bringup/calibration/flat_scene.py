"""Makes a scene in which one robot of another scene stands alone on a flat floor."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphengine.api.scene import Scene, loaded_of, modules_of, world_of
from graphengine.api.scene_loading import open_scene
from graphengine.descriptions.description_reader import is_text
from graphengine.format.atomic_write import write_together
from graphengine.format.yaml_text import flow
from graphengine.physics.model.robot import RobotInstance

_WORLD = "worlds/flat_grid.xml"
_PLACES = ("position", "orientation", "count", "spacing", "per_row", "places", "namespace")
"""Keys of a robot's entry in a scene file for position and name of the robot or its fleet; the new scene leaves them out."""


def on_flat_floor(scene: Scene, robot: RobotInstance) -> AbstractContextManager[Scene]:
    """Return a context manager for a scene with only this robot, and the graphs of its file, at the origin of a flat floor.

    The graphs of the scene file are left out, because they may command the robot.

    Raises:
        CheckError: the robot or one of its graphs has errors.
    """
    document = world_of(scene).scenery.scene.document
    use = document.find("robots", robot.placement.key)
    assert use is not None
    kept = {key: value for key, value in use.to_data().items() if key not in _PLACES}
    if not is_text(kept["use"]):
        kept["use"] = str(loaded_of(scene).files.find(kept["use"], document.path.parent).absolute())
    kept["position"] = [0.0, 0.0, robot.placement.pose[0][2]]
    if robot.placement.namespace is not None:
        kept["namespace"] = robot.placement.namespace
    allowed = [*loaded_of(scene).options.allowed, document.path.absolute().parent]
    options = replace(loaded_of(scene).options, allowed=allowed, scene=None, rays="mujoco")
    more = {"physics": document.data.get("physics", {}), "robots": {robot.name: kept}}
    return flat_scene(scene.name, "calibration", lambda path: open_scene(path, options, modules_of(scene)), more)


@contextmanager
def flat_scene(stem: str, name: str, make: Callable[[Path], Scene], more: Mapping[str, Any]) -> Iterator[Scene]:
    """Yield a scene with a flat floor.

    Args:
        stem: name of the scene's file without its suffix.
        name: name of the scene.
        make: reads and checks the scene in a file; it should choose MuJoCo for rays, because hardly any ray is cast.
        more: further keys of the scene file.

    Raises:
        CheckError: the scene has errors.
    """
    data = {"format": 1, "scene": name, "world": _WORLD, "settle": True, **more}
    with tempfile.TemporaryDirectory(prefix="graphengine-") as folder:
        path = Path(folder, f"{stem}.yaml")
        write_together({path: "".join(f"{key}: {flow(value)}\n" for key, value in data.items()).encode()})
        yield make(path)
