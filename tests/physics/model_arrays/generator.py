"""Generates robots from a seed: a URDF text with meshes and a robot file, which differ in all that MuJoCo's arrays depend on.

Only `random.Random.random` is used, whose values are the same in every Python version.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from tests.physics.model_arrays import mesh_texts

T = TypeVar("T")
COUNT = 60
"""Number of seeds."""
ROOTS = ("base_link", "world", "floating", "footprint", "static")
"""Kinds of root links: a link with mass, a link `world`, an empty link above a floating or fixed joint, and a static robot."""
QUARTER, HALF = "1.5707963267948966", "3.141592653589793"
TURNS = (
    "0 0 0",
    f"0 0 {QUARTER}",
    f"{QUARTER} 0 0",
    f"0 {QUARTER} 0",
    f"-1.57 0 {HALF}",
    f"{HALF} 0 0",
    "0 1.5708 -.7854",
)
AXES = (
    "0 0 1",
    "0 1 0",
    "1 0 0",
    "0 0 -1",
    "0 -1 0",
    "-1 0 0",
    "0 0 2",
    "1 1 0",
    "-0.3 0.5 0.2",
    "1e-3 0 0",
    "0 .6 -.8",
)
"""Axes; some are mirrored, some are no unit vectors."""
COLOURS = ("0.8 0.1 0.1 1", "0 .5 1 0.5", "0.33 0.66 0.99 1.0", "1 1 1 1", "0.123456789 0.2 0.3 1")
SCALES = ("", "", "1 1 1", "0.5 0.5 0.5", "1 -1 1", "-1 -1 -1", "2 0.5 1.25", "-0.7 1.1 1")
COMPILERS = (
    "",
    '<mujoco><compiler balanceinertia="true"/></mujoco>',
    '<mujoco><compiler boundmass="0.05" boundinertia="0.002"/></mujoco>',
    '<mujoco><compiler inertiafromgeom="true"/></mujoco>',
    '<mujoco><compiler inertiafromgeom="false" boundmass=".01" boundinertia="1e-4" discardvisual="true"/></mujoco>',
    '<mujoco><compiler balanceinertia="true"/></mujoco><mujoco><compiler boundmass="0.1" meshdir="nowhere"/></mujoco>',
)
GAZEBO = (
    '<gazebo reference="{0}"><mu1>0.2</mu1><mu2>0.3</mu2><kp>1e6</kp><material>Gazebo/Red</material></gazebo>',
    '<gazebo reference="{0}"><mu>1.5</mu><turnGravityOff>true</turnGravityOff><selfCollide>true</selfCollide></gazebo>',
    '<gazebo><plugin filename="libgazebo_ros_p3d.so" name="p3d"><bodyName>{0}</bodyName></plugin></gazebo>',
)
SENSORS = ("imu", "lidar, profile: lidar_360", "contact", "range, profile: hc_sr04", "realsense_d455")
"""Types of sensors, with profiles where a type needs one."""


@dataclass(slots=True)
class Link:
    """A link of the tree: its name, its children in the XML, and whether it has mass and colliders."""

    name: str
    parts: list[str] = field(default_factory=list)
    mass: float = 0.0
    shapes: list[str] = field(default_factory=list)


@dataclass(slots=True)
class Joint:
    """A joint of the tree."""

    name: str
    kind: str
    parent: str
    child: str
    text: str
    mimics: bool = False
    limits: tuple[float, float] | None = None


class Generator:
    """Writes one robot. A feature that many seeds should have is chosen by the seed itself, all others at random."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self._random = random.Random(seed).random
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.root = ROOTS[seed % len(ROOTS)]
        self.fixed = self.chance(0.3)
        self.meshes = self._mesh_files()

    def _mesh_files(self) -> dict[str, bytes]:
        """Return meshes that MuJoCo reads; for one seed in eight also some that must be converted."""
        stretch = 1.0 + self.seed / 100
        found = {
            "part.stl": mesh_texts.binary_stl(mesh_texts.solid(stretch)),
            "part.obj": mesh_texts.obj(mesh_texts.solid(1 / stretch)),
        }
        if self.seed % 8 == 3:
            found |= {
                "text.stl": mesh_texts.ascii_stl(mesh_texts.solid(2.0)),
                "two.dae": mesh_texts.dae(),
                "flat.stl": mesh_texts.ascii_stl(mesh_texts.FLAT),
            }
        return found

    def chance(self, share: float) -> bool:
        """Return True with a probability."""
        return self._random() < share

    def one_of(self, items: Sequence[T]) -> T:
        """Return one of some items."""
        return items[int(self._random() * len(items))]

    def mixed(self, items: Sequence[T]) -> list[T]:
        """Return items in another order."""
        return [item for _, _, item in sorted((self._random(), index, item) for index, item in enumerate(items))]

    def between(self, low: float, high: float, digits: int = 4) -> float:
        """Return a number with some digits after the point."""
        return round(low + (high - low) * self._random(), digits)

    def three(self, reach: float) -> str:
        """Return three numbers, sometimes with all their digits or in an unusual notation."""
        if self.chance(0.1):
            return "  1e-2   -.05\n  +0.125 "
        digits = 17 if self.chance(0.2) else 4
        return " ".join(repr(self.between(-reach, reach, digits)) for _ in range(3))

    def origin(self, reach: float = 0.3) -> str:
        """Return an `origin`, or nothing."""
        kind = self._random()
        turn = self.one_of(TURNS) if self.chance(0.5) else self.three(3.0)
        if kind < 0.15:
            return ""
        if kind < 0.3:
            return f'<origin xyz="{self.three(reach)}"/>'
        if kind < 0.4:
            return f'<origin rpy="{turn}"/>'
        return f'<origin xyz="{self.three(reach)}" rpy="{turn}"/>'

    # Links

    def inertial(self, link: Link, *, needed: bool) -> str:
        """Return an `inertial`: mostly possible, sometimes impossible, incomplete, or nothing."""
        kind = self._random()
        if kind < 0.2 and not needed:
            return ""
        link.mass = self.between(0.05, 5.0)
        mass = f'<mass value="{link.mass}"/>'
        if kind < 0.27:
            return f"<inertial>{self.origin(0.05)}{mass}</inertial>"
        if kind < 0.34:
            return f'<inertial>{mass}<inertia ixx="0.3" iyy="0.001" izz="0.001" ixy="0" ixz="0.01" iyz="0"/></inertial>'
        if kind < 0.4 and not needed:
            link.mass = 0.0
            return f'<inertial><mass value="0"/>{self._inertia(0.0)}</inertial>'
        return f"<inertial>{self.origin(0.05)}{mass}{self._inertia(link.mass)}</inertial>"

    def _inertia(self, mass: float) -> str:
        """Return the inertia of points of the given mass, so that it is possible; two thirds have products of inertia."""
        terms = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), 0.0)
        for _ in range(6):
            x, y, z = (self.between(-0.1, 0.1) for _ in range(3))
            share = mass / 6
            for name, value in (("ixx", y * y + z * z), ("iyy", x * x + z * z), ("izz", x * x + y * y)):
                terms[name] += share * value
            for name, value in (("ixy", -x * y), ("ixz", -x * z), ("iyz", -y * z)):
                terms[name] += share * value
        if self.chance(0.3):
            terms |= {"ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
        written = {name: f"{value:.6g}" if self.chance(0.5) else repr(value) for name, value in terms.items()}
        return "<inertia " + " ".join(f'{name}="{value}"' for name, value in written.items()) + "/>"

    def shape(self, *, solid: bool) -> str:
        """Return a shape; some are placeholders with a size of zero."""
        zero = self.chance(0.06)
        size = 0.0 if zero else self.between(0.01, 0.3)
        other, third = self.between(0.01, 0.3), self.between(0.01, 0.3)
        kind = self._random()
        if kind < 0.25:
            return f'<box size="{other} {size} {third}"/>'
        if kind < 0.45:
            return f'<cylinder radius="{other}" length="{size}"/>'
        if kind < 0.55:
            return f'<sphere radius="{size}"/>'
        if kind < 0.65:
            return f'<capsule radius="{size}" length="{other}"/>'
        usable = [name for name in self.meshes if not (solid and name == "two.dae")]
        scale = self.one_of(SCALES)
        name = self.one_of(usable)
        folder = self.one_of(("meshes/", "package://bot/meshes/", "file://meshes/"))
        return f'<mesh filename="{folder}{name}"' + (f' scale="{scale}"' if scale else "") + "/>"

    def material(self) -> str:
        """Return the material of a visual: by name, with a colour, with a texture, or nothing."""
        kind = self._random()
        if kind < 0.2:
            return ""
        if kind < 0.45:
            return f'<material name="{self.one_of(("early", "late", "inside", "unknown"))}"/>'
        if kind < 0.6:
            return f'<material name="inside"><color rgba="{self.one_of(COLOURS)}"/></material>'
        if kind < 0.7:
            return '<material name="wood"><texture filename="package://nowhere/wood.png"/></material>'
        if kind < 0.8:
            return f'<material name=""><color rgba="{self.one_of(COLOURS)}"/></material>'
        return f'<material name="own{int(5 * self._random())}"><color rgba="{self.one_of(COLOURS)}"/></material>'

    def geometry(self, tag: str, link: Link) -> str:
        """Return a collider or visual."""
        shape = self.shape(solid=tag == "collision")
        if tag == "collision":
            link.shapes.append(shape[1:].partition(" ")[0])
        name = self.one_of(("", ' name="part"', f' name="{link.name}"'))
        material = self.material() if tag == "visual" else ""
        return f"<{tag}{name}>{self.origin()}<geometry>{shape}</geometry>{material}</{tag}>"

    def link(self, name: str, *, bare: bool = False) -> Link:
        """Add a link, with all its parts in any order unless it is only a frame."""
        link = Link(name)
        self.links.append(link)
        if bare or (name != "body" and self.chance(0.15)):
            return link
        needed = name == "body"
        shapes = [self.geometry(tag, link) for tag in ("collision", "visual") for _ in range(int(3.5 * self._random()))]
        parts = [self.inertial(link, needed=needed), *shapes]
        if self.chance(0.1):  # only the first counts
            parts.append(f'<inertial><mass value="9"/>{self._inertia(9.0)}</inertial>')
            link.parts = parts
        else:
            link.parts = self.mixed(parts)
        return link

    # Joints

    def joint(self, parent: str, child: str, kind: str = "") -> None:
        """Add a joint; by default of any type that moves, or fixed."""
        kind = kind or self.one_of(("revolute", "revolute", "continuous", "prismatic", "fixed", "fixed"))
        name = child if self.chance(0.2) else f"{child}_joint"
        made = Joint(name, kind, parent, child, "")
        axis = f'<axis xyz="{self.one_of(AXES)}"/>' if self.chance(0.85) else ""
        rest = [
            self.origin(),
            f'<parent link="{parent}"/>',
            f'<child link="{child}"/>',
            axis,
            self._limit(made),
            self._losses(),
        ]
        rest += [self._mimic(made), '<safety_controller k_velocity="10"/>' if self.chance(0.1) else ""]
        if self.chance(0.05):
            rest.append('<origin xyz="9 9 9"/>' if rest[0] else "")  # only the first counts
        else:
            rest = self.mixed(rest)
        made.text = f'<joint name="{name}" type="{kind}">{"".join(rest)}</joint>'
        self.joints.append(made)

    def _limit(self, joint: Joint) -> str:
        """Return the limits of a joint: mostly proper, sometimes swapped, equal, incomplete, or nothing."""
        kind, low, high = self._random(), self.between(-2.0, -0.1), self.between(0.1, 2.0)
        rest = f'effort="{self.between(0.0, 50.0)}" velocity="{self.one_of(("0", "1.5", "3.14159265359"))}"'
        if joint.kind == "continuous":
            return f"<limit {rest}/>" if kind < 0.5 else ""
        if kind < 0.1:
            return f'<limit lower="{high}" upper="{low}" {rest}/>'
        if kind < 0.2:
            return f'<limit lower="0.0" upper="0" {rest}/>'
        if kind < 0.25:
            return f"<limit {rest}/>"
        if kind < 0.3:
            return ""
        joint.limits = (low, high)
        if kind < 0.4:
            joint.limits = (0.0, high)
            return f'<limit upper="{high}" {rest}/>'
        if kind < 0.5:
            return f'<limit effort="30" lower="{low}" upper="{high}"/>'
        return f'<limit lower="{low}" upper="{high}" {rest}/>'

    def _losses(self) -> str:
        kind, damping, friction = self._random(), self.between(0.0, 2.0), self.between(0.0, 0.5)
        if kind < 0.4:
            return ""
        if kind < 0.6:
            return f'<dynamics damping="{damping}"/>'
        return (
            f'<dynamics friction="{friction}"/>'
            if kind < 0.7
            else f'<dynamics damping="{damping}" friction="{friction}"/>'
        )

    def _mimic(self, joint: Joint) -> str:
        """Return the law of a mimic joint; the leader is an earlier joint, which may be a mimic joint too."""
        leaders = [other.name for other in self.joints if other.kind in ("revolute", "continuous", "prismatic")]
        if not leaders or joint.kind == "fixed" or not self.chance(0.2):
            return ""
        joint.mimics = True
        law = self.one_of(("", ' multiplier="-1"', ' multiplier="0.5" offset="0.1"', ' offset="-.2"'))
        return f'<mimic joint="{self.one_of(leaders)}"{law}/>'

    # The whole

    def grow(self) -> None:
        """Make the tree: a body, links on it, chains of fixed joints with frames between, and a wheel."""
        if self.root != "base_link" and self.root != "static":
            name = {"world": "world", "floating": "map", "footprint": "base_footprint"}[self.root]
            self.link(name, bare=True)
            self.link("body")
            self.joint(name, "body", "floating" if self.root == "floating" else "fixed")
        else:
            self.link("body")
        for number in range(3 + int(6 * self._random())):
            tops = [link.name for link in self.links if link.name not in ("world", "map", "base_footprint")]
            parent = self.one_of(tops) if self.chance(0.5) else tops[-1]
            name = self.one_of(("link_{}", "arm.{}", "left link {}", "{}")).format(number)
            self.link(name)
            self.joint(parent, name)
        for number in range(int(4 * self._random())):
            self.link(f"frame_{number}", bare=number < 2)
            self.joint(self.links[-2].name, f"frame_{number}", "fixed")
        wheel = Link("wheel", mass=1.0, shapes=["cylinder"])
        shape = f'<origin rpy="{QUARTER} 0 0"/><geometry><cylinder radius="0.1" length="0.04"/></geometry>'
        wheel.parts = [f'<inertial><mass value="1"/>{self._inertia(1.0)}</inertial>', f"<collision>{shape}</collision>"]
        shown = [name for name in self.meshes if name not in ("part.stl", "part.obj")]
        wheel.parts += [f'<visual><geometry><mesh filename="meshes/{name}"/></geometry></visual>' for name in shown]
        self.links.append(wheel)
        text = '<parent link="body"/><child link="wheel"/><axis xyz="0 1 0"/>'
        joint = Joint(
            "wheel_joint",
            "continuous",
            "body",
            "wheel",
            f'<joint name="wheel_joint" type="continuous">{self.origin()}{text}</joint>',
        )
        self.joints.append(joint)

    def urdf(self) -> str:
        """Return the description; its links and joints are in the order of the tree only for one seed in three."""
        links = [f'<link name="{link.name}">{"".join(link.parts)}</link>' for link in self.links]
        joints = [joint.text for joint in self.joints]
        before = f'<material name="early"><color rgba="{self.one_of(COLOURS)}"/></material>'
        after = f'<material name="late"><color rgba="{self.one_of(COLOURS)}"/></material>'
        after += '<material name="early"><color rgba="0 0 0 1"/></material>' if self.chance(0.5) else ""
        if self.seed % 3:
            links, joints = self.mixed(links), self.mixed(joints)
        content = [*links, *joints] if self.chance(0.5) else [*joints, *links]
        extra = [COMPILERS[self.seed // 2 % len(COMPILERS)]] if self.seed % 2 else []
        extra += [self.one_of(GAZEBO).format(self.one_of(self.links).name) for _ in range(int(3 * self._random()))]
        extra += ["<gazebo><static>true</static></gazebo>"] if self.root == "static" else []
        extra += ['<transmission name="t"><type>SimpleTransmission</type></transmission>'] if self.chance(0.3) else []
        return "\n".join([f'<robot name="bot_{self.seed}">', before, *content, after, *extra, "</robot>\n"])

    def robot_file(self) -> str:
        """Return a robot file with drives, springs, materials, wheel colliders, sensors and other keys."""
        root = "body" if self.root == "floating" else self.links[0].name
        lines = ["robot: bot", "urdf: bot.urdf", f'base_link: "{root}"']
        lines += [f"fixed_base: {str(self.fixed).lower()}", f"self_collision: {str(self.chance(0.4)).lower()}"]
        lines += ["joints:", "  wheel_joint: {drive: {damping: 50.0}, armature: 0.005}"]
        lines += [f'  "{joint.name}": {{{entry}}}' for joint in self.joints for entry in self._keys(joint)]
        lines += [
            f"wheel_colliders: {{wheel: {self.one_of(('ellipsoid', 'as_urdf', '{radius: 0.1, width: 0.05, offset: 0.01}'))}}}"
        ]
        bound = [link.name for link in self.links if link.shapes][: 1 + int(2 * self._random())]
        friction = self.one_of(
            ("dynamic_friction: 0.3", "static_friction: 1.0, dynamic_friction: 0.9, combine: max", "restitution: 0.5")
        )
        lines += [f"materials: {{rubber: {{{friction}, bind: {bound}}}}}"]
        lines += ["links:", f'  "{self.links[-1].name}": {{gravity: false, colour: [0.2, 0.4, 0.6]}}']
        lines += [
            "sensors:",
            f'  sensor: {{type: {SENSORS[self.seed // 5 % len(SENSORS)]}, parent: "{self._path()}", position: [0.1, 0.0, 0.2]}}',
        ]
        return "\n".join([*lines, ""])

    def _keys(self, joint: Joint) -> Iterator[str]:
        """Yield the keys of a moving joint in the robot file, if it has some."""
        if joint.child == "body" and self.root == "footprint" and not self.fixed:
            yield "enabled: false"  # the body moves freely, and the root becomes a frame on it
        if joint.kind in ("fixed", "floating") or joint.name == "wheel_joint" or self.chance(0.3):
            return
        if self.chance(0.15) and not any(other.mimics for other in self.joints):
            yield "enabled: false, weld: true"
            return
        keys = [f"armature: {self.between(0.0, 0.1)}"] if self.chance(0.5) else []
        if not joint.mimics:
            drive = self.one_of(
                ("stiffness: 200, damping: 10", "damping: 5", "stiffness: 1e4, damping: 500, max_force: 20")
            )
            keys += [f"drive: {{{drive}}}"] if self.chance(0.6) else []
            keys += (
                [f"start: {round(joint.limits[1] / 2, 3)}"] if joint.limits is not None and self.chance(0.4) else []
            )  # within the limits below, too
        keys += ["limits: [-1.5, 1.25]"] if joint.kind != "continuous" and self.chance(0.2) else []
        keys += ["position: [0.05, -0.1, 0.2]"] if self.chance(0.2) else []
        keys += ["spring: {stiffness: 3.0, rest: 0.1}"] if self.chance(0.3) else []
        if keys:
            yield ", ".join(keys)

    def _path(self) -> str:
        """Return the path of the body in the tree."""
        return "body" if self.root in ("base_link", "static", "floating") else f"{self.links[0].name}/body"


def files(seed: int) -> Mapping[str, str | bytes]:
    """Return the files of a robot by path: the description, the robot file and the meshes."""
    generator = Generator(seed)
    generator.grow()
    urdf = generator.urdf()
    meshes = {f"meshes/{name}": data for name, data in generator.meshes.items()}
    return {"bot.urdf": urdf, "bot.yaml": generator.robot_file(), **meshes}
