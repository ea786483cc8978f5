"""The prim tree as plain data, without physics; graphs address its prims by path.

A robot's links are nested by kinematics below `Geometry`, its sensors, cameras, frames and graphs hang below links, its joints
lie in `Physics` and its materials in `Materials`:

    /dd100                                          robot
    /dd100/Geometry/base_link                       link
    /dd100/Geometry/base_link/chassis_link          link, articulation root
    /dd100/Geometry/base_link/chassis_link/sim_lidar/Lidar
    /dd100/Physics/front_left_wheel_joint           joint

A path may leave out `Geometry`. It may also lead from the robot directly to a link whose name is unique in the robot, as
importers without nested links write it: `/dd100/chassis_link`. Nodes accept a robot's root prim, its base link or its
articulation root for the robot.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

from graphengine.devices.rotation import IDENTITY, NOWHERE, ORIGIN, Pose, Quaternion, Vector3, compose
from graphengine.format.errors import AmbiguousPrimError, PrimError
from graphengine.format.stateful import Shared
from graphengine.format.wording import did_you_mean, listing

PrimKind = str
"""A kind of device, or one of: scope, robot, link, joint, frame, material, graph, body, light; sensor, which mounts devices."""

PHYSICS_SCENE = "/physicsScene"
"""Path of the prim with the physics settings, as in Isaac Sim; scenes have their gravity there."""


@dataclass(slots=True, eq=False)
class Prim(Shared):
    """One prim. Its pose is relative to its parent prim; `body` names the physics body that carries it."""

    path: str
    kind: PrimKind
    parent: Prim | None = field(repr=False)
    position: Vector3 = ORIGIN
    orientation: Quaternion = IDENTITY
    body: str | None = None
    """Name of the prim's own body in the physics model, for links and bodies."""
    namespace: str = ""
    """Value of the attribute `isaac:namespace`."""
    name_override: str = ""
    """Value of the attribute `isaac:nameOverride`."""
    facts: dict[str, Any] = field(default_factory=dict)
    """Data for this kind of prim: a lidar's profile, a camera's size, a robot's joints."""
    children: dict[str, Prim] = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """Last element of the path."""
        return self.path.rpartition("/")[2]

    @property
    def entity_name(self) -> str:
        """Name of a robot in its scene; also the prefix of its names in the physics model."""
        return str(self.facts.get("name", self.name))

    @property
    def frame_name(self) -> str:
        """Name in TF: `isaac:nameOverride`, or else the last element of the path."""
        return self.name_override or self.name

    def carrier(self) -> tuple[str | None, Pose]:
        """Return the name of the physics body that carries the prim (None: the world), and the prim's pose in its frame."""
        pose = NOWHERE
        for prim in self.ancestors():
            if prim.body is not None:
                return prim.body, pose
            pose = compose((prim.position, prim.orientation), pose)
        return None, pose

    def ancestors(self) -> Iterator[Prim]:
        """Yield the prim itself, then its ancestors up to the root."""
        prim: Prim | None = self
        while prim is not None:
            yield prim
            prim = prim.parent

    def descendants(self) -> Iterator[Prim]:
        """Yield the prim itself, then all prims below it, depth first in order of definition."""
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
        """Whether all robots publish on /tf and /tf_static, with the namespaces as prefixes of frame names."""
        self._by_path: dict[str, Prim] = {"/": self.root}
        self._by_short_path: dict[str, list[Prim]] = {}

    def copy(self) -> Stage:
        """Return an independent tree with copies of all prims and their facts."""
        made = Stage()
        made.root.namespace, made.global_tf = self.root.namespace, self.global_tf
        for prim in itertools.islice(self.prims(), 1, None):
            assert prim.parent is not None
            parent = made._by_path[prim.parent.path]
            made._enter(replace(prim, parent=parent, facts=dict(prim.facts), children={}), parent)
        return made

    def is_like(self, other: Stage) -> bool:
        """Whether another tree has equal prims in the same order."""
        pairs = itertools.zip_longest(self.prims(), other.prims())
        return all(one is not None and two is not None and _alike(one, two) for one, two in pairs)

    def add(self, path: str, kind: PrimKind, **facts: Any) -> Prim:
        """Define a prim; missing ancestors become scopes, and a scope at the path takes the new kind.

        Raises:
            PrimError: the path is taken, or not absolute.
        """
        path = normalize(path)
        if path == "/":
            raise PrimError("the root prim cannot be defined", path)
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
        """Delete a prim and everything below it."""
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
        """Return the prim at a path; the path may leave out `Geometry` and the links above a link.

        Raises:
            PrimError: no prim has the path; the message suggests similar names.
            AmbiguousPrimError: the path fits several prims.
        """
        wanted = normalize(path)
        found = self._meant(wanted) or self._laid_flat(wanted)
        if len(found) == 1:
            return found[0]
        if found:
            raise AmbiguousPrimError(
                f"{path!r} could mean {len(found)} prims", path, listing([prim.path for prim in found], "write one of")
            )
        raise self._missing(path, wanted)

    def _meant(self, wanted: str) -> list[Prim]:
        """The prim at exactly this path, or else all prims whose paths equal it except for `Geometry`."""
        if wanted in self._by_path:
            return [self._by_path[wanted]]
        return [p for p in self._by_short_path.get(_without_geometry(wanted), []) if _is_short_for(wanted, p.path)]

    def _laid_flat(self, wanted: str) -> list[Prim]:
        """Prims at a path that leads from the robot directly to a link, wherever the link is in the robot."""
        robot, rest = self._descend(wanted, flat=False)
        while robot.kind != "robot" and robot.parent is not None:
            rest, robot = [robot.name, *rest], robot.parent
        rest = rest[1:] if rest[:1] == ["Geometry"] else rest
        paths = ["/".join([link.path, *rest[1:]]) for link in _links(robot, rest[0])] if rest else []
        return [prim for path in paths for prim in self._meant(path)]

    def is_literal(self, path: str, prim: Prim) -> bool:
        """Return whether a path to a prim contains all links above it; `Geometry` may be missing."""
        return _is_short_for(normalize(path), prim.path)

    def obstacle(self, path: str) -> Prim | None:
        """Return the prim that prevents adding a robot at a path: a prim at the path, or an ancestor other than a scope.

        None if a robot can be added there.
        """
        prim, rest = self._descend(path)
        return None if rest and prim.kind == "scope" else prim

    def _descend(self, path: str, *, flat: bool = True) -> tuple[Prim, list[str]]:
        """The deepest existing prim along a path, and the remaining parts of the path."""
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
        """Yield all prims, or all prims of one kind, depth first in order of definition."""
        return (prim for prim in self.root.descendants() if kind is None or prim.kind == kind)

    def robot_of(self, prim: Prim) -> Prim | None:
        """Return the robot that a prim belongs to, or None."""
        return next((p for p in prim.ancestors() if p.kind == "robot"), None)

    def stands_for_robot(self, prim: Prim) -> Prim | None:
        """Return the robot if the prim is its root prim, base link or articulation root; otherwise None."""
        robot = self.robot_of(prim)
        if robot is None or prim is robot:
            return robot
        return robot if prim.path in (robot.facts.get("base_link"), robot.facts.get("articulation_root")) else None

    def namespaces(self, path: str) -> list[str]:
        """Return the non-empty `isaac:namespace` values from the root down to a path; the path need not exist."""
        prim, _ = self._descend(path)
        return [above.namespace for above in reversed([*prim.ancestors()]) if above.namespace]

    def define(self, path: str) -> Prim:
        """Return the prim at a path; missing prims are added as scopes."""
        prim, rest = self._descend(path)
        return self.add("/".join([prim.path.rstrip("/"), *rest]), "scope") if rest else prim

    def leads_by(self, path: str, other: str) -> bool:
        """Return whether `path` equals `other` or lies below it; the prims need not exist."""
        (prim, rest), (passed, more) = self._descend(path), self._descend(other)
        if more:
            return prim is passed and rest[: len(more)] == more
        return passed in prim.ancestors()


def prim_name(name: str) -> str:
    """Return a name that is legal in USD: letters, digits and '_'."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{plain}" if plain[:1].isdigit() else plain


def normalize(path: str) -> str:
    """Return an absolute path without doubled or trailing slashes.

    Raises:
        PrimError: the path is not absolute, or has the part `.` or `..`.
    """
    if not path.startswith("/"):
        raise PrimError(
            f"{path!r} is not a prim path", path, "a prim path begins with '/', as in /dd100/Geometry/base_link"
        )
    parts = [part for part in path.split("/") if part]
    if any(part in (".", "..") for part in parts):
        raise PrimError(f"{path!r} is not a plain prim path", path, "write the path without '.' and '..'")
    return "/" + "/".join(parts)


def at_or_below(path: str, other: str) -> bool:
    """Return whether the normalized `path` equals `other` or lies below it."""
    return path == other or path.startswith(f"{other}/")


def _alike(one: Prim, other: Prim) -> bool:
    names = (field.name for field in fields(Prim) if field.name not in ("parent", "children"))
    try:
        return all(bool(getattr(one, name) == getattr(other, name)) for name in names)
    except ValueError:  # facts of devices from other packages may be arrays
        return False


def _links(robot: Prim, name: str) -> list[Prim]:
    """The links with this name in a robot; empty if the prim is not a robot."""
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
