"""Colliders that a robot file gives to wheels."""

from __future__ import annotations

import mujoco
import pytest

from graphengine.descriptions.engine import RAYS, RAYS_AND_PICTURES
from tests.physics.harness import CART, Project

WHEEL = """<link name="wheel">
    <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
    {visual}<collision><geometry><box size=".2 .04 .2"/></geometry></collision>
    <collision><geometry><box size=".1 .04 .1"/></geometry></collision>
  </link>
  <joint name="wheel_joint" type="{type}">
    <parent link="base_link"/><child link="wheel"/><origin xyz="0 .2 0" rpy="0 0 1.5707963267948966"/>
    <axis xyz="1 0 0"/><limit lower="-90" upper="90" effort="1" velocity="1"/>
  </joint>
</robot>"""
VISUAL = '<visual><geometry><box size=".2 .04 .2"/></geometry></visual>'


def wheel(
    project: Project, *, visual: str = "", kind: str = "continuous", collider: str = "radius: 0.1, width: 0.04"
) -> Project:
    project.write("bot.urdf", CART.replace("</robot>", WHEEL.format(visual=visual, type=kind)))
    return project.robot(
        f"joints: {{wheel_joint: {{drive: {{damping: 10}}}}}}\nwheel_colliders: {{wheel: {{{collider}}}}}"
    )


@pytest.mark.parametrize(
    ("shape", "kind", "size"),
    [
        ("ellipsoid", mujoco.mjtGeom.mjGEOM_ELLIPSOID, [0.1, 0.1, 0.02]),
        ("cylinder", mujoco.mjtGeom.mjGEOM_CYLINDER, [0.1, 0.02, 0.0]),
    ],
)
def test_a_shape_about_the_axis_replaces_all_colliders(
    project: Project, shape: str, kind: mujoco.mjtGeom, size: list[float]
) -> None:
    text = f"shape: {shape}, radius: 0.1, width: 0.04, offset: 0.05"
    simulation = wheel(project, collider=text).load().simulation
    model, data = simulation.model, simulation.data
    body = model.body("bot/wheel")
    (geom,) = range(body.geomadr[0], body.geomadr[0] + body.geomnum[0])
    assert model.geom_type[geom] == kind
    assert model.geom_size[geom].tolist() == size
    assert abs(data.geom_xmat[geom].reshape(3, 3)[:, 2]) == pytest.approx([0, 1, 0], abs=1e-9)  # its axis, in the world
    assert data.geom_xpos[geom][1] == pytest.approx(0.25)
    assert model.body_mass[body.id] == 1.0


def test_the_robot_knows_the_wheel_by_its_collider(project: Project) -> None:
    robot = wheel(project, kind="revolute").load().robots["bot"]
    assert robot.wheel_radii == {"wheel_joint": 0.1}
    assert robot.drives["wheel_joint"].carries == pytest.approx(0.01)


@pytest.mark.parametrize(("visual", "group"), [("", RAYS_AND_PICTURES), (VISUAL, RAYS)])
def test_the_shape_is_drawn_only_where_there_is_no_visual(project: Project, visual: str, group: int) -> None:
    model = wheel(project, visual=visual).load().simulation.model
    solid = [
        g for g in range(model.ngeom) if model.geom_bodyid[g] == model.body("bot/wheel").id and model.geom_contype[g]
    ]
    assert [model.geom_group[geom] for geom in solid] == [group]


@pytest.mark.parametrize(
    ("link", "told"),
    [
        ("base_link: {radius: 1, width: 1}", "link 'base_link' is not a wheel: no joint turns it"),
        ("arm: {radius: 0, width: 1}", "error G109: "),
        ("arm: {radius: 1}", "missing"),
        ("arm: ellipsoid", "for another collider write {radius: …, width: …}, in m"),
    ],
)
def test_a_collider_that_cannot_be_is_refused(project: Project, link: str, told: str) -> None:
    assert told in "\n".join(project.robot(f"wheel_colliders: {{{link}}}").errors())
