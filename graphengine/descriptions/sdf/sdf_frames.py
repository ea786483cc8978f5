"""Resolves names in SDF to frames of a model or world, and computes the poses of frames.

Each model is a scope of names. The model itself (`__model__`) and each of its links, joints, `<frame>` elements and nested models
has a frame. `A::B` is the frame B of the nested model A.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_values import SdfError, flag_at, pose_of, text_at
from graphengine.devices.rotation import NOWHERE, Pose, compose, relative
from graphengine.format.wording import did_you_mean, listing, printable

_MAX_ATTACHED = 1000
"""Maximum length of a chain of frames that are attached to each other."""
_LONGEST = 1000
"""Maximum number of characters of a name such as `A::B`."""
_MAX_COMPARED = 200
"""Maximum number of names with which an unknown name is compared for suggestions."""
FIRST_WITH_FRAMES = 7
"""Minor number of the first SDF version with `<pose relative_to="…">`; earlier versions write `<pose frame="…">`."""


@dataclass(slots=True, eq=False)
class SdfFrame:
    """A frame of a model or world.

    Attributes:
        kind: kind of the element that has the frame: `link`, `joint`, `frame`, or `scope` for a model or a world.
        name: name of the frame in its scope.
        element: element that has the frame.
        scope: scope that contains the name; for a model or a world, its own scope.
    """

    kind: str
    name: str
    element: Element
    scope: Scope
    _place: Pose | None = None
    """Pose in the outermost scope; None if it is not computed yet."""
    _raw: Pose | None = None
    _fault: SdfError | None = None
    """Error because of which the pose cannot be computed; all frames of a cycle receive the same error at once."""

    @property
    def full_name(self) -> str:
        """Name in the outermost model: `A::B` for frame B of the nested model A."""
        return f"{self.scope.prefix}{self.name}"

    @property
    def place(self) -> Pose:
        """Pose of the frame in the outermost scope.

        Raises:
            SdfError: the frame is relative, directly or indirectly, to a frame that does not exist or to itself.
        """
        if self._fault is not None:
            raise self._fault
        if self._place is None:
            chain = _chain(self, lambda frame: frame._place is not None)
            last = chain.pop()
            pose = last._place if last._place is not None else NOWHERE  # a model or world alone
            last._place = pose
            for frame in reversed(chain):
                pose = compose(pose, frame._pose())
                frame._place = pose
            return pose
        return self._place

    def base(self) -> SdfFrame | None:
        """Return the frame in which the pose of this frame is given; None for the outermost scope."""
        home = self.scope.outer if self.kind == "scope" else self.scope
        return (relative_to(self.element, home) or self._holder(home)) if home is not None else None

    def _holder(self, home: Scope) -> SdfFrame:
        """Return the frame to which this frame is attached, by default the frame of the scope `home`."""
        if self.kind == "joint":
            return home.child_of(self.element)
        name = self.element.get("attached_to") if self.kind == "frame" else ""
        return home.require(name, self.element, "attached_to") if name else home.frame

    def link(self) -> SdfFrame:
        """Return the frame of the link to which this frame is attached; for a world, the frame of the world.

        Raises:
            SdfError: the frame is attached to no link.
        """
        at, seen = self, {self}
        while at.kind != "link" and not at.scope.is_world:
            at = at.scope.canonical_link() if at.kind == "scope" else at._holder(at.scope)
            if at in seen or len(seen) > _MAX_ATTACHED:
                raise SdfError(f"frame {printable(self.name)!r} is attached to no link", self.element.span)
            seen.add(at)
        return at

    def _pose(self) -> Pose:
        """Return the pose of this frame in its base frame (see `base`).

        The `<pose>` of a model with a `placement_frame` is the pose of that frame in the model.
        """
        if self._raw is None:
            self._raw = pose_of(self.element.first("pose"))
            if self.kind == "scope" and (name := self.element.get("placement_frame")):
                frame = self.scope.require(name, self.element, "placement_frame")
                self._raw = compose(self._raw, relative(frame._place_in(self), NOWHERE))
        return self._raw

    def _place_in(self, model: SdfFrame) -> Pose:
        pose = NOWHERE
        for frame in _chain(self, lambda at: at is model)[:-1]:
            pose = compose(frame._pose(), pose)
        return pose


def _chain(frame: SdfFrame, ends: Callable[[SdfFrame], bool]) -> list[SdfFrame]:
    """Return a frame, then its base frame, the base of that frame and so on, up to the first frame for which `ends` is true.

    The chain also ends at the outermost scope.

    Raises:
        SdfError: a frame does not exist, or the chain is a cycle.
    """
    chain: dict[SdfFrame, None] = {frame: None}
    try:
        while not ends(frame) and (base := frame.base()) is not None:
            if base._fault is not None:
                raise base._fault
            if base in chain:
                names = " -> ".join(printable(each.name) for each in [*chain, base][-6:])
                raise SdfError(f"the poses of frames form a cycle: {names}", frame.element.span)
            frame = base
            chain[frame] = None
    except SdfError as error:
        for each in chain:
            each._fault = error
        raise
    return list(chain)


@dataclass(slots=True, eq=False)
class Scope:
    """A model or a world, as a scope that contains names of links, joints, frames and nested models.

    Attributes:
        element: the `<model>` or `<world>` element.
        name: name of the model or world in the scope that contains it.
        version: minor number of the file's SDF version.
        outer: scope that contains this one; None for the outermost scope.
        references: prefix that makes relative references of this scope's file relative to the folder of the main file.
        merged: whether the names of this scope belong to the outer scope (`<include merge="true">`).
        merges: merged scopes, whose names belong to this scope.
    """

    element: Element
    name: str
    version: int
    outer: Scope | None
    references: str = ""
    merged: bool = False
    links: dict[str, SdfFrame] = field(default_factory=dict)
    joints: dict[str, SdfFrame] = field(default_factory=dict)
    frames: dict[str, SdfFrame] = field(default_factory=dict)
    models: dict[str, Scope] = field(default_factory=dict)
    merges: list[Scope] = field(default_factory=list)
    known: dict[str, SdfFrame] = field(default_factory=dict)
    """All frames of this scope by name; frames of nested models are not included."""
    frame: SdfFrame = field(init=False)
    static: bool = field(init=False)
    """Whether the model, or a model that contains it, is static."""

    def __post_init__(self) -> None:
        self.frame = SdfFrame("scope", self.name, self.element, self)
        around = self.outer is not None and self.outer.static
        self.static = not self.is_world and (around or flag_at(self.element, "static") is True)

    @property
    def is_world(self) -> bool:
        """Whether this scope is a world."""
        return self.element.tag == "world"

    @property
    def prefix(self) -> str:
        """Prefix of the scope's names in the outermost model, e.g. `A::` for the nested model A; empty for that model."""
        if self.outer is None or self.outer.is_world:
            return ""
        return self.outer.prefix if self.merged else f"{self.outer.prefix}{self.name}::"

    def walk(self) -> Iterator[Scope]:
        """Yield the scope itself and all scopes in it; merged scopes precede nested models."""
        yield self
        for scope in (*self.merges, *self.models.values()):
            yield from scope.walk()

    def all_links(self) -> list[SdfFrame]:
        """Return the links of the scope and of all scopes in it."""
        return [link for scope in self.walk() for link in scope.links.values()]

    def all_joints(self) -> list[SdfFrame]:
        """Return the joints of the scope and of all scopes in it."""
        return [joint for scope in self.walk() for joint in scope.joints.values()]

    def find(self, name: str) -> SdfFrame | None:
        """Return the frame with a name such as `B` or `A::B`; None if there is none."""
        if name == "__model__" or (name == "world" and self.is_world):
            return self.frame
        if name in self.known or len(name) > _LONGEST:
            return self.known.get(name)
        end = name.find("::")
        while end >= 0:  # before 1.7, a name itself may contain ::
            outer = self.known.get(name[:end])
            if outer is not None and outer.kind == "scope" and (found := outer.scope.find(name[end + 2 :])) is not None:
                return found
            end = name.find("::", end + 2)
        return None

    def index(self) -> None:
        """Fill `known`. Of elements with the same name, which are legal before SDF 1.7, only one is in `known`.

        A link takes precedence over a `<frame>`, a `<frame>` over a joint, and a joint over a nested model.
        """
        self.known |= {name: frame for scope in self.merges for name, frame in scope.known.items()}
        self.known |= {name: scope.frame for name, scope in self.models.items()}
        self.known |= {**self.joints, **self.frames, **self.links}

    def require(self, name: str, element: Element, attribute: str = "") -> SdfFrame:
        """Return the frame with a name that is written in an element, or in the given attribute of the element.

        Raises:
            SdfError: there is no frame with this name; the error is located at the element or the attribute.
        """
        found = self.find(name)
        if found is None:
            known = ["__model__", *itertools.islice(self.known, _MAX_COMPARED)]
            near = did_you_mean(name[:80], known) or listing(map(printable, known), "known")
            span = element.place(attribute) if attribute else element.span
            raise SdfError(f"{self._described()} has no frame {printable(name[:80])!r}", span, near)
        return found

    def child_of(self, joint: Element) -> SdfFrame:
        """Return the frame that the `<child>` of a joint names.

        Raises:
            SdfError: the joint has no `<child>`, or there is no frame with this name.
        """
        child = joint.first("child")
        if child is None or not text_at(joint, "child"):
            raise SdfError(f"joint {printable(joint.get('name'))!r}: no <child>", joint.span)
        return self.require(child.text, child)

    def canonical_link(self) -> SdfFrame:
        """Return the link to which the frame of a model is attached: its `canonical_link`, by default the first link.

        Raises:
            SdfError: the model has no link, or none with the given name.
        """
        if name := self.element.get("canonical_link"):
            return self.require(name, self.element, "canonical_link")
        if links := self.all_links():
            return links[0]
        raise SdfError(f"{self._described()} has no link", self.element.span)

    def _described(self) -> str:
        return f"{self.element.tag} {printable(self.name)!r}"


def relative_to(element: Element, scope: Scope) -> SdfFrame | None:
    """Return the frame that the `<pose>` of an element names (`relative_to`); None if the pose names no frame.

    Raises:
        SdfError: the named frame does not exist.
    """
    pose = element.first("pose")
    if pose is None:
        return None
    attribute = "relative_to" if scope.version >= FIRST_WITH_FRAMES or "relative_to" in pose.attributes else "frame"
    name = pose.get(attribute)
    return scope.require(name, pose, attribute) if name else None


def place_of(element: Element, frame: SdfFrame) -> Pose:
    """Return the pose, in the outermost scope, of an element inside a link, such as a collision or a sensor.

    Args:
        element: the element; it may have a `<pose>`.
        frame: frame of the link that contains the element.
    """
    base = relative_to(element, frame.scope) or frame
    return compose(base.place, pose_of(element.first("pose")))
