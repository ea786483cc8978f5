"""Worlds of SDF in scenes: what stands still, what moves, what is left out, and how it looks."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from graphengine.descriptions.earth import earth_of
from graphengine.descriptions.worlds.mesh_pieces import THICKNESS
from graphengine.format.diagnostics import Findings
from graphengine.physics.loaded_world import LoadedWorld
from tests.descriptions.sdf.harness import BALL, INERTIA, document, joint, link, model, pose
from tests.physics.harness import Project, load_with_findings, steps, try_load

FLOOR = "<include><uri>model://ground_plane</uri></include>"
STATIC = "<static>true</static>"
BOX = "<geometry><box><size>2 1 0.5</size></box></geometry>"


def collision(content: str, more: str = "") -> str:
    return f'<collision name="c">{content}{more}</collision>'


def world(folder: Path, *content: str) -> tuple[LoadedWorld, Findings]:
    """A scene in a world with some content."""
    (folder / "world.sdf").write_text(document(f'<world name="w">{"".join(content)}</world>'), encoding="utf-8")
    (folder / "scene.yaml").write_text("scene: s\nworld: world.sdf\n", encoding="utf-8")
    return load_with_findings(folder / "scene.yaml")


def compiled(folder: Path, *content: str) -> mujoco.MjModel:
    """The compiled model of a world with some content."""
    return world(folder, *content)[0].simulation.model


def rejected(folder: Path, *content: str) -> list[str]:
    """The errors of a world, each with its line."""
    (folder / "world.sdf").write_text(document(f'<world name="w">{"".join(content)}</world>'), encoding="utf-8")
    (folder / "scene.yaml").write_text("scene: s\nworld: world.sdf\n", encoding="utf-8")
    _, findings = try_load(folder / "scene.yaml")
    return [f"{error.span.line if error.span else 0}: {error.message}" for error in findings.errors]


def test_a_static_model_stands_where_it_is_posed(tmp_path: Path) -> None:
    part = link("top", pose(0, 0, 1) + collision(pose(0, 0.5) + BOX))
    found = compiled(tmp_path, model(STATIC + pose(1, 2, 3, 0, 0, math.pi / 2) + part, "table"))
    data = mujoco.MjData(found)
    mujoco.mj_kinematics(found, data)
    assert found.body("table").jntnum == 0
    assert data.geom_xpos[0] == pytest.approx([0.5, 2.0, 4.0])
    assert found.geom_size[0] == pytest.approx([1.0, 0.5, 0.25])


SHAPES = {
    "<sphere><radius>.3</radius></sphere>": (mujoco.mjtGeom.mjGEOM_SPHERE, [0.3]),
    "<cylinder><radius>.3</radius><length>2</length></cylinder>": (mujoco.mjtGeom.mjGEOM_CYLINDER, [0.3, 1.0]),
    "<capsule><radius>.3</radius><length>2</length></capsule>": (mujoco.mjtGeom.mjGEOM_CAPSULE, [0.3, 1.0]),
    "<ellipsoid><radii>.1 .2 .3</radii></ellipsoid>": (mujoco.mjtGeom.mjGEOM_ELLIPSOID, [0.1, 0.2, 0.3]),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_each_shape_becomes_a_geom_of_its_type_and_size(tmp_path: Path, shape: str) -> None:
    found = compiled(tmp_path, model(STATIC + link("l", collision(f"<geometry>{shape}</geometry>"))))
    kind, size = SHAPES[shape]
    assert found.geom_type[0] == kind
    assert found.geom_size[0][: len(size)] == pytest.approx(size)


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (1, 2, -2), (0, 0, -1)])
def test_a_plane_faces_along_its_normal(tmp_path: Path, normal: tuple[float, ...]) -> None:
    plane = f"<geometry><plane><normal>{' '.join(map(str, normal))}</normal></plane></geometry>"
    found = compiled(tmp_path, model(STATIC + link("l", collision(plane))))
    data = mujoco.MjData(found)
    mujoco.mj_kinematics(found, data)
    assert data.geom_xmat[0].reshape(3, 3)[:, 2] == pytest.approx(np.array(normal) / np.linalg.norm(normal))


def test_a_model_without_moving_joints_falls_as_one_body(tmp_path: Path) -> None:
    """Two links of 1 kg, 0.4 m apart, are fixed to each other: they rest on the floor at the radius of their balls."""
    links = link("a", pose(0, 0, 1) + collision(BALL)) + link("b", pose(0.4, 0, 1) + collision(BALL))
    loaded, _ = world(tmp_path, FLOOR, model(links + joint("j", "a", "b"), "pair"))
    simulation = loaded.simulation
    assert simulation.model.njnt == 1
    assert simulation.model.body_subtreemass[0] == pytest.approx(2.0)
    steps(simulation, 600)
    heights = [simulation.data.body(f"pair::{name}").xpos[2] for name in "ab"]
    assert heights == pytest.approx([0.1, 0.1], abs=0.002)


def test_links_that_no_joint_holds_fall_on_their_own(tmp_path: Path) -> None:
    links = link("a", collision(BALL)) + link("b", pose(1) + collision(BALL))
    assert compiled(tmp_path, model(links)).njnt == 2
    assert compiled(tmp_path, model(links + joint("j", "world", "a"))).njnt == 1


def test_a_mass_has_the_position_of_its_inertial_pose(tmp_path: Path) -> None:
    moments = "<inertia><ixx>.1</ixx><iyy>.2</iyy><izz>.25</izz></inertia>"
    inertial = f"<inertial>{pose(0, 0, 0.5, math.pi / 2)}<mass>3</mass>{moments}</inertial>"
    body = compiled(tmp_path, model(f'<link name="l">{inertial}{collision(BALL)}</link>', "thing")).body("thing")
    assert body.mass == pytest.approx(3.0)
    assert body.ipos == pytest.approx([0.0, 0.0, 0.5])
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    axes = turn.reshape(3, 3)
    assert np.diag(axes @ np.diag(body.inertia) @ axes.T) == pytest.approx([0.1, 0.25, 0.2])


AUTOMATIC = {
    "<box><size>.2 .3 .4</size></box>": 0.024,
    "<sphere><radius>.3</radius></sphere>": 4 / 3 * math.pi * 0.027,
    "<cylinder><radius>.1</radius><length>.5</length></cylinder>": math.pi * 0.005,
    "<capsule><radius>.1</radius><length>.5</length></capsule>": math.pi * (0.005 + 4 / 3 * 0.001),
    "<ellipsoid><radii>.1 .2 .3</radii></ellipsoid>": 4 / 3 * math.pi * 0.006,
}


@pytest.mark.parametrize("shape", AUTOMATIC)
def test_an_automatic_inertia_equals_mujocos(tmp_path: Path, shape: str) -> None:
    """Of two equal shapes apart and turned, of which one has another density."""
    first = collision(pose(0.1, 0.2, 0.3, 0.4, 0.5, 0.6) + f"<geometry>{shape}</geometry>", "<density>500</density>")
    second = first.replace("0.1", "-0.7").replace('"c"', '"d"').replace("<density>500</density>", "")
    given = f'<link name="l"><inertial auto="true"><density>800</density></inertial>{first}{second}</link>'
    made = compiled(tmp_path, model(given, "thing")).body("thing")
    assert made.mass == pytest.approx(AUTOMATIC[shape] * 1300)
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="thing")
    for geom, density in zip(compiled_geoms(tmp_path), (500.0, 800.0), strict=True):
        body.add_geom(type=geom.type, size=geom.size, pos=geom.pos, quat=geom.quat, density=density)
    theirs = spec.compile().body("thing")
    assert made.ipos == pytest.approx(theirs.ipos)
    assert made.inertia == pytest.approx(theirs.inertia, rel=1e-6)


def compiled_geoms(folder: Path) -> list[mujoco.MjsGeom]:
    """The geoms of the last world that was written."""
    found = load_with_findings(folder / "scene.yaml")[0].simulation.model
    spec = mujoco.MjSpec()
    return [
        spec.worldbody.add_geom(type=geom.type[0], size=geom.size, pos=geom.pos, quat=geom.quat)
        for geom in map(found.geom, range(found.ngeom))
    ]


def test_friction_comes_from_the_surface(tmp_path: Path) -> None:
    surface = "<surface><friction><ode><mu>.35</mu></ode></friction></surface>"
    found = compiled(
        tmp_path, model(STATIC + link("l", collision(BOX, surface) + '<collision name="d">' + BALL + "</collision>"))
    )
    assert found.geom_friction[:, 0].tolist() == [0.35, 1.0]


def test_colliders_collide_and_visuals_do_not(tmp_path: Path) -> None:
    visual = f'<visual name="v">{BALL}<material><diffuse>1 .5 0 1</diffuse></material></visual>'
    found = compiled(tmp_path, model(STATIC + link("l", collision(BOX) + visual)))
    assert found.geom_contype.tolist() == [1, 0]
    assert found.geom_rgba[1] == pytest.approx([1.0, 0.5, 0.0, 1.0])
    assert found.geom_group[0] != found.geom_group[1]


def test_a_world_keeps_its_place_on_earth(tmp_path: Path) -> None:
    numbers = {"latitude_deg": 47.38, "longitude_deg": 8.54, "elevation": 408.0, "heading_deg": 30.0}
    tags = "".join(f"<{tag}>{number}</{tag}>" for tag, number in numbers.items())
    frame = "<surface_model>EARTH_WGS84</surface_model><world_frame_orientation>ENU</world_frame_orientation>"
    found = compiled(tmp_path, f"<spherical_coordinates>{frame}{tags}</spherical_coordinates>")
    assert earth_of(found) == tuple(numbers.values())
    assert earth_of(compiled(tmp_path)) is None


def test_a_place_on_the_moon_is_left_out_with_a_warning(tmp_path: Path) -> None:
    moon = "<spherical_coordinates><surface_model>MOON_SCS</surface_model></spherical_coordinates>"
    loaded, findings = world(tmp_path, moon)
    assert earth_of(loaded.simulation.model) is None
    assert [(each.code, each.message) for each in findings.items] == [
        ("W302", "the place of the world is left out: surface_model 'MOON_SCS' is not EARTH_WGS84")
    ]


def test_gravity_and_lights_of_an_sdf_world_are_converted(tmp_path: Path) -> None:
    lamp = '<light name="lamp" type="spot"><pose>1 2 3 1.5707963267948966 0 0</pose><diffuse>.5 .6 .7 1</diffuse>'
    lamp += (
        "<direction>0 0 -1</direction><spot><outer_angle>1</outer_angle></spot><cast_shadows>1</cast_shadows></light>"
    )
    found = compiled(tmp_path, "<gravity>0 0 -1.62</gravity><include><uri>model://sun</uri></include>", lamp)
    assert found.opt.gravity == pytest.approx([0.0, 0.0, -1.62])
    light = found.light("lamp")
    assert light.pos == pytest.approx([1.0, 2.0, 3.0])
    assert light.dir == pytest.approx([0.0, 1.0, 0.0])
    assert light.diffuse == pytest.approx([0.5, 0.6, 0.7])
    assert light.cutoff == pytest.approx(math.degrees(0.5))
    assert found.light("sun").type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value
    assert compiled(tmp_path).opt.gravity == pytest.approx([0.0, 0.0, -9.8])


def test_the_command_that_imports_a_model_quotes_its_name(tmp_path: Path) -> None:
    turning = joint("j", "base", "arm", "<axis><xyz>0 0 1</xyz></axis>", "revolute")
    _, findings = world(tmp_path, FLOOR, model(link("base") + link("arm") + turning, "arm $(touch x)"))
    (warning,) = (each for each in findings.items if each.severity == "warning")
    assert f"graphrun import-robot {tmp_path}/world.sdf --model 'arm $(touch x)' -o robots/NAME.yaml" in warning.help[0]


def test_a_model_with_moving_joints_is_left_out_with_advice(tmp_path: Path) -> None:
    turning = joint("j", "base", "arm", "<axis><xyz>0 0 1</xyz></axis>", "revolute")
    arm = model(pose(1, 2, 0, 0, 0, 1) + link("base", pose(0, 0, 0.5)) + link("arm") + turning, "arm")
    loaded, findings = world(tmp_path, FLOOR, arm)
    assert loaded.simulation.model.nbody == 2
    (warning,) = (each for each in findings.items if each.severity == "warning")
    assert (warning.code, warning.message[:23]) == ("W302", "model 'arm' is left out")
    assert f"graphrun import-robot {tmp_path}/world.sdf --model arm -o robots/NAME.yaml" in warning.help[0]
    assert "position: [1, 2, 0.5], orientation: {rpy_deg: [0, 0, 57.2958]}" in warning.help[1]


def test_bodies_and_lights_are_prims(tmp_path: Path) -> None:
    loaded, _ = world(
        tmp_path, FLOOR, "<include><uri>model://sun</uri></include>", model(link("l", collision(BALL)), "crate")
    )
    for path in ("/World/ground_plane", "/World/sun", "/World/crate"):
        assert path in loaded.simulation.stage


HALL = [  # a box that is open above, seen from inside and outside: its walls are 0.2 m thick
    *((-2.0, -1.8, -2.0, 2.0), (1.8, 2.0, -2.0, 2.0), (-1.8, 1.8, -2.0, -1.8), (-1.8, 1.8, 1.8, 2.0)),
]


def hall() -> str:
    """An OBJ file of four walls in one mesh."""
    lines: list[str] = []
    for number, (x0, x1, y0, y1) in enumerate(HALL):
        lines += [f"v {x} {y} {z}" for x in (x0, x1) for y in (y0, y1) for z in (0.0, 1.0)]
        quads = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
        for a, b, c, d in quads:
            corners = [corner + 8 * number for corner in (a, b, c, d)]
            lines += ["f {} {} {}".format(*corners[:3]), "f {} {} {}".format(corners[0], *corners[2:])]
    return "\n".join(lines) + "\n"


MESH = "<geometry><mesh><uri>hall.obj</uri></mesh></geometry>"


def test_a_static_mesh_that_is_not_convex_is_hollow(tmp_path: Path) -> None:
    """A ball falls into the hall, and another stays on top of its wall."""
    (tmp_path / "hall.obj").write_text(hall(), encoding="utf-8")
    balls = [
        model(pose(*at) + link("l", collision(BALL)), name)
        for name, at in (("inside", (0, 0, 1)), ("above", (1.9, 0, 1.1)))
    ]
    loaded, _ = world(tmp_path, FLOOR, model(STATIC + link("l", collision(MESH)), "hall"), *balls)
    simulation = loaded.simulation
    steps(simulation, 480)
    assert simulation.data.body("inside").xpos[2] == pytest.approx(0.1, abs=0.002)
    assert simulation.data.body("above").xpos[2] == pytest.approx(1.1, abs=0.002)
    assert THICKNESS < 0.1


def test_a_convex_mesh_and_a_moving_mesh_are_one_collider_each(tmp_path: Path) -> None:
    (tmp_path / "hall.obj").write_text(hall(), encoding="utf-8")
    assert compiled(tmp_path, model(pose(0, 0, 1) + link("l", collision(MESH)))).ngeom == 1
    cube = "\n".join(line for line in hall().split("\n")[:20])  # the first wall alone
    (tmp_path / "hall.obj").write_text(f"{cube}\n", encoding="utf-8")
    assert compiled(tmp_path, model(STATIC + link("l", collision(MESH)))).ngeom == 1


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (model(STATIC + link("l", collision("<geometry><cone/></geometry>"))), "a cone is not supported"),
        (model(link("l", collision("<geometry><plane/></geometry>"))), "a plane must belong to a static model"),
        (model(STATIC + link("l", collision(MESH))), "no file 'hall.obj'"),
        (model(STATIC + link("l", collision(BOX.replace("2 1", "2")))), "size must be 3 numbers, not '2 0.5'"),
        ('<light name="l" type="laser"/>', "unknown light type 'laser'"),
        ("<gravity>down</gravity>", "gravity must be 3 numbers, not 'down'"),
        (
            "<spherical_coordinates><latitude_deg>95</latitude_deg></spherical_coordinates>",
            "latitude_deg must be from -90 to 90, not 95",
        ),
        (
            "<spherical_coordinates><elevation>high</elevation></spherical_coordinates>",
            "elevation must be a number, not 'high'",
        ),
        ("<include><uri>model://nowhere</uri></include>", "no model 'model://nowhere'"),
    ],
)
def test_mistakes_are_reported_with_their_lines(tmp_path: Path, content: str, message: str) -> None:
    assert rejected(tmp_path, "\n", content) == [
        f"4: {message}" if "cone" not in message else f"4: collision 'c': {message}"
    ]


def test_a_world_is_a_file_with_one_world(tmp_path: Path) -> None:
    project = Project(tmp_path)
    project.write("scene.yaml", "scene: s\nworld: world.sdf\n")
    assert "not 0" in project.write("world.sdf", document(model(link("l")))).error()
    assert "begin with <sdf>" in project.write("world.sdf", "<mujoco/>").error()


# Models as they are in scenes


def test_a_scene_uses_a_model_as_a_robot_or_an_object(tmp_path: Path) -> None:
    wheel = f'<link name="wheel">{pose(0, 0.2)}<inertial><mass>1</mass>{INERTIA}</inertial>{collision(BALL)}</link>'
    turning = joint("axle", "base", "wheel", "<axis><xyz>0 1 0</xyz></axis>", "revolute")
    project = Project(tmp_path).write(
        "cart.sdf", document(model(link("base", collision(BALL)) + wheel + turning, "cart"))
    )
    project.write("table.sdf", document(model(STATIC + link("top", collision(BOX)), "table")))
    robots = "robots:\n  cart: {use: cart.sdf, position: [0, 0, 1]}\n  table: {use: table.sdf, position: [5, 0, 1]}\n"
    loaded, findings = project.write("scene.yaml", f"scene: s\nworld: world.xml\n{robots}").load_with_findings()
    names = [loaded.simulation.model.joint(index).name for index in range(loaded.simulation.model.njnt)]
    assert names == ["cart/root", "cart/axle"]
    assert not findings.errors


def test_a_robot_file_names_an_sdf_file(tmp_path: Path) -> None:
    project = Project(tmp_path).write("bot.sdf", document(model(link("base_link", collision(BALL)), "any")))
    project.write("bot.yaml", "robot: bot\nurdf: bot.sdf\n")
    assert project.load().simulation.model.body("bot/base_link").mass == pytest.approx(1.0)
    broken = document(model("\n" + link("base_link", "<pose>x</pose>")))
    assert project.write("bot.sdf", broken).error().startswith("bot.sdf:4:")
