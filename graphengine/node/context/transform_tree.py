"""Computes the edges and frame names of a TF tree from target prims, by the rules of IsaacComputeTransformTree.

If a target is a robot's root prim, base link or articulation root, each link of the robot gets an edge from its kinematic parent.
Any other target gets one edge, from the parent prim. If the parent prim is also a target, it gets an edge from itself to itself;
a robot gets this edge only if the target is the articulation root. ROS2PublishTransformTree omits this edge for links and bodies.

The name of a frame is its prefix followed by the prim's `isaac:nameOverride`; without an override, the last element of the prim's
path. If several prims have the same name, the prim with the longest path keeps it, and the others get longer names.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from graphengine.devices.motion import Frame, FrameLink
from graphengine.devices.rotation import IDENTITY, ORIGIN, Pose, compose, relative
from graphengine.devices.stage import Prim, Stage
from graphengine.node.context.frame_names import full_frame, prim_prefix


def expand(
    stage: Stage, targets: Sequence[Prim], parent: Prim | None, frame: Callable[[Prim], Frame], *, loops: bool = True
) -> list[FrameLink]:
    """Return the TF edges for target prims, in the order of the targets; the edges of a robot are in the order of its links.

    Args:
        stage: stage of the prims.
        targets: target prims.
        parent: prim whose frame is the parent frame; None for the frame `world`.
        frame: returns a handle to the pose of a prim.
        loops: if `parent` is a link or body and also a target, whether to return an edge from this prim to itself.
    """
    edges: dict[Prim, Prim | None] = {}
    for target in targets:
        robot = stage.stands_for_robot(target)
        if robot is None or target.kind not in ("robot", "link"):
            if loops or target is not parent or target.kind not in ("link", "body"):
                edges.setdefault(target, parent)
            continue
        if loops and target is parent and target.path == robot.facts.get("articulation_root"):
            edges.setdefault(target, parent)
        for link in robot.descendants():
            if link.kind == "link" and link is not parent:
                above = next((p for p in link.ancestors() if p is not link and p.kind == "link"), None)
                edges.setdefault(link, above or parent)
    named = frame_names(stage, [*edges, *(p for p in edges.values() if p is not None), *([parent] if parent else [])])
    return [
        FrameLink(
            named[above] if above else "world",
            named[prim],
            frame(above) if above else None,
            frame(prim),
            optical=prim.kind == "camera",
            fixed=_fixed(stage, above, prim),
        )
        for prim, above in edges.items()
    ]


def _fixed(stage: Stage, parent: Prim | None, child: Prim) -> Pose | None:
    """Return the constant pose of a child prim in the parent's frame; None if a joint lies between them."""
    anchor, pose = _anchor(stage, child)
    other, parent_pose = _anchor(stage, parent) if parent is not None else (None, (ORIGIN, IDENTITY))
    return relative(parent_pose, pose) if anchor is other else None


def _anchor(stage: Stage, prim: Prim) -> tuple[Prim | None, Pose]:
    """Return the carrier of a prim, None for the world, and the pose of the prim in the carrier's frame.

    In a robot, the carrier is the nearest moving link or base link, from the prim itself upwards; elsewhere, it is the nearest
    rigid body.
    """
    robot = stage.robot_of(prim)
    moved = {robot.facts.get("base_link"), *robot.facts.get("moving_links", ())} if robot is not None else set[str]()
    pose: Pose = (ORIGIN, IDENTITY)
    for ancestor in prim.ancestors():
        if ancestor.path in moved or (robot is None and ancestor.body is not None):
            return ancestor, pose
        pose = compose((ancestor.position, ancestor.orientation), pose)
    return None, pose


def frame_names(stage: Stage, prims: Sequence[Prim]) -> dict[Prim, str]:
    """Return a unique frame name for each prim, including the prefix."""
    unique = list(dict.fromkeys(prims))
    prefixes = {prim: prim_prefix(stage, prim) for prim in unique}
    names: dict[Prim, str] = {}
    taken: set[str] = set()
    for prim in sorted(unique, key=lambda p: -len(p.path)):  # sorted is stable: the longest path chooses first
        name = full_frame(stage, prim.frame_name, prefixes[prim])
        if name not in taken:
            names[prim] = name
            taken.add(name)
    for prim in unique:
        if prim in names:
            continue
        parts = prim.path.strip("/").split("/")
        whole = "_".join(parts)
        candidates = [prim.name, *(f"{ancestor}_{prim.name}" for ancestor in parts[1:-1]), whole]
        numbered = (f"{whole}_{number}" for number in itertools.count(1))
        full = (full_frame(stage, name, prefixes[prim]) for name in itertools.chain(candidates, numbered))
        names[prim] = next(name for name in full if name not in taken)
        taken.add(names[prim])
    return names
