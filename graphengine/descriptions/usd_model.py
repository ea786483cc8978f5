"""What a USD stage says about a robot beyond links and joints: drives, commands, materials, sensors, and meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.devices.rotation import Pose
from graphengine.format.diagnostics import Span


@dataclass(frozen=True, slots=True)
class StatedDrive:
    """What a stage says about the drive of a joint.

    Attributes:
        stiffness: stiffness of its DriveAPI, N m/rad or N/m.
        damping: damping of its DriveAPI, N m s/rad or N s/m.
        max_force: limit of its DriveAPI, N m or N; None without one.
        position: target position, rad or m.
        velocity: target velocity, rad/s or m/s.
        commands: kinds of commands that the graphs of the stage give it.
        controllers: paths of the nodes that give them.
        armature: inertia of the rotor, kg m2 or kg.
        start: position in the stage, rad or m.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    max_force: float | None = None
    position: float = 0.0
    velocity: float = 0.0
    commands: tuple[str, ...] = ()
    controllers: tuple[str, ...] = ()
    armature: float = 0.0
    start: float = 0.0


@dataclass(frozen=True, slots=True)
class StatedMaterial:
    """A physics material of a stage, and the names of the links whose colliders have it."""

    static_friction: float
    dynamic_friction: float
    restitution: float
    combine: str
    links: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StatedSensor:
    """A sensor of a stage: its type as in robot files, the link that carries it, and its pose there.

    Attributes:
        path: path of its prim.
        type: type of the device.
        link: name of the link.
        pose: pose in the frame of the link.
        model: name of its configuration; empty without one.
        view: horizontal and vertical field of view of a camera, degrees; zeros for other sensors.
    """

    path: str
    type: str
    link: str
    pose: Pose
    model: str = ""
    view: tuple[float, float] = (0.0, 0.0)


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
        materials: physics materials by name.
        sensors: sensors by name.
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
    materials: dict[str, StatedMaterial] = field(default_factory=dict)
    sensors: dict[str, StatedSensor] = field(default_factory=dict)
    weightless: list[str] = field(default_factory=list)
    namespaces: dict[str, str] = field(default_factory=dict)
    overrides: dict[str, str] = field(default_factory=dict)
    remarks: list[tuple[bool, str, str, Span]] = field(default_factory=list)
