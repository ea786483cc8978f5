"""What a stage says beyond numbers: forms, colours, types of joints, mimicry, sensors, materials, names, and what is left out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pxr")

from graphengine.bringup.robots.import_robot import Imported, Origin, import_robot
from graphengine.descriptions.description_reader import with_robot_file
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.shapes import Box, Mesh, Sphere
from graphengine.descriptions.usd import usd_reader
from graphengine.descriptions.usd.usd_reader import read_usd
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.physics.model.robot_prims import add_robot
from tests.descriptions.files.forging import forged
from tests.descriptions.usd import fuzz
from tests.descriptions.usd.stages import StageWriter, workshop
from tests.isaac.harness import kept_answers


def described(path: Path) -> RobotDescription:
    findings = Findings()
    description = read_usd(path, Files.of(path), findings)
    assert description is not None, [finding.render() for finding in findings.errors]
    return description


def imported(path: Path) -> Imported:
    description, findings = described(path), Findings()
    target = path.parent / "robot.yaml"
    origin = Origin(
        description.element, description.packages, path, str(path), target, False, model=path, stage=description
    )
    found = import_robot(origin, findings)
    assert found is not None, [finding.render() for finding in findings.errors]
    return found


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> Imported:
    return imported(workshop(tmp_path_factory.mktemp("stage") / "workshop.usda"))


@pytest.fixture(scope="module")
def whole(cart: Imported) -> RobotDescription:
    return cart.draft.description


def keys(cart: Imported) -> Any:
    return cart.draft.data()


def test_a_bounded_mesh_collides_as_a_box_and_is_drawn_in_the_colours_of_its_parts(whole: RobotDescription) -> None:
    """It is mirrored: its corner points backward along x."""
    base = whole.links["base"]
    (collider,) = base.colliders
    assert isinstance(collider.geometry, Box)
    assert collider.geometry.size == pytest.approx((0.4, 0.2, 0.1))
    assert collider.pose[0] == pytest.approx((0.1 - 0.2, 0.1, 0.05))
    (half,) = (shape for shape in base.shapes if shape.visual)
    assert isinstance(half.geometry, Mesh)
    assert half.colour == (1.0, 0.0, 0.0, 0.5)


def test_shapes_of_instances_and_forms_without_a_name_are_read(whole: RobotDescription) -> None:
    (foot,), (tip,) = whole.links["foot"].colliders, whole.links["finger"].colliders
    assert isinstance(foot.geometry, Sphere)
    assert foot.geometry.radius == 0.02
    assert isinstance(tip.geometry, Mesh)


def test_a_joint_with_one_degree_of_freedom_is_prismatic_and_holds_its_target(
    cart: Imported, whole: RobotDescription
) -> None:
    rail = whole.joints["rail"]
    assert (rail.type, rail.axis) == ("prismatic", (1.0, 0.0, 0.0))
    assert rail.limits == pytest.approx((-0.1, 0.3))
    assert keys(cart)["joints"]["rail"]["drive"]["stiffness"] == 500.0
    assert keys(cart)["joints"]["rail"]["start"] == pytest.approx(0.2)


def test_a_joint_from_child_to_parent_is_turned_round(whole: RobotDescription) -> None:
    """The finger is at 0.2 m of the base, the joint at 0.05 m before it: there is the origin of its link."""
    grip = whole.joints["grip"]
    assert (grip.parent, grip.child) == ("base", "finger")
    assert grip.axis == (0.0, 0.0, -1.0)
    assert grip.pose[0] == pytest.approx((0.0, 0.15, 0.0))
    assert grip.limits == pytest.approx((math.radians(-45), math.radians(90)))
    assert grip.velocity == pytest.approx(math.pi)
    inertial = whole.links["finger"].inertial
    assert inertial is not None
    assert inertial.pose[0] == pytest.approx((-0.025, 0.05, 0.0), abs=1e-4)


def test_a_graph_that_commands_efforts_takes_the_drive_away(cart: Imported) -> None:
    assert "drive" not in keys(cart)["joints"]["grip"]
    assert keys(cart)["joints"]["grip"]["armature"] == pytest.approx(0.02)


def test_gains_of_an_acceleration_drive_are_for_a_unit_of_inertia(whole: RobotDescription) -> None:
    """A cone of height h has its centre at h/4 from its base; about it, the moment across the axis is 3/80 m (4 r2 + h2)."""
    assert whole.usd is not None
    across = 3 / 80 * 0.25 * (4 * 0.02**2 + 0.1**2)
    inertia = across + 0.25 * (0.05**2 + 0.025**2)
    assert whole.usd.drives["grip"].stiffness == pytest.approx(100 * inertia * math.degrees(1.0), rel=0.02)


def test_a_mimic_joint_follows_by_the_law_of_physx(whole: RobotDescription) -> None:
    """Its position plus gearing times that of the leader plus offset is zero; the offset is in degrees."""
    mimic = whole.joints["follow"].mimic
    assert mimic is not None
    assert (mimic.leader, mimic.multiplier) == ("grip", -0.5)
    assert mimic.offset == pytest.approx(-math.radians(10))


def test_a_disabled_fixed_joint_keeps_a_frame_and_other_joints_are_told(
    cart: Imported, whole: RobotDescription
) -> None:
    assert whole.joints["mark"].type == "fixed"
    told = [remark.text for remark in cart.draft.lost]
    assert whole.joints["socket"].type == "fixed"
    assert "prim /World/Cart/socket: spherical joints are not simulated; it becomes fixed" in told
    assert "prim /World/Cart/loop: it would close a loop, and is left out" in told


def test_sensors_have_the_profiles_of_their_names(cart: Imported) -> None:
    sensors = keys(cart)["sensors"]
    assert sensors["eye"]["profile"]["fov_deg"] == pytest.approx([90.0, math.degrees(2 * math.atan(0.5))])
    assert sensors["eye"]["position"] == [0.2, 0.0, 0.1]
    assert sensors["scanner"] == {"type": "lidar", "parent": "base", "profile": "microscan3_9m_20hz"}
    assert (sensors["imu"]["type"], sensors["bumper"]["type"]) == ("imu", "contact")
    microscan = {"type": "lidar", "parent": "base", "profile": "microscan3_9m_20hz", "position": [0.0, 0.0, 0.15]}
    assert sensors["sim_lidar"] == microscan
    assert sensors["sim_camera"] == {"type": "realsense_d455", "parent": "base", "position": [0.3, 0.0, 0.05]}
    assert any("/World/Cart/base/unheard: no profile is known" in remark.text for remark in cart.draft.lost)


def test_graphs_of_the_stage_find_its_prims(cart: Imported) -> None:
    """A path may leave out the links between a robot and one of its links, which are siblings in the stage."""
    stage = Stage()
    bodies = {f"{cart.robot.name}/{link}" for link in cart.draft.description.links}
    add_robot(stage, cart.robot, bodies, Findings())
    for path in ("base", "finger", "base/sim_lidar/Lidar", "base/sim_camera/RSD455/Camera_Pseudo_Depth"):
        assert stage.find(f"{cart.robot.prim_path}/{path}").name == path.rpartition("/")[2]


def test_textures_are_told(tmp_path: Path) -> None:
    path, findings = workshop(tmp_path / "robot.usda"), Findings()
    read_usd(path, Files.of(path), findings)
    assert any("textures of the stage are not drawn" in finding.message for finding in findings.items)


def test_materials_gravity_and_names_are_carried_over(cart: Imported) -> None:
    data = keys(cart)
    assert data["materials"]["Rubber"] == {
        "static_friction": 0.9, "dynamic_friction": 0.8, "combine": "multiply", "bind": ["foot"]
    }  # fmt: skip
    assert data["links"] == {"foot": {"gravity": False}}
    assert data["namespaces"] == {"base": "cart_1"}
    assert data["name_overrides"] == {"base": "base_link"}


def chain(path: Path, **values: Any) -> StageWriter:
    """Two bodies with a revolute joint and a drive."""
    writer = StageWriter(path)
    writer.robot("/Robot")
    writer.body("/Robot/base", mass=5.0)
    writer.body("/Robot/tip", mass=1.0)
    writer.drive(
        writer.joint("Revolute", "/Robot/turn", ("/Robot/base", "/Robot/tip"), lower=-90.0, upper=90.0), **values
    )
    return writer


@pytest.mark.parametrize(
    ("kinds", "gains", "kind", "own"),
    [
        (["velocity"], {"stiffness": 0.0, "damping": 10000.0}, "velocity", True),
        (["velocity"], {"stiffness": 1000.0, "damping": 10.0}, "velocity", False),
        (["position"], {"stiffness": 1000.0, "damping": 10.0}, "position", True),
        (["position"], {"stiffness": 0.0, "damping": 10.0}, "position", False),
        (["effort"], {"stiffness": 1000.0, "damping": 10.0}, "none", False),
        (["position", "velocity", "effort"], {"stiffness": 0.0, "damping": 10.0}, "velocity", True),
        (["position", "velocity", "effort"], {"stiffness": 10.0, "damping": 10.0}, "position", True),
        ([], {"stiffness": 10.0, "damping": 1.0}, "position", True),
        ([], {"stiffness": 0.0, "damping": 1.0}, "velocity", True),
    ],
)
def test_commands_of_graphs_decide_the_drive_then_its_numbers(
    tmp_path: Path, kinds: list[str], gains: dict[str, float], kind: str, own: bool
) -> None:
    """Its own numbers serve where they suit the kind of command; they are per degree in the stage."""
    writer = chain(tmp_path / "robot.usda", **gains)
    if kinds:
        writer.graph("/Robot/graph", "/Robot", ["turn"], *kinds)
    writer.save()
    drive = keys(imported(tmp_path / "robot.usda"))["joints"].get("turn", {}).get("drive", {})
    found = "position" if drive.get("stiffness") else "velocity" if drive else "none"
    assert found == kind
    if own:
        assert drive["damping"] == pytest.approx(math.degrees(gains["damping"]))
        assert drive.get("stiffness", 0.0) == pytest.approx(math.degrees(gains["stiffness"]))


def test_commands_for_another_robot_decide_nothing(tmp_path: Path) -> None:
    writer = chain(tmp_path / "robot.usda", stiffness=10.0)
    writer.graph("/Other/graph", "/Other", ["turn"], "effort")
    writer.save()
    assert keys(imported(tmp_path / "robot.usda"))["joints"]["turn"]["drive"]["stiffness"] > 0


def test_a_robot_that_lies_in_its_frame_stands_up(tmp_path: Path) -> None:
    """The root body of a robot that was made with y up, and turned by its stage, has a frame whose z axis points sideways."""
    writer = StageWriter(tmp_path / "robot.usda", up="Y")
    writer.robot("/Robot")
    writer.body("/Robot/base", mass=1.0)
    writer.shape("Cube", "/Robot/base/box", edges=(0.5, 0.3, 0.1))
    writer.save()
    (collider,) = described(tmp_path / "robot.usda").links["base"].colliders
    assert isinstance(collider.geometry, Box)
    turned = collider.pose[1]
    assert math.hypot(turned[0], turned[3]) == pytest.approx(1.0)  # about x
    assert collider.geometry.size == pytest.approx((0.5, 0.1, 0.3))


@pytest.mark.parametrize(("kind", "count"), [("usda", 160), ("usdc", 40)])
def test_mutants_of_stages_are_read_or_refused(tmp_path: Path, kind: str, count: int) -> None:
    """A crash of USD's reader ends its process, and is reported; all else would be a fault of this package."""
    found = fuzz.run(count, kind, 3, tmp_path)
    assert not [outcome for outcome in found if outcome.startswith("!")]
    assert found["robot"]
    assert found["refused"]


def test_units_that_are_not_stated_are_those_of_isaac_sim(tmp_path: Path) -> None:
    """USD's own defaults, centimetres with y up, would make it a robot of millimetres that lies on its side."""
    text = '#usda 1.0\ndef Cube "base" (apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) { double size = 0.5\n}\n'
    (tmp_path / "robot.usda").write_text(text, encoding="utf-8")
    findings = Findings()
    description = read_usd(tmp_path / "robot.usda", Files.of(tmp_path / "robot.usda"), findings)
    assert description is not None
    assert description.mass == pytest.approx(1000.0 * 0.5**3)
    assert "assumed, as in Isaac Sim: metersPerUnit: 1, upAxis: Z" in findings.items[-1].message


def test_no_forged_answer_raises_anything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that was taken over by a stage may answer anything."""
    real = kept_answers(usd_reader, monkeypatch)
    path = workshop(tmp_path / "robot.usda")
    described(path)
    for answer in forged(real[0], 300):
        monkeypatch.setattr(usd_reader, "ask", lambda *_, answer=answer: answer)
        findings = Findings()
        description = read_usd(path, Files.of(path), findings)
        assert description is not None or findings.errors
        assert all(finding.render() for finding in findings.items)
        if description is not None and description.usd is not None:
            with_robot_file(description, path, findings)


def test_a_ball_caster_slides_without_friction(tmp_path: Path) -> None:
    """Its spherical joint becomes fixed, so the ball would drag."""
    writer = StageWriter(tmp_path / "robot.usda")
    writer.robot("/Robot")
    writer.body("/Robot/base", (0.0, 0.0, 0.2), mass=5.0)
    writer.body("/Robot/ball", (0.1, 0.0, 0.05), mass=0.1)
    writer.shape("Sphere", "/Robot/ball/sphere", radius=0.05)
    writer.joint("Spherical", "/Robot/socket", ("/Robot/base", "/Robot/ball"), at=(0.1, 0.0, -0.15))
    writer.save()
    found = imported(tmp_path / "robot.usda")
    ball = {"static_friction": 0.0, "dynamic_friction": 0.0, "combine": "min", "bind": ["ball"]}
    assert keys(found)["materials"]["balls"] == ball
    assert any("its ball slides without friction" in remark.text for remark in found.draft.lost)
