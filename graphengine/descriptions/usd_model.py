"""The physics of a USD stage as plain data in SI units with z up, as its confined process returns it, and a robot in it."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal

from graphengine.devices.rotation import NOWHERE, Pose, Vector3
from graphengine.format.diagnostics import Span

Kind = Literal["box", "sphere", "cylinder", "capsule", "mesh", "plane"]
_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}
"""Number of sizes of each form."""


@dataclass(slots=True)
class StageShape:
    """A geometric prim of a body, or of the world.

    Attributes:
        path: path of the prim.
        kind: form; forms that have no other name are meshes. A plane is endless.
        sizes: edges of a box, or radius and length of a sphere, cylinder or capsule about z, m; empty for others.
        pose: pose in the world.
        mesh: index of the mesh in `PhysicsContents.meshes`; -1 for other forms.
        approximation: `physics:approximation` of a mesh collider.
        solid: whether it collides; else it is only drawn.
        colour: red, green, blue and opacity from 0 to 1; None without a material or display colour.
        material: path of the physics material; empty without one.
        mass: mass that its own MassAPI gives, kg; 0 without one.
        density: density by its own MassAPI, else by its material, kg/m3; 0 without one.
        outranks: whether its own MassAPI gives the density, which then replaces the density of the body.
    """

    path: str
    kind: Kind
    sizes: list[float]
    pose: Pose = NOWHERE
    mesh: int = -1
    approximation: str = ""
    solid: bool = False
    colour: tuple[float, float, float, float] | None = None
    material: str = ""
    mass: float = 0.0
    density: float = 0.0
    outranks: bool = False


@dataclass(slots=True)
class StageBody:
    """A prim with RigidBodyAPI.

    Attributes:
        path: path of the prim.
        pose: pose in the world.
        mass: mass, kg; 0 if the stage leaves it to the shapes.
        density: density of its shapes, kg/m3; 0 if it is not given.
        centre: centre of mass in the frame of the body, m; None if it is not given.
        moments: principal moments of inertia, kg m2; None if they are not given.
        axes: rotation from the principal axes to the frame of the body.
        shapes: shapes of the body.
        gravity: whether gravity acts on it.
        kinematic: whether it is not moved by forces.
    """

    path: str
    pose: Pose
    mass: float = 0.0
    density: float = 0.0
    centre: Vector3 | None = None
    moments: Vector3 | None = None
    axes: tuple[float, float, float, float] = NOWHERE[1]
    shapes: list[StageShape] = field(default_factory=list)
    gravity: bool = True
    kinematic: bool = False


@dataclass(slots=True)
class StageDrive:
    """A DriveAPI in SI units; `acceleration` means that the gains are for a unit of inertia."""

    stiffness: float = 0.0
    damping: float = 0.0
    max_force: float | None = None
    position: float = 0.0
    velocity: float = 0.0
    acceleration: bool = False


@dataclass(slots=True)
class StageJoint:
    """A joint of UsdPhysics.

    Attributes:
        path: path of the prim.
        kind: type of the joint: revolute, prismatic, fixed, or another that is not simulated.
        bodies: paths of the two bodies; empty for the world.
        frames: pose in the world of the joint's frame on each body.
        axis: axis in the frame of the joint.
        lower, upper: limits, rad or m; None without limits.
        enabled: whether the joint holds its bodies.
        in_tree: whether an articulation may contain the joint.
        drive: its drive; None without one.
        armature: inertia of the rotor, kg m2 or kg.
        friction, damping: friction, N m or N, and viscous friction, N m s/rad or N s/m.
        max_velocity: maximum velocity, rad/s or m/s; None without one.
        leader: path of the joint that it mimics; empty without one.
        multiplier, offset: its position is the leader's times `multiplier`, plus `offset` in rad or m.
        position: position by JointStateAPI, rad or m; None if it is not given.
        remarks: properties that are not simulated.
    """

    path: str
    kind: str
    bodies: tuple[str, str]
    frames: tuple[Pose, Pose]
    axis: Vector3 = (1.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    enabled: bool = True
    in_tree: bool = True
    drive: StageDrive | None = None
    armature: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    max_velocity: float | None = None
    leader: str = ""
    multiplier: float = 1.0
    offset: float = 0.0
    position: float | None = None
    remarks: list[str] = field(default_factory=list)


@dataclass(slots=True)
class StageMaterial:
    """A physics material: friction coefficients, restitution, and the rule that combines the friction of a contact."""

    static_friction: float = 0.0
    dynamic_friction: float = 0.0
    restitution: float = 0.0
    combine: str = "average"


@dataclass(slots=True)
class StageCommand:
    """An ArticulationController: its path, its target prim, the kinds of its commands, and the names of its joints, if known."""

    path: str
    target: str
    kinds: list[str]
    joints: list[str] = field(default_factory=list)


@dataclass(slots=True)
class StageSensor:
    """A sensor of the stage.

    Attributes:
        path: path of the prim.
        type: type of the device, as in robot files.
        body: path of the body that carries it; empty for the world.
        pose: pose in the world.
        mount: path of the prim directly below the body that contains it.
        model: name of the sensor's configuration, such as `SICK_microScan3`; empty without one.
        focal, aperture: focal length of a camera, and width and height of its picture, in the same unit.
    """

    path: str
    type: str
    body: str
    pose: Pose
    mount: str
    model: str = ""
    focal: float = 0.0
    aperture: tuple[float, float] = (0.0, 0.0)


@dataclass(slots=True)
class StageLight:
    """A light; kinds are those of MuJoCo, and `ambient`. It shines along its -z axis."""

    path: str
    kind: str
    pose: Pose
    colour: Vector3


@dataclass(slots=True)
class PhysicsContents:
    """The physics of a stage.

    Attributes:
        bodies: rigid bodies by path, in stage order.
        joints: joints by path, in stage order.
        shapes: shapes that belong to no body.
        roots: paths of the prims with ArticulationRootAPI, and for each whether its links collide with each other.
        materials: physics materials by path.
        commands: controllers in the graphs of the stage.
        sensors: sensors.
        lights: visible lights.
        gravity: gravity of the first physics scene, m/s2.
        meshes: meshes in MuJoCo's MSH format, Base64.
        namespaces, names: values of `isaac:namespace` and of `isaac:nameOverride` by path.
        textured: path of a prim whose colour is a picture; empty without one.
        assumed: units and axes that the stage does not state, as they are assumed.
        left_out: pairs (path, reason) of the parts that could not be read.
        failure: reason why nothing was read; empty if the stage was read.
        used: paths of the files that were read.
        choices: variant selections, such as `/World: ros = none, of none, ros2`.
    """

    bodies: dict[str, StageBody] = field(default_factory=dict)
    joints: dict[str, StageJoint] = field(default_factory=dict)
    shapes: list[StageShape] = field(default_factory=list)
    roots: dict[str, bool] = field(default_factory=dict)
    materials: dict[str, StageMaterial] = field(default_factory=dict)
    commands: list[StageCommand] = field(default_factory=list)
    sensors: list[StageSensor] = field(default_factory=list)
    lights: list[StageLight] = field(default_factory=list)
    gravity: Vector3 | None = None
    meshes: list[str] = field(default_factory=list)
    namespaces: dict[str, str] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    textured: str = ""
    assumed: list[str] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)
    failure: str = ""
    used: list[str] = field(default_factory=list)
    choices: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Check that the parts fit together, because a process that was taken over may send anything; raise ValueError."""
        paths = {"", *self.bodies}
        shapes = [shape for body in self.bodies.values() for shape in body.shapes] + self.shapes
        fit = "" not in self.bodies
        fit = fit and all(path == each.path for known in (self.bodies, self.joints) for path, each in known.items())
        fit = fit and paths.issuperset(path for joint in self.joints.values() for path in joint.bodies)
        fit = fit and all(len(shape.sizes) == _SIZES.get(shape.kind, 0) for shape in shapes)
        fit = fit and all(0 <= shape.mesh < len(self.meshes) for shape in shapes if shape.kind == "mesh")
        fit = fit and all(shape.material in self.materials for shape in shapes if shape.material)
        for mesh in self.meshes:
            base64.b64decode(mesh, validate=True)
        if not (fit and all(map(math.isfinite, _numbers(self)))):
            raise ValueError(self)


def _numbers(part: Any) -> Iterator[float]:
    """Yield all numbers in dataclasses and collections."""
    if isinstance(part, float):
        yield part
    elif is_dataclass(part):
        for each in fields(part):
            yield from _numbers(getattr(part, each.name))
    elif isinstance(part, dict | list | tuple):
        for item in part.values() if isinstance(part, dict) else part:
            yield from _numbers(item)


@dataclass(slots=True)
class StatedDrive(StageDrive):
    """What a stage says about the drive of a joint of a robot, with gains for the inertia that the joint moves.

    Attributes:
        commands: kinds of commands that the graphs of the stage give it.
        controllers: paths of the nodes that give them.
        armature: inertia of the rotor, kg m2 or kg.
        start: position in the stage, rad or m.
    """

    commands: list[str] = field(default_factory=list)
    controllers: list[str] = field(default_factory=list)
    armature: float = 0.0
    start: float = 0.0


@dataclass(slots=True)
class UsdModel:
    """A robot of a stage.

    Attributes:
        prim: path of the prim that stands for the robot.
        paths: path of the prim of each link and joint, by name.
        meshes: meshes in MuJoCo's MSH format, by the reference that its shapes have.
        files: files of the stage.
        fixed: whether a joint fixes the root link to the world.
        pose: pose of the root link in the stage.
        self_collision: whether its links collide with each other.
        drives: what the stage says about the drives of moving joints, by name.
        materials: physics materials by name, each with the links whose colliders have it.
        sensors: sensors by name; instead of a body and a pose in the world, they have the name of a link and their pose there.
        articulation_root: link that Isaac Sim takes for the root, because a disabled joint fastens the root to it; else empty.
        weightless: links on which gravity does not act.
        namespaces: values of `isaac:namespace`, by name of the link; `""` stands for the robot.
        overrides: values of `isaac:nameOverride`, by name of the link.
        remarks: remarks on parts that are changed or not simulated: whether lost, path of the prim, text, and place.
    """

    prim: str
    paths: dict[str, str] = field(default_factory=dict)
    meshes: Mapping[str, bytes] = field(default_factory=dict)
    files: Sequence[Path] = ()
    fixed: bool = False
    pose: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    self_collision: bool = False
    drives: dict[str, StatedDrive] = field(default_factory=dict)
    materials: dict[str, tuple[StageMaterial, list[str]]] = field(default_factory=dict)
    sensors: dict[str, StageSensor] = field(default_factory=dict)
    articulation_root: str = ""
    weightless: list[str] = field(default_factory=list)
    namespaces: dict[str, str] = field(default_factory=dict)
    overrides: dict[str, str] = field(default_factory=dict)
    remarks: list[tuple[bool, str, str, Span]] = field(default_factory=list)
