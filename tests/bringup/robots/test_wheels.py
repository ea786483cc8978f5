"""Wheels that an import finds: by their shape, on joints that turn on and on, where the robot stands on them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.harness import (
    CASTER,
    CHASSIS,
    CYLINDER,
    INERTIA,
    MESH,
    drum,
    imported,
    keys,
    noticed,
    rover,
    wheel,
)
from tests.physics.harness import FLOOR, load, steps, yaw_of

ROVER_SCENE = "scene: s\nworld: world.xml\nrobots:\n  rover: {use: rover.yaml, position: [0, 0, 0.1]}\n"

SWIVEL = f"""<link name="fork"><inertial><mass value=".2"/>{INERTIA}</inertial></link>
      <joint name="swivel" type="continuous">
        <parent link="base_link"/><child link="fork"/><origin xyz="-.25 0 -.05"/><axis xyz="0 0 1"/>
      </joint>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "wheel.obj").write_text(drum(24), encoding="utf-8")
    return tmp_path


def meshed(**more: str) -> str:
    return wheel("left", 0.2, MESH, **more) + wheel("right", -0.2, MESH, **more)


def test_a_wheel_with_a_mesh_is_found_and_rolls_as_an_ellipsoid(folder: Path) -> None:
    (folder / "wheel.obj").write_text(drum(24, radius=0.1, width=0.04, offset=0.03), encoding="utf-8")
    robot = imported(folder, rover(CASTER, wheels=meshed()))
    left = robot.draft.wheels["left_joint"]
    assert (left.radius, left.width, left.offset) == pytest.approx((0.1, 0.04, 0.03), abs=1e-6)
    assert left.centre == pytest.approx((0, 0.23, 0), abs=1e-6)
    shape = {"shape": "ellipsoid", "radius": 0.1, "width": 0.04, "offset": 0.03}
    assert keys(robot)["wheel_colliders"]["left_wheel"] == pytest.approx(shape)
    assert robot.robot.wheel_radii == pytest.approx({"left_joint": 0.1, "right_joint": 0.1})
    assert keys(robot)["joints"]["left_joint"] == {"drive": {"damping": 589.0}}


@pytest.mark.parametrize(("corners", "found"), [(4, False), (6, False), (10, True), (60, True)])
def test_a_shape_with_few_corners_is_no_wheel(folder: Path, corners: int, found: bool) -> None:
    (folder / "wheel.obj").write_text(drum(corners), encoding="utf-8")
    assert bool(imported(folder, rover(CASTER, wheels=meshed())).draft.wheels) is found


@pytest.mark.parametrize(
    ("limits", "found"),
    [('lower="-1e16" upper="1e16"', True), ('lower="-6.3" upper="6.3"', False), ('lower="-1.5" upper="1.5"', False)],
)
def test_a_revolute_joint_with_a_range_above_four_turns_carries_a_wheel(folder: Path, limits: str, found: bool) -> None:
    more = f'<limit {limits} effort="5" velocity="10"/>'
    robot = imported(folder, rover(CASTER, wheels=meshed(kind="revolute", more=more)))
    assert ("left_joint" in robot.draft.wheels) is found


def test_a_mesh_high_above_the_floor_is_no_wheel(folder: Path) -> None:
    above = wheel("roll", 0, MESH).replace('xyz="0 0 0"', 'xyz="0 0 1"').replace('xyz="0 0', 'xyz="0 0')
    robot = imported(folder, rover(CASTER, above.replace('<origin xyz="0 0 0"/>', '<origin xyz="0 0 1"/>')))
    assert list(robot.draft.wheels) == ["left_joint", "right_joint"]


def test_a_cylinder_wheel_becomes_an_ellipsoid_and_a_sphere_stays_a_sphere(folder: Path) -> None:
    sphere = '<geometry><sphere radius=".1"/></geometry>'
    robot = imported(folder, rover(CASTER, wheels=wheel("left", 0.2) + wheel("right", -0.2, sphere)))
    assert keys(robot)["wheel_colliders"] == {"left_wheel": "ellipsoid"}


def test_a_wheel_that_does_not_turn_about_its_own_axis_is_reported(folder: Path) -> None:
    crooked = CYLINDER.replace("1.5707963267948966", "1.2")
    robot = imported(folder, rover(CASTER, wheels=wheel("left", 0.2) + wheel("right", -0.2, crooked)))
    told = "joint right_joint turns the cylinder of right_wheel about an axis 21 degrees off its own: no wheel"
    assert told in noticed(robot)


def test_a_caster_of_swivel_and_wheel_turns_freely(folder: Path) -> None:
    roll = wheel("small", 0, CYLINDER.replace('radius=".1"', 'radius=".05"')).replace("base_link", "fork")
    robot = imported(folder, rover(SWIVEL, roll))
    assert robot.draft.wheels["small_joint"].swivels
    assert keys(robot)["joints"]["small_joint"] == {}
    assert keys(robot)["joints"]["swivel"] == {}
    assert keys(robot)["materials"]["WheelMaterial"]["bind"] == ["left_wheel", "right_wheel"]  # type: ignore[index]


def test_wheels_get_full_grip(folder: Path) -> None:
    material = keys(imported(folder, rover(CASTER)))["materials"]["WheelMaterial"]
    bind = ["left_wheel", "right_wheel"]
    assert material == {"static_friction": 1.0, "dynamic_friction": 1.0, "combine": "max", "bind": bind}


@pytest.mark.parametrize(
    ("commands", "swivels"),
    [
        ('<transmission name="t"><joint name="swivel"/></transmission>', False),
        (
            '<ros2_control name="r"><joint name="swivel"><command_interface name="position"/></joint></ros2_control>',
            False,
        ),
        ('<ros2_control name="r"><joint name="swivel"><state_interface name="position"/></joint></ros2_control>', True),
        ('<gazebo><plugin name="steer" filename="s.so"><joint_name>swivel</joint_name></plugin></gazebo>', False),
        (
            '<gazebo><plugin name="JointStatePublisher" filename="s.so"><joint_name>swivel</joint_name></plugin></gazebo>',
            True,
        ),
    ],
)
def test_a_wheel_on_a_joint_that_is_commanded_is_no_caster(folder: Path, commands: str, swivels: bool) -> None:
    roll = wheel("small", 0, CYLINDER.replace('radius=".1"', 'radius=".05"')).replace("base_link", "fork")
    robot = imported(folder, rover(SWIVEL, roll, commands))
    assert robot.draft.wheels["small_joint"].swivels is swivels


@pytest.mark.parametrize("collision", [MESH, CYLINDER], ids=["meshes", "cylinders"])
def test_an_imported_robot_travels_the_distance_of_its_wheels(folder: Path, collision: str) -> None:
    low = CHASSIS.replace('xyz="-.1 0 .06"', 'xyz="-.1 0 -.07"')  # it drags
    wheels = wheel("left", 0.2, collision) + wheel("right", -0.2, collision)
    robot = imported(folder, rover(chassis=low, wheels=wheels))
    (folder / "rover.yaml").write_text(robot.files[folder / "rover.yaml"], encoding="utf-8")
    (folder / "world.xml").write_text(FLOOR, encoding="utf-8")
    (folder / "scene.yaml").write_text(ROVER_SCENE, encoding="utf-8")
    simulation = load(folder / "scene.yaml").simulation
    joints = simulation.articulation(simulation.stage.find("/rover"))
    base, select = (
        simulation.body(simulation.stage.find("/rover/base_link")),
        joints.select(["left_joint", "right_joint"]),
    )
    select.command(velocities=[3.0, 3.0])
    steps(simulation, 240)
    start = base.pose()[0]
    steps(simulation, 480)
    assert base.pose()[0][0] - start[0] == pytest.approx(3.0 * 0.1 * 2.0, rel=0.005)
    select.command(velocities=[-1.0, 1.0])
    steps(simulation, 240)
    before = yaw_of(base.pose()[1])
    steps(simulation, 480)
    assert yaw_of(base.pose()[1]) - before == pytest.approx(2 * 0.1 / 0.4 * 2.0, rel=0.005)


def test_mesh_wheels_that_differ_by_less_than_their_facets_get_one_radius(tmp_path: Path) -> None:
    """Otherwise a rigid base stands on two diagonal wheels, and a mecanum base slides down a slope."""
    radii = (0.1, 0.1002, 0.0999, 0.1001)
    for number, radius in enumerate(radii):
        (tmp_path / f"wheel_{number}.obj").write_text(drum(48, radius))
    places = ((0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2))
    mesh = '<geometry><mesh filename="wheel_{}.obj"/></geometry>'
    wheels = "".join(
        wheel(f"w{n}", y, mesh.format(n)).replace('<origin xyz="0 ', f'<origin xyz="{x} ')
        for n, (x, y) in enumerate(places)
    )
    found = [each.radius for each in imported(tmp_path, rover(wheels=wheels)).draft.wheels.values()]
    assert found == pytest.approx([sum(radii) / 4] * 4, rel=1e-6)
