"""Keys of what nodes read and change in the world, by which a pass puts readers and writers of one thing in order.

Poses hang together along the tree, so that those of one robot, or of all prims below `/World`, are one thing. Where a wire
decides which prim it is, the key is not known before the run: such a reader reads what any writer writes, and vice versa.
"""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.node.node_class import UNKNOWN_PRIM

ANY = "prim:any"
"""What every writer of a prim changes, and who does not know its prim reads."""
WIRED = UNKNOWN_PRIM
"""What every reader of a prim reads, and who does not know its prim changes."""


def pose_of(path: str) -> str:
    """The pose of a prim."""
    return f"pose:{_root(path)}"


def drives_of(path: str) -> str:
    """What the drives of a robot are told."""
    _, first, *below = path.split("/") if path.startswith("/") else ("", path)
    return f"drives:/{first}/{below[0]}" if first == "World" and below else f"drives:/{first}"


def attribute_of(path: str, name: str) -> str:
    """One attribute of a prim."""
    return pose_of(path) if name.startswith("xformOp:") else f"prim:{path.replace('/Geometry/', '/')}.{name}"


def reading_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """What a node reads that reads poses of prims; none of which are known if there are no paths."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (ANY,)), WIRED)


def writing_poses(paths: Iterable[str]) -> tuple[str, ...]:
    """What a node changes that puts prims somewhere; none of which are known if there are no paths."""
    return (*(dict.fromkeys(map(pose_of, paths)) or (WIRED,)), ANY)


def _root(path: str) -> str:
    return f"/{path.split('/')[1] if '/' in path else path}"
