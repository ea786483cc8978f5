"""Worlds of USD stages in scenes: what stands still, what falls and how fast, what a concave mesh holds, and what is told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import pytest

pytest.importorskip("pxr")

from pxr import Gf, UsdGeom, UsdLux, UsdPhysics, UsdShade

import graphengine as ge
from graphengine.format.diagnostics import Findings
from graphengine.physics.loaded_world import LoadedWorld
from tests.descriptions.usd.stages import StageWriter, rover
from tests.physics.harness import load_with_findings

TROUGH = [(0, 0), (1, 0), (1, 1), (0.8, 1), (0.8, 0.2), (0.2, 0.2), (0.2, 1), (0, 1)]
"""Outline of a trough, x and z, m."""
UNITS: list[dict[str, Any]] = [{}, {"metres": 0.01, "kilograms": 0.001, "up": "Y"}]


def scene(folder: Path, more: str = "") -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"scene: s\nworld: hall.usda\n{more}", encoding="utf-8")
    return path


def loaded(writer: StageWriter, more: str = "") -> tuple[LoadedWorld, Findings]:
    writer.save()
    return load_with_findings(scene(Path(writer.stage.GetRootLayer().realPath).parent, more))


def trough(writer: StageWriter, approximation: str) -> None:
    """A mesh of the outline, 1 m deep, whose hull is a solid block."""
    mesh = UsdGeom.Mesh.Define(writer.stage, "/World/trough")
    count = len(TROUGH)
    points = [writer.length((x, y, z)) for y in (0.0, 1.0) for x, z in TROUGH]
    mesh.CreatePointsAttr([Gf.Vec3f(*point) for point in points])
    sides = [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    ends = [[0, 5, 4, 1], [1, 4, 3, 2], [0, 7, 6, 5]]
    faces = [
        *(list(face) for face in ends),
        *([i + count for i in face[::-1]] for face in ends),
        *(s[::-1] for s in sides),
    ]
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr([i for face in faces for i in face])
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(approximation)


@pytest.mark.parametrize("units", UNITS)
def test_static_colliders_stand_where_the_stage_has_them(tmp_path: Path, units: dict[str, Any]) -> None:
    writer = StageWriter(tmp_path / "hall.usda", **units)
    writer.shape("Cube", "/World/shelf", (1.0, 2.0, 0.5), edges=(2.0, 1.0, 0.5))
    model = loaded(writer)[0].simulation.model
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    solid = [geom for geom in range(model.ngeom) if model.geom_contype[geom]]
    assert len(solid) == 1
    assert model.nbody == 1
    assert data.geom_xpos[solid[0]] == pytest.approx([1.0, 2.0, 0.5])
    extent = data.geom_xmat[solid[0]].reshape(3, 3) @ model.geom_size[solid[0]]
    assert abs(extent) == pytest.approx([1.0, 0.5, 0.25], rel=1e-6)


@pytest.mark.parametrize("units", UNITS)
def test_a_loose_body_falls_onto_the_floor(tmp_path: Path, units: dict[str, Any]) -> None:
    writer = StageWriter(tmp_path / "hall.usda", **units)
    writer.shape("Plane", "/World/floor", axis="Z")
    writer.body("/World/crate", (1.0, 2.0, 3.0), mass=5.0)
    writer.shape("Cube", "/World/crate/box", edges=(0.4, 0.4, 0.4))
    writer.save()
    with ge.load(scene(tmp_path)).session() as sim:
        sim.run(0.5)
        assert sim.body("crate").pose.position == pytest.approx((1.0, 2.0, 3.0 - 9.81 * 0.5**2 / 2), rel=1e-2)
        sim.run(2.0)
        assert sim.body("crate").pose.position == pytest.approx((1.0, 2.0, 0.2), abs=0.005)
        assert sim.mujoco.model.body("crate").mass[0] == pytest.approx(5.0)


@pytest.mark.parametrize(("approximation", "height"), [("none", 0.25), ("sdf", 0.25), ("convexHull", 1.05)])
def test_a_concave_mesh_holds_a_ball_unless_it_asks_for_its_hull(
    tmp_path: Path, approximation: str, height: float
) -> None:
    writer = StageWriter(tmp_path / "hall.usda")
    trough(writer, approximation)
    writer.body("/World/ball", (0.5, 0.5, 1.2), mass=1.0)
    writer.shape("Sphere", "/World/ball/shape", radius=0.05)
    writer.save()
    with ge.load(scene(tmp_path)).session() as sim:
        sim.run(2.0)
        assert sim.body("ball").pose.position[2] == pytest.approx(height, abs=0.005)


def test_bodies_that_a_fixed_joint_connects_fall_as_one(tmp_path: Path) -> None:
    writer = StageWriter(tmp_path / "hall.usda")
    for name, x in (("left", 0.0), ("right", 1.0)):
        writer.body(f"/World/{name}", (x, 0.0, 5.0), mass=1.0)
        writer.shape("Cube", f"/World/{name}/box", edges=(0.2, 0.2, 0.2))
    writer.joint("Fixed", "/World/weld", ("/World/left", "/World/right"), at=(1.0, 0.0, 0.0))
    model = loaded(writer)[0].simulation.model
    assert model.nv == 6
    assert model.body_subtreemass[1] == pytest.approx(2.0)


def test_a_kinematic_body_and_one_that_is_fixed_to_the_world_stand_still(tmp_path: Path) -> None:
    writer = StageWriter(tmp_path / "hall.usda")
    for name in ("lift", "sign"):
        writer.body(f"/World/{name}", (0.0, 0.0, 5.0), mass=1.0)
        writer.shape("Cube", f"/World/{name}/box", edges=(0.2, 0.2, 0.2))
    UsdPhysics.RigidBodyAPI(writer.stage.GetPrimAtPath("/World/lift")).CreateKinematicEnabledAttr(True)
    writer.joint("Fixed", "/World/hold", ("", "/World/sign"), at=(0.0, 0.0, 5.0))
    assert loaded(writer)[0].simulation.model.nv == 0


def test_friction_gravity_lights_and_cameras_are_those_of_the_stage(tmp_path: Path) -> None:
    writer = StageWriter(tmp_path / "hall.usda")
    prim = writer.shape("Plane", "/World/floor")
    material = UsdShade.Material.Define(writer.stage, "/World/Ice")
    UsdPhysics.MaterialAPI.Apply(material.GetPrim()).CreateDynamicFrictionAttr(0.07)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, materialPurpose="physics")
    moon = UsdPhysics.Scene.Define(writer.stage, "/physicsScene")
    moon.CreateGravityMagnitudeAttr(1.62)
    moon.CreateGravityDirectionAttr(Gf.Vec3f(0, 0, -2))
    sun = UsdLux.DistantLight.Define(writer.stage, "/World/sun")
    sun.CreateColorAttr(Gf.Vec3f(1.0, 0.5, 0.0))
    UsdGeom.Xformable(sun).AddRotateXOp().Set(90.0)  # from -z to +y
    camera = UsdGeom.Camera.Define(writer.stage, "/World/eye")
    camera.CreateFocalLengthAttr(10.0)
    camera.CreateVerticalApertureAttr(20.0)
    model = loaded(writer)[0].simulation.model
    floor = next(geom for geom in range(model.ngeom) if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE)
    assert model.geom_friction[floor][0] == pytest.approx(0.07)
    assert model.opt.gravity == pytest.approx([0.0, 0.0, -1.62])
    assert model.light("sun").dir == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    assert model.light("sun").diffuse == pytest.approx([0.7, 0.35, 0.0])
    assert model.camera("eye").fovy[0] == pytest.approx(90.0)  # 2 atan(20 / (2 * 10))


def test_robots_of_the_stage_are_told_unless_the_scene_has_them(tmp_path: Path) -> None:
    rover(tmp_path / "hall.usda")
    _, findings = load_with_findings(scene(tmp_path))
    (told,) = [each for each in findings.items if each.code == "W302"]
    assert told.message.startswith("/Rover is left out: it has moving joints, so it is a robot")
    assert told.span is not None
    assert told.span.line > 1
    more = "robots:\n  bot: {use: hall.usda, at: /Rover, position: [0, 0, 0.1]}\n"
    _, findings = load_with_findings(scene(tmp_path, more))
    assert not [each for each in findings.items if each.code == "W302"]


def test_what_a_world_cannot_have_is_named(tmp_path: Path) -> None:
    writer = StageWriter(tmp_path / "hall.usda")
    writer.shape("Cube", "/World/sheet", edges=(1.0, 1.0, 0.0))
    findings = loaded(writer)[1]
    assert "/World/sheet is left out: it has no volume" in [each.message for each in findings.items]
