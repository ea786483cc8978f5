"""Data model of a robot file that will be written, with remarks on carried over, guessed and lost values."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.robot_description import WORLD, RobotDescription
from graphengine.descriptions.robot_files import entries
from graphengine.descriptions.robot_files.entries import Entry
from graphengine.descriptions.rollers import NO_ROLLERS, Rollers
from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Document, load
from graphengine.format.files import shipped
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import did_you_mean, printable
from graphengine.format.yaml_text import Reference

ALIGNED = 0.99
"""Minimum cosine of the angle between two axes that count as parallel."""
SECTIONS = ("joints", "links", "wheel_colliders", "materials", "sensors", "graphs")
"""Sections of a robot file, in its order."""


def rounded(number: float, digits: int = 7) -> float:
    """Return a number rounded to the given number of significant digits; -0.0 becomes 0.0."""
    return float(f"{number:.{digits}g}") + 0.0


Claim = Mapping[tuple[str, ...], Any]
"""Values of a robot file by the path of their keys; None stands for a missing key, and `...` for any value.

The path `("friction", LINK)` stands for the friction of a link, along and across its direction.
"""


def in_path(link: str) -> str:
    """Return the name of a link as part of a prim path; only a name with slashes differs from it."""
    return prim_name(link) if "/" in link else link


@cache
def shipped_graph(use: str) -> Any:
    """Return the data of a graph that ships with the package."""
    graph = load(shipped() / use, Findings())
    assert graph is not None
    return graph.data


def graph_defaults(use: str) -> dict[str, Any]:
    """Return the default values of the parameters of a graph that ships with the package."""
    return {name: declared["default"] for name, declared in shipped_graph(use)["parameters"].items()}


def no_joint(description: RobotDescription, name: str) -> str:
    """Return the message that a description has no joint `name`, with a suggestion of similar names."""
    near = did_you_mean(name, description.joints)
    return f"the description has no joint {printable(name)!r}" + (f"; {near}" if near else "")


@dataclass(frozen=True, slots=True)
class Remark:
    """A remark of an import, for its report.

    Attributes:
        text: the remark, one line.
        span: source location to which the remark refers; None if it refers to no single place.
        claim: values that the robot file must contain, or else `Draft.settle` drops the remark; empty if it needs none.
        subject: noun and name of the part that the text describes. `Draft.settle` puts them before the text, and combines
            remarks with the same noun and text. Empty if the text is complete.
    """

    text: str
    span: Span | None = None
    claim: Claim = field(default_factory=dict)
    subject: tuple[str, str] | tuple[()] = ()

    def holds(self, data: Mapping[str, Any]) -> bool:
        """Return whether a robot file has the values of the claim."""
        materials = data.get("materials", {}).values()
        frictions = [(each["static_friction"], each.get("across", each["static_friction"])) for each in materials]
        bound = {link: one for one, each in zip(frictions, materials, strict=True) for link in each["bind"]}
        found = ((_value_at({**data, "friction": bound}, path), value) for path, value in self.claim.items())
        return all(one is not None if value is ... else one == value for one, value in found)


@dataclass(frozen=True, slots=True)
class RobotWheel:
    """A wheel found in a description, with all joints at zero.

    Attributes:
        joint: name of the joint that turns the wheel.
        link: name of the link with the wheel's collider.
        radius: radius of the collider, m; with rollers, the radius with which they roll.
        width: width of the collider, m.
        offset: distance of the collider's centre from the joint along the joint's axis, m.
        axle: axis of the joint in the frame of the root link; if it points left, the wheel rolls forward at positive speed.
        centre: centre of the collider in the frame of the root link, m.
        collider: tag of the collider's shape in the description, such as `cylinder`.
        on_floor: whether the wheel reaches down to the lowest collider of the robot.
        swivels: whether the wheel's fork turns on a vertical joint without limits, as in a caster.
        rollers: rollers of an omni or mecanum wheel; empty if the description does not model them.
        drags: whether the wheel has no drive and rolls across the direction in which the base drives, so it slides.
        swivel: name of the joint with a vertical axis that steers the wheel; empty without such a joint, and in `Draft.wheels`.
        caster: whether the swivel turns freely: its wheel trails, or it is limitless and has no counterpart on the other side.
    """

    joint: str
    link: str
    radius: float
    width: float
    offset: float
    axle: Vector3
    centre: Vector3
    collider: str
    on_floor: bool
    swivels: bool = False
    rollers: Rollers = NO_ROLLERS
    drags: bool = False
    swivel: str = ""
    caster: bool = False

    @property
    def sideways(self) -> bool:
        """Whether the axle is parallel to the y axis of the root link; the wheel then rolls forward and backward."""
        return abs(self.axle[1]) > ALIGNED

    @property
    def sign(self) -> float:
        """1 if the wheel rolls forward at positive joint speed, else -1."""
        return 1.0 if self.axle[1] > 0 else -1.0


@dataclass(slots=True, eq=False)
class Draft:
    """A robot file that will be written.

    Attributes:
        description: the parsed description.
        name: name of the robot.
        source: where the description comes from, as text for comments and messages.
        path: path of the description, as written in the robot file.
        package_paths: folders of the description's packages, as written in the robot file.
        fixed_base: whether the root link is fixed to the world.
        controllers: ros2_control parameter file that the user names; None without one.
        position_drives: whether joints that take efforts get position drives.
        library: reads the meshes; None if the draft is only for a description without a robot file.
        wheels: wheels by joint, in order of the joints.
        standing: height (m) in the root link's frame of the lowest point of each link that reaches down to the floor.
        servos: joints with position drives whose gains are not in the description.
        settings: top-level keys with plain values, such as `self_collision`.
        joints: changes to each moving joint, by name.
        links: changes to links, by name.
        wheel_colliders: colliders of wheels, by link.
        materials: materials, by name.
        sensors: sensors, by name.
        graphs: graphs, by name.
        carried: remarks on values that were taken from the description.
        guessed: remarks on values that the description lacks and that the import chose.
        lost: remarks on parts of the description that a robot file cannot express, with the reason.
        pushed: whether a plugin of Gazebo pushes the base without turning its wheels.
        choice: keys of the robot file that say what to read of a USD stage.
        second_frictions: Gazebo's friction `mu2` of links for which it has no direction, by link.
        controller_track: whether the track of a skid-steered base was taken from its controller; None for other bases.
        guessed_turn: whether the limit of the turn rate of a skid-steered base is guessed.
        noticed: remarks on the robot itself, e.g. that part of its weight rests on the chassis.
        commanded: names of the joints that a topic commands, without the joints of a mobile base.
        mujoco_warnings: MuJoCo's warnings about models compiled from the draft, as keys; the values are None.
    """

    description: RobotDescription
    name: str
    source: str
    path: str
    package_paths: Sequence[str] = ()
    fixed_base: bool = False
    controllers: Document | None = None
    library: Library | None = None
    position_drives: bool = False
    wheels: dict[str, RobotWheel] = field(default_factory=dict)
    standing: dict[str, float] = field(default_factory=dict)
    servos: list[str] = field(default_factory=list)
    settings: dict[str, Any] = field(default_factory=dict)
    joints: dict[str, Entry[entries.JointKeys]] = field(init=False)
    links: defaultdict[str, Entry[entries.LinkKeys]] = field(default_factory=lambda: defaultdict(lambda: Entry({})))
    wheel_colliders: dict[str, Entry[entries.WheelCollider]] = field(default_factory=dict)
    materials: dict[str, Entry[entries.MaterialKeys]] = field(default_factory=dict)
    sensors: dict[str, Entry[entries.SensorKeys]] = field(default_factory=dict)
    graphs: dict[str, Entry[entries.GraphKeys]] = field(default_factory=dict)
    carried: list[Remark] = field(default_factory=list)
    guessed: list[Remark] = field(default_factory=list)
    lost: list[Remark] = field(default_factory=list)
    noticed: list[Remark] = field(default_factory=list)
    commanded: list[str] = field(default_factory=list)
    controller_track: bool | None = None
    guessed_turn: bool = False
    pushed: bool = False
    choice: dict[str, Any] = field(default_factory=dict)
    second_frictions: dict[str, float] = field(default_factory=dict)
    mujoco_warnings: dict[str, None] = field(default_factory=dict)
    _used: dict[int, Element] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Create an entry for each moving joint."""
        self.joints = {joint.name: Entry({}) for joint in self.description.moving()}

    def bound(self) -> dict[str, entries.MaterialKeys]:
        """Return the material of each link to which the draft binds one."""
        return {link: entry.value for entry in self.materials.values() for link in entry.value["bind"]}

    def unbind(self, material: str, links: Collection[str]) -> None:
        """Unbind links from a material, and remove the material if no link is left."""
        value = self.materials[material].value
        value["bind"] = [link for link in value["bind"] if link not in links]
        if not value["bind"]:
            del self.materials[material]

    def data(self) -> dict[str, Any]:
        """Return the values of the robot file, in its order; texts in which readers substitute nothing are `Reference`s."""
        description = self.description
        key = "mjcf" if description.mjcf is not None else "usd" if description.usd is not None else "urdf"
        path = {key: Reference(self.path), **self.choice}
        head: dict[str, Any] = {"format": 1, "robot": Reference(self.name)} | path
        if self.package_paths:
            head["package_paths"] = [Reference(folder) for folder in self.package_paths]
        head["base_link"] = Reference(description.root)
        if self.fixed_base and description.moves_freely and description.root != WORLD:
            head["fixed_base"] = True
        sections = {name: {key: each.value for key, each in getattr(self, name).items()} for name in SECTIONS}
        return head | self.settings | {name: section for name, section in sections.items() if section}

    def settle(self) -> None:
        """Drop remarks whose claims no longer hold, because the import has changed the entry since, and combine similar remarks.

        Remarks with the same noun and text become one remark with the names of all their parts.
        """
        data = self.data()
        for remarks in (self.carried, self.guessed, self.lost, self.noticed):
            alike: dict[Any, list[Remark]] = {}
            for number, remark in enumerate(remarks):
                if remark.holds(data):
                    alike.setdefault((remark.subject[0], remark.text) if remark.subject else number, []).append(remark)
            remarks[:] = map(_combined, alike.values())

    def add_graph(self, name: str, use: str, parameters: dict[str, Any], *comments: str) -> None:
        """Add a graph that the robot file uses.

        If the root link is not called `base_link`, the default of the graphs, its name is passed as the parameter `base`.

        Args:
            name: name of the graph in the robot file.
            use: reference to the included graph.
            parameters: parameters of the graph.
            comments: comment lines above the entry.
        """
        if self.description.root != "base_link":  # the default of the graphs
            parameters = {"base": in_path(self.description.root)} | parameters
        value: entries.GraphKeys = {"use": use, "parameters": parameters} if parameters else {"use": use}
        self.graphs[name] = Entry(value, list(comments))

    def carry(self, text: str, span: Span | None = None, claim: Claim | None = None) -> None:
        """Add a remark on a value that was taken from the description."""
        self.carried.append(Remark(text, span, claim or {}))

    def guess(self, text: str, span: Span | None = None, claim: Claim | None = None) -> None:
        """Add a remark on a value that the description lacks and that the import chose."""
        self.guessed.append(Remark(text, span, claim or {}))

    def remark(self, text: str, span: Span | None, claim: Claim, *, guessed: bool) -> None:
        """Add a remark on a value that the import chose, or else took from the description."""
        (self.guess if guessed else self.carry)(text, span, claim)

    def lose(self, text: str, span: Span | None = None) -> None:
        """Add a remark on a part of the description that a robot file cannot express, with the reason."""
        self.lost.append(Remark(text, span))

    def notice(self, text: str, span: Span | None = None) -> None:
        """Add a remark on the robot itself."""
        self.noticed.append(Remark(text, span))

    def use(self, element: Element) -> None:
        """Mark an element of the description and all elements below it as used. Used elements are not reported as lost."""
        self._used.update((id(part), part) for part in element.walk())

    def use_parts(self, element: Element, *tags: str) -> None:
        """Mark the children of an element with the given tags as used."""
        for child in element.children:
            if child.tag in tags:
                self.use(child)

    def used(self, element: Element) -> bool:
        """Return whether an element of the description is marked as used."""
        return id(element) in self._used


def _combined(remarks: Sequence[Remark]) -> Remark:
    """Return one remark for remarks with the same text on several parts; it claims the values that they claim together."""
    first = remarks[0]
    if not first.subject:
        return first
    names = ", ".join(dict.fromkeys(remark.subject[1] for remark in remarks if remark.subject))
    text = f"{first.subject[0]}{'s' if len(remarks) > 1 else ''} {names}: {first.text}"
    return Remark(text, first.span, {path: value for remark in remarks for path, value in remark.claim.items()})


def _value_at(data: Any, path: Sequence[str]) -> Any:
    """Return the value at a path of keys; None if the data has no such key."""
    for key in path:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data
