"""Names and poses of SDF: resolves names to frames of a model or world, and computes the poses of frames.

Each model is a scope of names. It has a frame of its own (`__model__`), and one for each link, joint, `<frame>` and nested model;
`A::B` is the frame B of the nested model A.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

from graphengine.devices.rotation import NOWHERE, Pose, compose, relative
from graphengine.format.wording import did_you_mean, listing, printable
from graphengine.physics.files.xml import Element
from graphengine.physics.sdf.sdf_values import SdfError, flag_at, pose_of, text_at

_MAX_ATTACHED = 1000
"""Maximum length of a chain of frames that are attached to each other."""
_LONGEST = 1000
"""Maximum number of characters of a name such as `A::B`."""
_MAX_COMPARED = 200
"""Maximum number of names with which an unknown name is compared for suggestions."""
FIRST_WITH_FRAMES = 7
"""SDF 1.7 defined `relative_to`; before, `<pose frame="…">` stood for it."""


Kind = Literal["scope", "link", "joint", "frame"]
"""Elements that have a frame; a model or world is a scope."""


@dataclass(slots=True, eq=False)
class SdfFrame:
    """A frame of a model or world.

    Attributes:
        kind: of the element that has it.
        name: name in its scope.
        element: element that has the frame.
        scope: scope that contains the name; for a model or a world, the scope that it makes.
    """

    kind: Kind
    name: str
    element: Element
    scope: Scope
    _place: Pose | None = None
    """Pose in the outermost scope."""
    _raw: Pose | None = None
    _fault: SdfError | None = None
    """Why the frame has no pose; set for all frames of a circle when the circle is found."""

    @property
    def full_name(self) -> str:
        """Name in the outermost model: `A::B` for frame B of the nested model A."""
        return f"{self.scope.prefix}{self.name}"

    @property
    def place(self) -> Pose:
        """Pose in the outermost scope.

        Raises:
            SdfError: it is relative to a frame that does not exist, or to itself.
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
        """Return the frame that its pose is relative to; None for the outermost scope."""
        home = self.scope.outer if self.kind == "scope" else self.scope
        if home is None:
            return None
        if reference := relative_to(self.element, home):
            return reference
        if self.kind == "joint":
            return home.child_of(self.element)
        attached = self.element.get("attached_to") if self.kind == "frame" else ""
        return home.require(attached, self.element, "attached_to") if attached else home.frame

    def link(self) -> SdfFrame:
        """Return the link that the frame is attached to; for a world, its own frame.

        Raises:
            SdfError: there is none.
        """
        at, seen = self, {self}
        while at.kind != "link" and not at.scope.is_world:
            if at.kind == "joint":
                at = at.scope.child_of(at.element)
            elif at.kind == "frame" and (name := at.element.get("attached_to")):
                at = at.scope.require(name, at.element, "attached_to")
            elif at.kind == "frame":
                at = at.scope.frame
            else:
                at = at.scope.canonical_link()
            if at in seen or len(seen) > _MAX_ATTACHED:
                raise SdfError(f"frame {printable(self.name)!r} leads to no link", self.element.span)
            seen.add(at)
        return at

    def _pose(self) -> Pose:
        """Return pose in the frame that it is relative to. That of a model may be the pose of another frame in it."""
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
    """Return a frame, the one that it is relative to, and so on, to the first at which the chain ends."""
    chain: dict[SdfFrame, None] = {frame: None}
    try:
        while not ends(frame) and (base := frame.base()) is not None:
            if base._fault is not None:
                raise base._fault
            if base in chain:
                names = " -> ".join(printable(each.name) for each in [*chain, base][-6:])
                raise SdfError(f"frames are relative to each other in a circle: {names}", frame.element.span)
            frame = base
            chain[frame] = None
    except SdfError as error:
        for each in chain:
            each._fault = error
        raise
    return list(chain)


@dataclass(slots=True, eq=False)
class Scope:
    """A model or a world with the names in it.

    Attributes:
        element: the `<model>` or `<world>`.
        name: as in the scope around it.
        version: minor number of the file's version of SDF.
        outer: scope around it; None for the outermost.
        references: what precedes relative file names: the file's folder, from the main file on.
        merged: whether its names belong to the scope around it (`<include merge="true">`).
        merges: scopes whose names belong to this one.
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
    """All frames by name, without those in nested models."""
    frame: SdfFrame = field(init=False)
    static: bool = field(init=False)
    """Whether the model, or one around it, is static."""

    def __post_init__(self) -> None:
        self.frame = SdfFrame("scope", self.name, self.element, self)
        around = self.outer is not None and self.outer.static
        self.static = not self.is_world and (around or flag_at(self.element, "static") is True)

    @property
    def is_world(self) -> bool:
        """Whether it is a world."""
        return self.element.tag == "world"

    @property
    def prefix(self) -> str:
        """What precedes its names in the outermost model."""
        if self.outer is None or self.outer.is_world:
            return ""
        return self.outer.prefix if self.merged else f"{self.outer.prefix}{self.name}::"

    def walk(self) -> Iterator[Scope]:
        """Yield the scope itself, then those in it, in order of the file."""
        yield self
        for scope in (*self.merges, *self.models.values()):
            yield from scope.walk()

    def find(self, name: str) -> SdfFrame | None:
        """Return the frame with a name; None if there is none."""
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
        """Make all names known; of one that is used twice, as was legal before 1.7, a link comes first, then a frame."""
        self.known |= {name: frame for scope in self.merges for name, frame in scope.known.items()}
        self.known |= {name: scope.frame for name, scope in self.models.items()}
        self.known |= {**self.joints, **self.frames, **self.links}

    def require(self, name: str, element: Element, attribute: str = "") -> SdfFrame:
        """Return the frame that a name means, which an element or an attribute of it gives.

        Raises:
            SdfError: there is none.
        """
        found = self.find(name)
        if found is None:
            known = ["__model__", *itertools.islice(self.known, _MAX_COMPARED)]
            near = did_you_mean(name[:80], known) or listing(map(printable, known), "known")
            span = element.place(attribute) if attribute else element.span
            raise SdfError(f"{self._described()} has no frame {printable(name[:80])!r}", span, near)
        return found

    def child_of(self, joint: Element) -> SdfFrame:
        """Return the frame that a joint's `<child>` names.

        Raises:
            SdfError: there is none.
        """
        child = joint.first("child")
        if child is None or not text_at(joint, "child"):
            raise SdfError(f"joint {printable(joint.get('name'))!r}: no <child>", joint.span)
        return self.require(child.text, child)

    def canonical_link(self) -> SdfFrame:
        """Return the link that a model's frame is attached to: the one that it names, else its first.

        Raises:
            SdfError: it has no link.
        """
        if name := self.element.get("canonical_link"):
            return self.require(name, self.element, "canonical_link")
        found = next((link for scope in self.walk() for link in scope.links.values()), None)
        if found is None:
            raise SdfError(f"{self._described()} has no link", self.element.span)
        return found

    def _described(self) -> str:
        return f"{self.element.tag} {printable(self.name)!r}"


def relative_to(element: Element, scope: Scope) -> SdfFrame | None:
    """Return the frame that the `<pose>` of an element names; None if it names none.

    Raises:
        SdfError: the frame does not exist.
    """
    pose = element.first("pose")
    if pose is None:
        return None
    attribute = "relative_to" if scope.version >= FIRST_WITH_FRAMES or "relative_to" in pose.attributes else "frame"
    name = pose.get(attribute)
    return scope.require(name, pose, attribute) if name else None


def place_of(element: Element, frame: SdfFrame) -> Pose:
    """Return the pose of an element in a link, such as a collision, in the outermost scope.

    Args:
        element: with an optional `<pose>`.
        frame: of the link that holds it.
    """
    base = relative_to(element, frame.scope) or frame
    return compose(base.place, pose_of(element.first("pose")))
