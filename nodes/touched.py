"""Keys of world resources that nodes read and change; the compiler relates the readers and writers of each key.

The pose of a prim depends on the poses of its ancestors, so all poses of a robot share one key, as do all poses below `/World`.
If a wire gives the prim, the key is unknown before the run; the node then counts as a reader or writer of all prims.
"""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.node.node_class import UNKNOWN_PRIM

ANY = "prim:any"
"""Key that every writer of a prim declares; a reader whose prim is unknown declares that it reads this key."""
WIRED = UNKNOWN_PRIM
"""Key that every reader of a prim declares; a writer whose prim is unknown declares that it changes this key."""


def pose_of(path: str) -> str:
    """Return the key for the pose of the prim at this path."""
    return f"pose:{_root(path)}"


def drives_of(path: str) -> str:
    """Return the key for the drive targets of the robot to which the prim at this path belongs."""
    _, first, *below = path.split("/") if path.startswith("/") else ("", path)
    return f"drives:/{first}/{below[0]}" if first == "World" and below else f"drives:/{first}"


def attribute_of(path: str, name: str) -> str:
    """Return the key for one attribute of the prim at this path."""
    return pose_of(path) if name.startswith("xformOp:") else f"prim:{path.replace('/Geometry/', '/')}.{name}"


def reading_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Return the keys to declare for a node that reads the poses of these prims; without paths, the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (ANY,)), WIRED)


def writing_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Return the keys to declare for a node that moves these prims; without paths, the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (WIRED,)), ANY)


def _root(path: str) -> str:
    return f"/{path.split('/')[1] if '/' in path else path}"
