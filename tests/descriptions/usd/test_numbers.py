"""Masses, inertias, joint frames, limits and gains of generated stages equal the formulae of UsdPhysics to 1e-9.

The expected values come from the numbers that are written into the stage, by matrices of numpy, never from a transform of USD.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("pxr")

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from graphengine.descriptions.robot_description import Joint, RobotDescription
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_physics_process import PhysicsReading
from graphengine.descriptions.usd.usd_reader import chosen, description_of
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files

Matrix = NDArray[np.float64]
STAGES = 200
EXACT = 1e-9
TURNS = {"Z": np.eye(3), "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}


def matrix_of(x: float, y: float, z: float, w: float) -> Matrix:
    """The rotation matrix of a quaternion, by the formula of Euler and Rodrigues."""
    x, y, z, w = (np.array([x, y, z, w]) / math.sqrt(x * x + y * y + z * z + w * w)).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def single(value: float) -> float:
    """A number as USD keeps it in single precision."""
    return float(np.float32(value))


@dataclass
class Placed:
    """A rotation, a position, and scales along the axes that are applied first; only the innermost may differ."""

    rotation: Matrix
    position: Matrix
    scale: Matrix

    def __matmul__(self, other: Placed) -> Placed:
        place = self.position + self.rotation @ (self.scale * other.position)
        return Placed(self.rotation @ other.rotation, place, self.scale * other.scale)


@dataclass
class Expected:
    """What the specification says of a generated stage of two bodies and a joint, in the units of the stage."""

    metres: float
    kilograms: float
    up: str
    mass: float
    moments: Matrix
    axes: Matrix
    centre: Matrix
    frames: tuple[Placed, Placed]
    limits: tuple[float, float]
    gains: tuple[float, float, float]
    turns: bool
    axis: Matrix
    holder: Placed
    held: Placed


class Writer:
    """Writes a stage of random numbers."""

    def __init__(self, path: Path, seed: int) -> None:
        self.draw = random.Random(seed)
        self.stage = Usd.Stage.CreateNew(str(path))

    def vector(self, most: float) -> list[float]:
        return [self.draw.uniform(-most, most) for _ in range(3)]

    def quaternion(self) -> list[float]:
        return [self.draw.gauss(0, 1) for _ in range(4)]

    def placed(self, prim: Usd.Prim, most: float, scale: list[float]) -> Placed:
        """Place a prim by chance, with scales along its axes; return its transform to the parent."""
        position, (x, y, z, w) = self.vector(most), self.quaternion()
        length = math.sqrt(x * x + y * y + z * z + w * w)
        x, y, z, w = x / length, y / length, z / length, w / length
        form = UsdGeom.Xformable(prim)
        form.AddTranslateOp().Set(Gf.Vec3d(*position))
        form.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))
        form.AddScaleOp().Set(Gf.Vec3f(*scale))
        return Placed(matrix_of(x, y, z, w), np.array(position), np.array([*map(single, scale)]))

    def run(self) -> Expected:
        draw, stage = self.draw, self.stage
        metres, kilograms = draw.choice([1.0, 0.01, 0.0254]), draw.choice([1.0, 0.001, 2.5])
        up = draw.choice("YZ")
        UsdGeom.SetStageMetersPerUnit(stage, metres)
        UsdPhysics.SetStageKilogramsPerUnit(stage, kilograms)
        UsdGeom.SetStageUpAxis(stage, up)
        root = UsdGeom.Xform.Define(stage, "/Robot").GetPrim()
        UsdPhysics.ArticulationRootAPI.Apply(root)
        above = self.placed(root, 3 / metres, [draw.choice([1.0, 0.5, 2.0])] * 3)
        nested = draw.random() < 0.5
        bodies: list[Usd.Prim] = []
        poses: list[Placed] = []
        for name in ("one", "one/two" if nested else "two"):
            prim = UsdGeom.Xform.Define(stage, f"/Robot/{name}").GetPrim()
            UsdPhysics.RigidBodyAPI.Apply(prim)
            before = poses[0] if poses and nested else above
            uniform = nested and not poses
            scale = [draw.uniform(0.3, 3.0)] * 3 if uniform else [draw.uniform(0.3, 3.0) for _ in range(3)]
            poses.append(before @ self.placed(prim, 1 / metres, scale))
            bodies.append(prim)
        body, holder = bodies[1], bodies[0]
        UsdPhysics.MassAPI.Apply(holder).CreateMassAttr(1.0)
        mass, moments, centre, axes = self.massive(body, metres)
        turns = draw.random() < 0.5
        joint = (UsdPhysics.RevoluteJoint if turns else UsdPhysics.PrismaticJoint).Define(stage, "/Robot/joint")
        joint.CreateBody0Rel().SetTargets([holder.GetPath()])
        joint.CreateBody1Rel().SetTargets([body.GetPath()])
        frames = tuple(self.side(joint, side, 0.5 / metres) for side in (0, 1))
        name, lower = draw.choice("XYZ"), draw.uniform(-150.0, -10.0)
        upper = draw.uniform(10.0, 150.0)
        joint.CreateAxisAttr(name)
        joint.CreateLowerLimitAttr(lower)
        joint.CreateUpperLimitAttr(upper)
        gains = tuple(draw.uniform(1.0, 1e4) for _ in range(3))
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular" if turns else "linear")
        drive.CreateStiffnessAttr(gains[0])
        drive.CreateDampingAttr(gains[1])
        drive.CreateMaxForceAttr(gains[2])
        stage.GetRootLayer().Save()
        return Expected(
            metres, kilograms, up, mass, moments, axes, centre, (frames[0], frames[1]), (single(lower), single(upper)),
            (single(gains[0]), single(gains[1]), single(gains[2])), turns, np.eye(3)["XYZ".index(name)], poses[0], poses[1],
        )  # fmt: skip

    def massive(self, prim: Usd.Prim, metres: float) -> tuple[float, Matrix, Matrix, Matrix]:
        draw, api = self.draw, UsdPhysics.MassAPI.Apply(prim)
        mass, (x, y, z, w) = draw.uniform(0.1, 50.0), self.quaternion()
        small = draw.uniform(0.01, 1.0) / metres**2
        moments = [small, small * draw.uniform(1.0, 1.5), small * draw.uniform(1.0, 1.5)]
        centre = self.vector(0.2 / metres)
        api.CreateMassAttr(mass)
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(*moments))
        api.CreatePrincipalAxesAttr(Gf.Quatf(w, x, y, z))
        api.CreateCenterOfMassAttr(Gf.Vec3f(*centre))
        axes = matrix_of(*(single(part) for part in (x, y, z, w)))
        return single(mass), np.array([*map(single, moments)]), np.array([*map(single, centre)]), axes

    def side(self, joint: Any, side: int, most: float) -> Placed:
        position, (x, y, z, w) = self.vector(most), self.quaternion()
        getattr(joint, f"CreateLocalPos{side}Attr")(Gf.Vec3f(*position))
        getattr(joint, f"CreateLocalRot{side}Attr")(Gf.Quatf(w, x, y, z))
        rotation = matrix_of(*(single(part) for part in (x, y, z, w)))
        return Placed(rotation, np.array([*map(single, position)]), np.ones(3))


def read(path: Path) -> RobotDescription:
    findings, files = Findings(), Files.of(path)
    contents = PhysicsReading(files).run(path)
    assert not contents.failure
    tree = chosen(contents, "", PrimSpans(path), findings)
    assert tree is not None
    description = description_of(contents, tree, path, files, findings)
    assert description is not None, [finding.render() for finding in findings.errors]
    return description


def near(one: Any, other: Any) -> bool:
    """Whether numbers are equal to 1e-9 of the largest."""
    one, other = np.asarray(one), np.asarray(other)
    return bool(np.abs(one - other).max() <= EXACT * max(np.abs(other).max(), 1.0))


@pytest.mark.parametrize("seed", range(0, STAGES, 20))
def test_numbers_equal_the_formulae_of_the_specification(tmp_path: Path, seed: int) -> None:
    for number in range(seed, seed + 20):
        path = tmp_path / f"stage_{number}.usdc"
        wanted = Writer(path, number).run()
        description = read(path)
        assert description.usd is not None
        (joint,) = description.moving()
        check_joint(wanted, joint, description)
        check_mass(wanted, joint, description)
        stated, length = description.usd.drives[joint.name], math.radians(1.0) if wanted.turns else wanted.metres
        force = wanted.kilograms * wanted.metres * (wanted.metres if wanted.turns else 1.0)
        stiffness, damping, most = wanted.gains
        assert near([stated.stiffness, stated.damping], [stiffness * force / length, damping * force / length])
        assert near(stated.max_force, most * force)
        assert near(joint.limits, [limit * length for limit in wanted.limits])


def check_joint(wanted: Expected, joint: Joint, description: RobotDescription) -> None:
    """Check the position and the axis of a joint in the frame of its parent link, and the child's axes with the joint at zero.

    A local position is in the frame of its body with the scale of the body. The child link's origin is at its joint.
    """
    turn, (first, second) = TURNS[wanted.up], wanted.frames
    upright = turn @ wanted.holder.rotation @ turn.T
    tilted = upright[2, 2] < math.cos(math.radians(30.0))
    into = turn @ wanted.holder.rotation if tilted else turn  # from the axes of the prim to those of the link
    assert near(joint.pose[0], wanted.metres * (into @ (wanted.holder.scale * first.position)))
    assert near(matrix_of(*joint.pose[1]), into @ first.rotation @ second.rotation.T @ turn.T)
    assert near(joint.axis, turn @ second.rotation @ wanted.axis)


def check_mass(wanted: Expected, joint: Joint, description: RobotDescription) -> None:
    """Check mass, centre and inertia of the child link; its frame has the axes of the body, and its origin at the joint."""
    inertial, turn = description.links[joint.child].inertial, TURNS[wanted.up]
    assert inertial is not None
    assert inertial.moments is not None
    assert near(inertial.mass, wanted.mass * wanted.kilograms)
    centre = wanted.metres * (turn @ (wanted.held.scale * (wanted.centre - wanted.frames[1].position)))
    assert near(inertial.pose[0], centre)
    spun = matrix_of(*inertial.pose[1])
    unit = wanted.kilograms * wanted.metres**2
    axes = turn @ wanted.axes
    assert near(spun @ np.diag(inertial.moments[:3]) @ spun.T, axes @ np.diag(wanted.moments * unit) @ axes.T)


@pytest.mark.parametrize(("kind", "volume", "moments"), [
    ("Cube", 0.2 * 0.3 * 0.4, (0.3**2 + 0.4**2, 0.2**2 + 0.4**2, 0.2**2 + 0.3**2)),
    ("Sphere", 4 / 3 * math.pi * 0.1**3, (12 * 0.4 * 0.1**2,) * 3),
    ("Cylinder", math.pi * 0.1**2 * 0.3, (3 * 0.1**2 + 0.3**2, 3 * 0.1**2 + 0.3**2, 6 * 0.1**2)),
])  # fmt: skip
@pytest.mark.parametrize(
    ("mass", "density", "own", "material"),
    [
        (0.0, 0.0, 0.0, 0.0),
        (3.0, 500.0, 0.0, 0.0),
        (0.0, 500.0, 0.0, 700.0),
        (0.0, 500.0, 200.0, 700.0),
        (0.0, 0.0, 0.0, 700.0),
    ],
)
def test_missing_masses_come_from_the_shapes(
    tmp_path: Path,
    kind: str,
    volume: float,
    moments: tuple[float, float, float],
    mass: float,
    density: float,
    own: float,
    material: float,
) -> None:
    """A mass outranks a density, that of the shape outranks that of the body, and both outrank that of a material."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    body = UsdGeom.Xform.Define(stage, "/Body").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(body)
    api = UsdPhysics.MassAPI.Apply(body)
    api.CreateMassAttr(mass)
    api.CreateDensityAttr(density)
    shape = getattr(UsdGeom, kind).Define(stage, "/Body/shape")
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    UsdPhysics.MassAPI.Apply(shape.GetPrim()).CreateDensityAttr(own)
    if kind == "Cube":
        shape.CreateSizeAttr(1.0)
        shape.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(0.2, 0.3, 0.4))
    else:
        shape.CreateRadiusAttr(0.1)
    if kind == "Cylinder":
        shape.CreateHeightAttr(0.3)
    if material:
        made = stage.DefinePrim("/Rubber", "Material")
        UsdPhysics.MaterialAPI.Apply(made).CreateDensityAttr(material)
        shape.GetPrim().CreateRelationship("material:binding:physics").SetTargets([Sdf.Path("/Rubber")])
    stage.Save()
    inertial = read(tmp_path / "a.usda").links["Body"].inertial
    assert inertial is not None
    assert inertial.moments is not None
    wanted = mass or volume * (own or density or material or 1000.0)
    assert inertial.mass == pytest.approx(wanted, rel=1e-9)
    assert sorted(inertial.moments[:3]) == pytest.approx(sorted(wanted * each / 12 for each in moments), rel=1e-9)
