"""The stage: the tree of prims, which graphs address by path. It is plain data, without physics.

The links of a robot are below `Geometry`, each below the link to which its joint attaches it. Sensors, cameras, frames and graphs
are children of links. The joints of a robot are in `Physics` and its materials in `Materials`:

    /dd100                                          robot
    /dd100/Geometry/base_link                       link
    /dd100/Geometry/base_link/chassis_link          link, articulation root
    /dd100/Geometry/base_link/chassis_link/sim_lidar/Lidar
    /dd100/Physics/front_left_wheel_joint           joint

A path may leave out `Geometry`. If the name of a link is unique in its robot, a path may also leave out the links above it, as in
`/dd100/chassis_link`; importers that do not nest links produce such paths. Where a node needs a robot, the path may be that of
the robot's root prim, base link or articulation root.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

from graphengine.devices.rotation import IDENTITY, NOWHERE, ORIGIN, Pose, Quaternion, Vector3, compose
from graphengine.format.errors import AmbiguousPrimError, PrimError
from graphengine.format.prim_paths import normalize
from graphengine.format.stateful import Shared
from graphengine.format.wording import did_you_mean, listing

PrimKind = str
"""Kind of a prim: scope, robot, link, joint, frame, material, graph, body, light, sensor, or the kind of a device.

A prim of kind `sensor` is the mount of one or more devices.
"""

PHYSICS_SCENE = "/physicsScene"
"""Path of the prim with the physics settings, as in Isaac Sim; it has the attributes of gravity."""


@dataclass(slots=True, eq=False)
class Prim(Shared):
    """One prim of a stage. Its position (m) and orientation are relative to its parent prim."""

    path: str
    kind: PrimKind
    parent: Prim | None = field(repr=False)
    position: Vector3 = ORIGIN
    orientation: Quaternion = IDENTITY
    body: str | None = None
    """Name of the prim's own body in the MuJoCo model. Only links and bodies have one; a link without mass that is fixed to
    another link has none."""
    namespace: str = ""
    """Value of the attribute `isaac:namespace`."""
    name_override: str = ""
    """Value of the attribute `isaac:nameOverride`."""
    facts: dict[str, Any] = field(default_factory=dict)
    """Data for the kind of the prim, such as the profile of a lidar or the joints of a robot."""
    children: dict[str, Prim] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """Name of the prim, which is the last element of its path."""
        return self.path.rpartition("/")[2]

    @property
    def entity_name(self) -> str:
        """Name of a robot in its scene. The names of its bodies and joints in the MuJoCo model begin with it."""
        return str(self.facts.get("name", self.name))

    @property
    def frame_name(self) -> str:
        """Name of the prim's TF frame without prefix: `isaac:nameOverride`; without an override, the prim's name."""
        return self.name_override or self.name

    def carrier(self) -> tuple[str | None, Pose]:
        """Return the name of the body that carries the prim, and the prim's pose in the body's frame.

        The name is None if the prim is fixed to the world; the pose is then in the world frame.
        """
        pose = NOWHERE
        for prim in self.ancestors():
            if prim.body is not None:
                return prim.body, pose
            pose = compose((prim.position, prim.orientation), pose)
        return None, pose

    def ancestors(self) -> Iterator[Prim]:
        """Yield the prim itself, then its ancestors from the parent up to the root."""
        prim: Prim | None = self
        while prim is not None:
            yield prim
            prim = prim.parent

    def nearest(self, kind: PrimKind) -> Prim | None:
        """Return the prim itself if it has this kind, otherwise its nearest ancestor of this kind; None without such a prim."""
        return next((prim for prim in self.ancestors() if prim.kind == kind), None)

    def descendants(self) -> Iterator[Prim]:
        """Yield the prim itself, then all prims below it, depth first, siblings in order of definition."""
        pending = [self]
        while pending:
            prim = pending.pop()
            yield prim
            pending.extend(reversed(prim.children.values()))


class Stage:
    """The tree of all prims of a scene."""

    def __init__(self) -> None:
        self.root = Prim("/", "scope", None)
        self.global_tf = False
        """Whether all robots publish on /tf and /tf_static, so that frame names have the robots' namespaces as prefixes."""
        self._by_path: dict[str, Prim] = {"/": self.root}
        self._by_short_path: dict[str, list[Prim]] = {}

    def copy(self) -> Stage:
        """Return a copy of the stage with copies of all prims and their facts."""
        made = Stage()
        made.root.namespace, made.global_tf = self.root.namespace, self.global_tf
        for prim in itertools.islice(self.prims(), 1, None):
            assert prim.parent is not None
            parent = made._by_path[prim.parent.path]
            made._enter(replace(prim, parent=parent, facts=dict(prim.facts), children={}), parent)
        return made

    def is_like(self, other: Stage) -> bool:
        """Return whether another stage has equal prims in the same order."""
        pairs = itertools.zip_longest(self.prims(), other.prims())
        return all(one is not None and two is not None and _alike(one, two) for one, two in pairs)

    def add(self, path: str, kind: PrimKind, **facts: Any) -> Prim:
        """Add a prim and return it.

        Missing ancestors are added as scopes. If a scope exists at the path, it becomes the new prim and keeps its children.

        Args:
            path: path of the prim.
            kind: kind of the prim.
            facts: values of other attributes of `Prim`.

        Raises:
            PrimError: another prim exists at the path, or the path is not legal.
        """
        path = normalize(path)
        if path == "/":
            raise PrimError("'/' is the root prim, which always exists", path)
        existing = self._by_path.get(path)
        if existing is not None:
            if existing.kind != "scope" or kind == "scope":
                raise PrimError(f"two prims at {path}", path, "give one of them another name")
            existing.kind = kind
            for name, value in facts.items():
                setattr(existing, name, value)
            return existing
        parent_path = path.rpartition("/")[0]
        parent = self._by_path.get(parent_path or "/") or self.add(parent_path, "scope")
        return self._enter(Prim(path, kind, parent, **facts), parent)

    def _enter(self, prim: Prim, parent: Prim) -> Prim:
        parent.children[prim.name] = self._by_path[prim.path] = prim
        self._by_short_path.setdefault(_without_geometry(prim.path), []).append(prim)
        return prim

    def remove(self, path: str) -> None:
        """Remove a prim and all prims below it.

        Raises:
            PrimError: no prim has the path.
        """
        prim = self.find(path)
        for gone in list(prim.descendants()):
            del self._by_path[gone.path]
            short = _without_geometry(gone.path)
            self._by_short_path[short].remove(gone)
            if not self._by_short_path[short]:
                del self._by_short_path[short]
        assert prim.parent is not None
        del prim.parent.children[prim.name]

    def find(self, path: str) -> Prim:
        """Return the prim at a path, which may leave out `Geometry` and the links between a robot and one of its links.

        Raises:
            PrimError: no prim has the path; the message suggests similar names.
            AmbiguousPrimError: the path matches several prims.
        """
        if path in self._by_path:  # stored paths need no normalization
            return self._by_path[path]
        wanted = normalize(path)
        found = self._meant(wanted) or self._laid_flat(wanted)
        if len(found) == 1:
            return found[0]
        if found:
            remedy = listing([prim.path for prim in found], "write one of")
            raise AmbiguousPrimError(f"{path!r} could mean {len(found)} prims", path, remedy)
        raise self._missing(path, wanted)

    def _meant(self, wanted: str) -> list[Prim]:
        """Return the prims that a path denotes: the prim at exactly this path, or all prims at this path without `Geometry`."""
        if wanted in self._by_path:
            return [self._by_path[wanted]]
        return [p for p in self._by_short_path.get(_without_geometry(wanted), []) if _is_short_for(wanted, p.path)]

    def _laid_flat(self, wanted: str) -> list[Prim]:
        """Return the prims that match a path without the links between a robot and one of its links."""
        robot, rest = self._descend(wanted, flat=False)
        while robot.kind != "robot" and robot.parent is not None:
            rest, robot = [robot.name, *rest], robot.parent
        rest = rest[1:] if rest[:1] == ["Geometry"] else rest
        paths = ["/".join([link.path, *rest[1:]]) for link in _links(robot, rest[0])] if rest else []
        return [prim for path in paths for prim in self._meant(path)]

    def is_literal(self, path: str, prim: Prim) -> bool:
        """Return whether a path to a prim names all links above the prim; the path may leave out `Geometry`."""
        return _is_short_for(normalize(path), prim.path)

    def obstacle(self, path: str) -> Prim | None:
        """Return the prim that prevents a robot from being added at a path; None if a robot can be added there.

        The obstacle is a prim at the path itself, or an ancestor that is not a scope.
        """
        prim, rest = self._descend(path)
        return None if rest and prim.kind == "scope" else prim

    def _descend(self, path: str, *, flat: bool = True) -> tuple[Prim, list[str]]:
        """Return the last existing prim on the way along a path, and the remaining elements of the path.

        Args:
            path: path, from the root.
            flat: whether the path may leave out the links between a robot and one of its links.
        """
        parts, prim = normalize(path).strip("/").split("/"), self.root
        for index, part in enumerate(parts):
            geometry = prim.children.get("Geometry")
            child = prim.children.get(part) or (geometry.children.get(part) if geometry else None)
            if child is None and flat and len(links := _links(prim, part)) == 1:
                child = links[0]
            if child is None:
                return prim, parts[index:]
            prim = child
        return prim, []

    def _missing(self, path: str, wanted: str) -> PrimError:
        parts = wanted.strip("/").split("/")
        prim, rest = self._descend(wanted)
        part = rest[0] if rest else parts[-1]
        geometry = prim.children.get("Geometry")
        near = did_you_mean(part, [*prim.children, *(geometry.children if geometry else ())])
        same_name = [p.path for p in self.prims() if p.name == parts[-1]]
        return PrimError(
            f"no prim at {path!r}: {prim.path} has no child {part!r}",
            path,
            near or listing(prim.children, f"children of {prim.path}"),
            listing(same_name[:3], f"{parts[-1]!r} is at") if same_name else "",
        )

    def __contains__(self, path: str) -> bool:
        wanted = normalize(path)
        return len(self._meant(wanted) or self._laid_flat(wanted)) == 1

    def prims(self, kind: PrimKind | None = None) -> Iterator[Prim]:
        """Yield all prims, or all prims of one kind, depth first, siblings in order of definition."""
        return (prim for prim in self.root.descendants() if kind is None or prim.kind == kind)

    def robots(self) -> dict[str, Prim]:
        """Return a dict from the names of all robots to their prims, depth first, siblings in order of definition."""
        return {prim.entity_name: prim for prim in self.prims("robot")}

    def robot_of(self, prim: Prim) -> Prim | None:
        """Return the prim of the robot to which a prim belongs, or None if the prim belongs to no robot."""
        return prim.nearest("robot")

    def stands_for_robot(self, prim: Prim) -> Prim | None:
        """Return the robot that a prim identifies as its root prim, base link or articulation root; None for any other prim."""
        robot = self.robot_of(prim)
        if robot is None or prim is robot:
            return robot
        return robot if prim.path in (robot.facts.get("base_link"), robot.facts.get("articulation_root")) else None

    def namespaces(self, path: str) -> list[str]:
        """Return the non-empty `isaac:namespace` values of the prims along a path, from the root down.

        If the path does not exist, only its existing ancestors count.
        """
        prim, _ = self._descend(path)
        return [above.namespace for above in reversed([*prim.ancestors()]) if above.namespace]

    def define(self, path: str) -> Prim:
        """Return the prim at a path. If no prim exists there, add a scope, and scopes for its missing ancestors."""
        prim, rest = self._descend(path)
        return self.add("/".join([prim.path.rstrip("/"), *rest]), "scope") if rest else prim

    def leads_by(self, path: str, other: str) -> bool:
        """Return whether `path` is `other` or lies below it. Either path may leave out `Geometry` or links.

        The prims need not exist.
        """
        (prim, rest), (passed, more) = self._descend(path), self._descend(other)
        if more:
            return prim is passed and rest[: len(more)] == more
        return passed in prim.ancestors()


def housing_of(prim: Prim) -> str:
    """Return the name of the visible body of a sensor with an appearance: the robot's name and the path below the robot."""
    robot = prim.nearest("robot")
    above, name = (robot.path, robot.entity_name) if robot is not None else ("/", "")
    return name + prim.path.removeprefix(above)


def _alike(one: Prim, other: Prim) -> bool:
    names = (field.name for field in fields(Prim) if field.name not in ("parent", "children"))
    try:
        return all(bool(getattr(one, name) == getattr(other, name)) for name in names)
    except ValueError:  # facts of devices from other packages may be arrays
        return False


def _links(robot: Prim, name: str) -> list[Prim]:
    """Return the links of a robot that have this name; empty if the prim is not a robot."""
    if robot.kind != "robot":
        return []
    return [prim for prim in robot.descendants() if prim.kind == "link" and prim.name == name]


def _without_geometry(path: str) -> str:
    return "/" + "/".join(part for part in path.split("/") if part and part != "Geometry")


def _is_short_for(path: str, full: str) -> bool:
    wanted = path.split("/")
    for part in full.split("/"):
        if wanted and part == wanted[0]:
            wanted = wanted[1:]
        elif part != "Geometry":
            return False
    return not wanted
