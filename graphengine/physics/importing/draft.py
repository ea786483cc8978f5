"""Data model of a robot file that an import is filling in."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Span
from graphengine.format.document import Document
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.files.references import Library
from graphengine.physics.files.xml import Element


def rounded(number: float, digits: int = 7) -> float:
    """Return a number rounded to a few significant digits, for a robot file."""
    return float(f"{number:.{digits}g}") + 0.0


@dataclass(slots=True)
class Entry:
    """A key of the robot file and its value.

    Attributes:
        value: plain data; a mapping is written with one line per key, other data on one line.
        comments: comment lines above the key.
        hint: comment after the value.
    """

    value: Any = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Remark:
    """A remark of an import about one part of the description.

    Attributes:
        text: the remark, one line.
        span: place in the description; None if the description has no such part.
    """

    text: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class WheelShape:
    """A wheel found in a description, with all joints at zero.

    Attributes:
        joint: name of the joint that turns it.
        link: name of the link with its collider.
        radius: radius of its collider, m.
        width: width of its collider, m.
        offset: offset of its middle from the joint along the joint's axis, m.
        axis: axis of its joint in the frame of the root link.
        centre: its middle in the frame of the root link, m.
        collider: tag of the shape in the description, such as `cylinder`.
        on_floor: whether it reaches as low as the lowest collider of the robot.
        swivels: whether its fork turns on a vertical joint without limits, as in a caster.
    """

    joint: str
    link: str
    radius: float
    width: float
    offset: float
    axis: Vector3
    centre: Vector3
    collider: str
    on_floor: bool
    swivels: bool = False


@dataclass(slots=True, eq=False)
class Draft:
    """A robot file that will be written.

    Attributes:
        urdf: the parsed description.
        name: name of the robot.
        source: origin of the description, for comments and messages.
        path: path of the description as written in the robot file.
        package_paths: folders of its packages as written in the robot file.
        fixed_base: whether the root link is fixed to the world.
        controllers: ros2_control parameters given by the user.
        library: reads the meshes; None for a description that is not imported.
        wheels: wheels by joint, in order of the joints.
        servos: joints with position drives whose gains are not in the description.
        settings: top-level keys with plain values, such as `self_collision`.
        sections: entries by section (`joints`, `materials`, `sensors`, `graphs`, …) and key, in file order.
        carried: remarks on what was taken from the description.
        guessed: remarks on values that the description lacks and the import chose.
        lost: remarks on parts of the description that a robot file cannot express, with the reason.
        noticed: remarks on the robot itself, such as a weight that rests on its chassis.
        commanded: joints commanded over a topic, except those of a mobile base.
        mujoco_warnings: MuJoCo's warnings about the models compiled from the draft, as keys.
    """

    urdf: Urdf
    name: str
    source: str
    path: str
    package_paths: Sequence[str] = ()
    fixed_base: bool = False
    controllers: Document | None = None
    library: Library | None = None
    wheels: dict[str, WheelShape] = field(default_factory=dict)
    servos: list[str] = field(default_factory=list)
    settings: dict[str, Any] = field(default_factory=dict)
    sections: defaultdict[str, dict[str, Entry]] = field(default_factory=lambda: defaultdict(dict))
    carried: list[Remark] = field(default_factory=list)
    guessed: list[Remark] = field(default_factory=list)
    lost: list[Remark] = field(default_factory=list)
    noticed: list[Remark] = field(default_factory=list)
    commanded: list[str] = field(default_factory=list)
    mujoco_warnings: dict[str, None] = field(default_factory=dict)
    _used: dict[int, Element] = field(default_factory=dict)

    def bound(self) -> set[str]:
        """Return links to which the draft binds a material."""
        return {link for entry in self.sections["materials"].values() for link in entry.value.get("bind", ())}

    def entry(self, section: str, key: str) -> Entry:
        """Return the entry of a section with this key; it is created if needed."""
        return self.sections[section].setdefault(key, Entry())

    def add_graph(self, name: str, use: str, parameters: dict[str, Any], *comments: str) -> None:
        """Add an included graph; its parameter `base` is the root link, unless that has the default name."""
        if self.urdf.root != "base_link":  # the default of the graphs
            parameters = {"base": self.urdf.root} | parameters
        value: dict[str, Any] = {"use": use} | ({"parameters": parameters} if parameters else {})
        self.sections["graphs"][name] = Entry(value, list(comments))

    def use(self, element: Element) -> None:
        """Mark an element of the description, and all in it, as used, so that it is not listed as left behind."""
        self._used.update((id(part), part) for part in element.walk())

    def used(self, element: Element) -> bool:
        """Return whether an element of the description was used."""
        return id(element) in self._used
