"""The robot file that an import is going to write, while its parts fill it in."""

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
    """Return a number with some significant digits, as a robot file has it."""
    return float(f"{number:.{digits}g}") + 0.0


@dataclass(slots=True)
class Entry:
    """A key of the robot file with its value.

    Attributes:
        value: written on one line, or on one for each of its keys.
        comments: lines above the key.
        hint: a comment after the value.
    """

    value: Any = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Remark:
    """What an import says about one part of the description.

    Attributes:
        text: one line.
        span: where the description says it; None if it says nothing.
    """

    text: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class WheelShape:
    """A wheel as an import finds it, all joints at zero.

    Attributes:
        joint: that it turns on.
        link: that has its collider.
        radius: m.
        width: of its collider, m.
        offset: of its middle from the joint along the joint's axis, m.
        axis: of its joint, in the root link.
        centre: in the root link, m.
        collider: tag of its shape in the description.
        on_floor: whether it reaches down as far as the lowest collider of the robot does.
        swivels: whether a vertical joint without limits carries it, as that of a caster.
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
    """A robot file to be written.

    Attributes:
        urdf: the description.
        name: of the robot.
        source: where the description came from, for people.
        path: of the description, as the file names it.
        package_paths: folders of its packages, as the file names them.
        fixed_base: whether the root link is fixed to the world.
        controllers: parameters of ros2_control that the user gave.
        library: reads the meshes; None for a description that is not imported.
        wheels: by joint, in order of the joints.
        servos: joints whose drives hold a position, with gains that the description does not give.
        settings: keys at the top level of the file with plain values, such as `self_collision`.
        sections: entries by section (`joints`, `materials`, `sensors`, `graphs`, …) and key, in order of the file.
        carried: what the description says and the file repeats.
        guessed: what the description does not say and the file needs.
        lost: what the description says and the file cannot hold, with the reason.
        noticed: what the robot does as it is described, such as a weight that rests on its chassis.
        commanded: joints that a topic commands, apart from those of a base.
        mujoco_warnings: of the models that the draft was tried as, as keys.
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
        """Links that a material of the draft binds."""
        return {link for entry in self.sections["materials"].values() for link in entry.value.get("bind", ())}

    def entry(self, section: str, key: str) -> Entry:
        """Return the entry of a section with this key; a new one if there is none."""
        return self.sections[section].setdefault(key, Entry())

    def add_graph(self, name: str, use: str, parameters: dict[str, Any], *comments: str) -> None:
        """Use an included graph with the parameter `base`, the root link, and others; comments stand above it."""
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
