"""Keys of world resources that nodes read and change; a pass orders the readers and writers of each key.

Poses depend on each other along the tree, so all poses of a robot, or below `/World`, share one key. If the prim comes from a
wire, the key is unknown before the run: such a reader is ordered after all writers, and such a writer before all readers.
"""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.node.node_class import UNKNOWN_PRIM

ANY = "prim:any"
"""Key that all writers of prims write, and that a node reads if its prim is unknown before the run."""
WIRED = UNKNOWN_PRIM
"""Key that all readers of prims read, and that a node writes if its prim is unknown before the run."""


def pose_of(path: str) -> str:
    """Key of the pose of a prim."""
    return f"pose:{_root(path)}"


def drives_of(path: str) -> str:
    """Key of the drive targets of a robot."""
    _, first, *below = path.split("/") if path.startswith("/") else ("", path)
    return f"drives:/{first}/{below[0]}" if first == "World" and below else f"drives:/{first}"


def attribute_of(path: str, name: str) -> str:
    """Key of one attribute of a prim."""
    return pose_of(path) if name.startswith("xformOp:") else f"prim:{path.replace('/Geometry/', '/')}.{name}"


def reading_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Keys for a node that reads poses of prims; no paths mean that the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (ANY,)), WIRED)


def writing_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """Keys for a node that moves prims; no paths mean that the prims are unknown."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (WIRED,)), ANY)


def _root(path: str) -> str:
    return f"/{path.split('/')[1] if '/' in path else path}"
