"""Functions that return the keys of world resources, such as the poses of a robot, for `reads` and `writes` of nodes.

The compiler warns if one node reads and another node writes a resource with the same key and the graph does not order them. The
pose of a prim depends on the poses of its ancestors, so all poses of a robot share one key, as do all poses below `/World`. If a
wire selects the prim, the prim is unknown before the run; the node then counts as a reader or writer of all prims.
"""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.node.node_class import UNKNOWN_PRIM

ANY = "prim:any"
"""Key that every writer of a prim returns from `writes`. A reader of an unknown prim returns this key from `reads`."""
WIRED = UNKNOWN_PRIM
"""Key that every reader of a prim returns from `reads`. A writer of an unknown prim returns this key from `writes`."""


def pose_of(path: str) -> str:
    """Return the key for the pose of the prim at this path; prims with the same first path element share the key."""
    return f"pose:{_root(path)}"


def drives_of(path: str) -> str:
    """Return the key for the drive targets of the robot to which the prim at this path belongs."""
    _, first, *below = path.split("/") if path.startswith("/") else ("", path)
    return f"drives:/{first}/{below[0]}" if first == "World" and below else f"drives:/{first}"


def attribute_of(path: str, name: str) -> str:
    """Return the key for one attribute of the prim at this path; attributes of the pose have the key of the pose."""
    return pose_of(path) if name.startswith("xformOp:") else f"prim:{path.replace('/Geometry/', '/')}.{name}"


def reading_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Return the result of `reads` for a node that reads the poses of these prims; without paths, the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (ANY,)), WIRED)


def writing_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Return the result of `writes` for a node that moves these prims; without paths, the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (WIRED,)), ANY)


def _root(path: str) -> str:
    return f"/{path.split('/')[1] if '/' in path else path}"
