"""Models of SDF become URDF: links in the frames of their joints, with everything that the file says of them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Geometry, Mesh, Sphere
from graphengine.devices.rotation import Vector3, compose, from_rpy, rotate
from tests.descriptions.sdf.harness import BALL, converted, document, errors, joint, link, model, pose, urdf
from tests.physics.harness import SCENE, Project

QUARTER = math.pi / 2
TWO = link("base") + link("arm", pose(0, 0, 1))


def only_joint(folder: Path, content: str, version: str = "1.9") -> Joint:
    """The only joint of a model."""
    (found,) = urdf(folder, document(model(content), version)).joints.values()
    return found


def axis(content: str) -> str:
    return f"<axis>{content}</axis>"


def turning(xyz: str, limits: str = "", more: str = "") -> str:
    """A joint `base` -> `arm` about an axis."""
    return joint("j", "base", "arm", axis(f"{xyz}<limit>{limits}</limit>") + more, "revolute")


def test_a_link_lies_in_the_frame_of_its_joint(tmp_path: Path) -> None:
    """The ball of the arm is at (0, 0, 1.5) in the model, wherever the joint is."""
    arm = link("arm", pose(0, 0, 1) + f'<collision name="c">{pose(0, 0, 0.5)}{BALL}</collision>')
    found = urdf(
        tmp_path, document(model(link("base", pose(1)) + arm + joint("j", "base", "arm", pose(0, 0.2, 0, QUARTER))))
    )
    assert found.joints["j"].pose[0] == pytest.approx((-1.0, 0.2, 1.0))
    (collider,) = found.links["arm"].colliders
    place = compose(found.pose_in_root("arm"), collider.pose)
    assert place[0] == pytest.approx((-1.0, 0.0, 1.5))
    assert place[1] == pytest.approx((0.0, 0.0, 0.0, 1.0))


def test_elements_of_a_link_may_be_relative_to_any_frame(tmp_path: Path) -> None:
    content = link("base", f'<collision name="c">{pose(0, 0, 1, relative_to="f")}{BALL}</collision>')
    found = urdf(tmp_path, document(model(content + f'<frame name="f">{pose(2)}</frame>')))
    assert found.links["base"].colliders[0].pose == ((2.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))


def test_a_pose_keeps_its_quaternion(tmp_path: Path) -> None:
    """Roll, pitch and yaw would be the same rotation, with other last digits."""
    quaternion = (0.5, -0.1, 0.7, 0.5)
    assert math.hypot(*quaternion) == 1.0
    placed = f"<pose rotation_format='quat_xyzw'>0 0 1 {' '.join(map(str, quaternion))}</pose>"
    text = document(model(link("base", f'<collision name="c">{placed}{BALL}</collision>')))
    assert urdf(tmp_path, text).links["base"].colliders[0].pose == ((0.0, 0.0, 1.0), quaternion)


def test_masses_are_placed_by_their_pose(tmp_path: Path) -> None:
    moments = "<inertia><ixx>1</ixx><ixy>.1</ixy></inertia>"
    inertial = f"<inertial>{pose(0, 0, 0.5, 0, 0, QUARTER)}<mass>3</mass>{moments}</inertial>"
    found = urdf(tmp_path, document(model(f'<link name="base">{inertial}</link>')))
    made = found.links["base"].inertial
    assert made is not None
    assert made.pose[0] == (0.0, 0.0, 0.5)
    assert made.pose[1] == pytest.approx(from_rpy(0.0, 0.0, QUARTER))
    assert made.moments == (1.0, 1.0, 1.0, 0.1, 0.0, 0.0)
    assert found.mass == 3.0


def test_a_link_without_mass_weighs_1_kg_unless_it_is_a_mere_frame(tmp_path: Path) -> None:
    text = document(
        model(
            f'<link name="base"><collision name="c">{BALL}</collision></link><link name="f"/>' + joint("j", "base", "f")
        )
    )
    found = urdf(tmp_path, text)
    assert (found.links["base"].mass, found.links["f"].mass) == (1.0, 0.0)
    _, findings = converted(tmp_path, text)
    assert [note.help for note in findings.items] == [("links: f",)]


SHAPES: dict[str, Geometry | tuple[str, Vector3]] = {
    "<box><size>1 2 3</size></box>": Box((1.0, 2.0, 3.0)),
    "<cylinder><radius>.1</radius><length>.3</length></cylinder>": Cylinder(0.1, 0.3),
    "<capsule><radius>.1</radius><length>.3</length></capsule>": Capsule(0.1, 0.3),
    "<sphere><radius>.4</radius></sphere>": Sphere(0.4),
    "<mesh><uri>meshes/a.stl</uri><scale>1 2 3</scale></mesh>": ("meshes/a.stl", (1.0, 2.0, 3.0)),
    "<mesh><uri>model://m/a.stl</uri></mesh>": ("model://m/a.stl", (1.0, 1.0, 1.0)),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_each_shape_is_read_with_its_sizes(tmp_path: Path, shape: str) -> None:
    text = document(model(link("base", f'<collision name="c"><geometry>{shape}</geometry></collision>')))
    geometry = urdf(tmp_path, text).links["base"].colliders[0].geometry
    assert (
        (geometry.filename, geometry.scale) == SHAPES[shape]
        if isinstance(geometry, Mesh)
        else geometry == SHAPES[shape]
    )


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ("<heightmap><uri>a.png</uri></heightmap>", "a heightmap is not supported"),
        ("<cone><radius>1</radius></cone>", "a cone is not supported"),
        ("<plane><normal>0 0 1</normal></plane>", "a link of a robot cannot have the shape 'plane'"),
        ("<ellipsoid><radii>1 1 2</radii></ellipsoid>", "a link of a robot cannot have the shape 'ellipsoid'"),
        ("<sphere><radius>big</radius></sphere>", "radius must be a number, not 'big'"),
        ("<mesh/>", "a mesh without <uri>"),
    ],
)
def test_a_collision_of_another_shape_is_an_error_and_a_visual_is_left_out(
    tmp_path: Path, shape: str, message: str
) -> None:
    text = document(model(link("base", f'\n<collision name="c"><geometry>{shape}</geometry></collision>')))
    (error,) = errors(tmp_path, text)
    assert error.startswith("4: ")
    assert message in error
    found = urdf(tmp_path, text.replace("collision", "visual"))
    assert not found.links["base"].element.all("visual")


def test_a_collision_or_visual_with_an_empty_geometry_is_left_out(tmp_path: Path) -> None:
    text = document(model(link("base", '<collision name="c"><geometry><empty/></geometry></collision>')))
    assert not urdf(tmp_path, text).links["base"].colliders


def test_a_colour_is_the_diffuse_colour_with_the_transparency(tmp_path: Path) -> None:
    material = "<material><diffuse>.1 .2 .3 1</diffuse></material><transparency>.5</transparency>"
    text = document(model(link("base", f'<visual name="v">{BALL}{material}</visual>')))
    (visual,) = urdf(tmp_path, text).links["base"].element.all("visual")
    assert [part.get("rgba") for part in visual.walk() if part.tag == "color"] == ["0.1 0.2 0.3 0.5"]


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ("<box><size>1 -1 1</size></box>", "main.sdf:5:1: error S106: MuJoCo: size 1 must be positive in geom"),
        ("<sphere><radius>0</radius></sphere>", "main.sdf:5:31: note N103: a shape with a size of 0 is left out"),
    ],
)
def test_findings_of_the_compiler_name_the_line_of_the_file(project: Project, shape: str, said: str) -> None:
    collision = f'\n\n<collision name="c"><geometry>{shape}</geometry></collision>'
    project.write("main.sdf", document(model(link("base", collision))))
    project.write("scene.yaml", SCENE.replace("bot.yaml", "main.sdf"))
    texts = [finding.render().replace(f"{project.folder}/", "") for finding in project.try_load()[1].items]
    assert any(text.startswith(said) for text in texts), texts


# Joints


def test_an_axis_is_in_the_frame_of_the_joint(tmp_path: Path) -> None:
    found = only_joint(tmp_path, link("base") + link("arm", pose(0, 0, 1, QUARTER)) + turning("<xyz>0 1 0</xyz>"))
    assert found.axis == (0.0, 1.0, 0.0)
    assert rotate(found.pose[1], found.axis) == pytest.approx((0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("version", "xyz"),
    [
        ("1.9", '<xyz expressed_in="__model__">0 0 1</xyz>'),
        ("1.9", '<xyz expressed_in="base">0 0 1</xyz>'),
        ("1.6", "<xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame>"),
        ("1.4", "<xyz>0 0 1</xyz>"),
    ],
)
def test_an_axis_may_be_expressed_in_another_frame(tmp_path: Path, version: str, xyz: str) -> None:
    content = link("base") + link("arm", pose(4, 0, 0, 0, QUARTER)) + turning(xyz)
    assert only_joint(tmp_path, content, version).axis == pytest.approx((-1.0, 0.0, 0.0))


def test_limits_and_dynamics_of_a_joint_are_read(tmp_path: Path) -> None:
    limits = "<lower>-1</lower><upper>2</upper><effort>30</effort><velocity>4</velocity>"
    dynamics = "</limit><dynamics><damping>.5</damping><friction>.25</friction></dynamics><limit>"
    found = only_joint(tmp_path, TWO + turning("<xyz>0 0 1</xyz>", limits + dynamics))
    assert (found.type, found.limits, found.effort) == ("revolute", (-1.0, 2.0), 30.0)
    (element,) = found.element.all("dynamics")
    assert element.attributes == {"damping": "0.5", "friction": "0.25"}


@pytest.mark.parametrize(
    "limits",
    ["", "<lower>-inf</lower><upper>inf</upper>", "<lower>-1e16</lower><upper>1e16</upper>",
     "<lower>-1.79769e+308</lower><upper>1.79769e+308</upper><effort>-1</effort>"],
)  # fmt: skip
def test_a_revolute_joint_without_limits_is_continuous(tmp_path: Path, limits: str) -> None:
    found = only_joint(tmp_path, TWO + turning("<xyz>0 0 1</xyz>", limits))
    assert (found.type, found.limits, found.effort) == ("continuous", None, None)


def test_a_joint_with_one_limit_is_free_on_the_other_side(tmp_path: Path) -> None:
    found = only_joint(tmp_path, TWO + turning("<xyz>0 0 1</xyz>", "<lower>0</lower>"))
    assert (found.type, found.limits) == ("revolute", (0.0, 1e6))


def test_a_joint_may_mimic_another(tmp_path: Path) -> None:
    mimic = '<mimic joint="j"><multiplier>2</multiplier><offset>.5</offset><reference>1</reference></mimic>'
    second = joint("k", "arm", "hand", axis(f"<xyz>0 0 1</xyz>{mimic}"), "revolute")
    found = urdf(tmp_path, document(model(TWO + turning("<xyz>0 0 1</xyz>") + link("hand") + second), "1.11"))
    law = found.joints["k"].mimic
    assert law is not None
    assert (law.leader, law.multiplier, law.offset) == ("j", 2.0, -1.5)


@pytest.mark.parametrize("kind", ["ball", "screw", "gearbox", "revolut"])
def test_other_types_of_joints_are_errors_with_a_remedy(tmp_path: Path, kind: str) -> None:
    text = document(model(TWO + "\n" + joint("j", "base", "arm", kind=kind)))
    _, findings = converted(tmp_path, text)
    (error,) = findings.errors
    assert error.message == f"joint 'j': type {kind!r} is not supported"
    assert error.help
    assert (error.span.line, error.span.column) == (4, 23) if error.span is not None else False


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_a_joint_with_two_axes_turns_about_the_parents_first(tmp_path: Path, kind: str) -> None:
    """As the front wheels of steered cars do in Gazebo: `axis` steers, `axis2` rolls."""
    axes = (
        "<axis><xyz>0 0 1</xyz><limit><lower>-.5</lower><upper>.5</upper></limit></axis><axis2><xyz>0 1 0</xyz></axis2>"
    )
    text = document(model(link("base") + link("arm", pose(1, 2, 3)) + joint("j", "base", "arm", axes, kind)))
    found = urdf(tmp_path, text)
    steering, rolling = found.joints["j"], found.joints["j_axis2"]
    assert (steering.parent, steering.child, rolling.parent, rolling.child) == ("base", "j_cross", "j_cross", "arm")
    assert (steering.type, rolling.type, steering.limits) == ("revolute", "continuous", (-0.5, 0.5))
    assert (steering.axis, rolling.axis) == ((0, 0, 1), (0, 1, 0))
    assert found.pose_in_root("arm")[0] == (1, 2, 3)


def test_a_ball_on_a_ball_joint_slides_without_friction(tmp_path: Path) -> None:
    """As the casters of most SDF models are."""
    caster = link("caster", pose(-0.1) + f'<collision name="c">{BALL}</collision>')
    found = urdf(tmp_path, document(model(link("base") + caster + joint("j", "base", "caster", kind="ball"))))
    assert found.joints["j"].type == "fixed"
    (gazebo,) = found.element.all("gazebo")
    assert (gazebo.get("reference"), [child.text for child in gazebo.children]) == ("caster", ["0.0", "0.0"])


def test_a_joint_to_the_world_bolts_the_robot_down(tmp_path: Path) -> None:
    found = urdf(tmp_path, document(model(link("base", pose(0, 0, 1)) + joint("j", "world", "base"))))
    assert (found.root, found.joints["j"].pose[0]) == ("world", (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("child", "joints", "position"),
    [("M1::L2", joint("k", "M1::L2", "M1::L1"), (1, 1, 1)), ("M1::F1", joint("k", "M1::L1", "M1::L2"), (1, 0, 1))],
)
def test_a_joint_may_name_links_and_frames_of_nested_models(
    tmp_path: Path, child: str, joints: str, position: tuple[float, ...]
) -> None:
    """The numbers are those of libsdformat's test of joints with nested parents and children."""
    nested = link("L1", pose(0, 0, 1)) + link("L2", pose(1, 1)) + f'<frame name="F1">{pose(1)}</frame>'
    content = model(nested, "M1") + link("L1", pose(0, 0, 10, 0, QUARTER)) + joint("J", "L1", child, pose(0, 0, 1))
    found = urdf(tmp_path, document(model(content + joints)))
    place = compose(((0.0, 0.0, 10.0), from_rpy(0.0, QUARTER, 0.0)), found.joints["J"].pose)
    assert place[0] == pytest.approx(position)


def test_names_of_nested_models_have_a_prefix(tmp_path: Path) -> None:
    plugin = '<plugin name="p" filename="f"><left_joint>j</left_joint><other>x</other></plugin>'
    arm = model(TWO + turning("<xyz>0 0 1</xyz>") + plugin, "arm")
    found = urdf(tmp_path, document(model(link("root") + arm + joint("mount", "root", "arm::base"))))
    assert list(found.links) == ["root", "arm::base", "arm::arm"]
    assert list(found.joints) == ["mount", "arm::j"]
    texts = [part.text for part in found.element.walk() if part.tag in ("left_joint", "other")]
    assert texts == ["arm::j", "x"]


# For Gazebo


def gazebo(folder: Path, content: str, reference: str = "base") -> dict[str, str]:
    """What a model's URDF says to Gazebo about a link: text by path of tags."""
    found = urdf(folder, document(model(content)))
    texts: dict[str, str] = {}
    for element in (each for each in found.element.all("gazebo") if each.get("reference") == reference):
        pending = [("", child) for child in element.children]
        while pending:
            path, part = pending.pop()
            texts[f"{path}{part.tag}"] = part.text
            pending += [(f"{path}{part.tag}/", child) for child in part.children]
    return texts


def test_sensors_keep_their_place_when_their_link_moves_to_its_joint(tmp_path: Path) -> None:
    sensor = f'<sensor name="eye" type="camera">{pose(0, 0, 0.5)}<update_rate>5</update_rate></sensor>'
    content = link("base") + link("arm", pose(0, 0, 1) + sensor) + joint("j", "base", "arm", pose(0, 0.2))
    assert gazebo(tmp_path, content, "arm") == {
        "sensor": "",
        "sensor/pose": "0.0 -0.2 0.5 0.0 0.0 0.0",
        "sensor/update_rate": "5",
    }


def test_friction_gravity_and_unknown_elements_are_passed_on_as_gazebo_tags(tmp_path: Path) -> None:
    ode = "<ode><mu>.3</mu><mu2>.2</mu2><fdir1>1 0 0</fdir1></ode>"
    contact = "<contact><ode><kp>1e5</kp></ode></contact>"
    surface = f"<surface><friction>{ode}</friction>{contact}</surface>"
    collision = f'<collision name="c">{pose(0, 0, 0, 0, 0, QUARTER)}{BALL}{surface}</collision>'
    told = gazebo(
        tmp_path,
        link(
            "base",
            collision + "<gravity>0</gravity><self_collide>true</self_collide><light><diffuse>1</diffuse></light>",
        ),
    )
    path = "collision/surface/friction/ode"
    assert told.pop(f"{path}/fdir1") == "0.0 1.0 0.0"
    assert told.pop("gravity") == "false"
    assert told.pop("selfCollide") == "true"
    assert (told[f"{path}/mu"], told[f"{path}/mu2"], told["kp"], told["light/diffuse"]) == (".3", ".2", "1e5", "1")


def test_a_direction_of_friction_may_be_expressed_in_another_link(tmp_path: Path) -> None:
    direction = '<fdir1 gz:expressed_in="base">1 0 0</fdir1>'
    friction = f"<surface><friction><ode><mu>1</mu><mu2>0</mu2>{direction}</ode></friction></surface>"
    wheel = link("arm", f'<collision name="c">{BALL}{friction}</collision>')
    text = document(model(link("base", pose(0, 0, 0, 0, 0, QUARTER)) + wheel + turning("<xyz>0 0 1</xyz>"))).replace(
        "<sdf ", '<sdf xmlns:gz="x" '
    )
    (found,) = (part for part in urdf(tmp_path, text).element.walk() if part.tag == "fdir1")
    assert (found.text, found.attributes) == ("1.0 0.0 0.0", {"expressed_in": "base"})


def test_static_and_springs_of_joints_become_gazebo_elements(tmp_path: Path) -> None:
    spring = "</limit><dynamics><spring_stiffness>7</spring_stiffness><spring_reference>.5</spring_reference></dynamics><limit>"
    text = document(model("<static>true</static>" + TWO + turning("<xyz>0 0 1</xyz>", spring)))
    told = {(e.get("reference"), c.tag): c.text for e in urdf(tmp_path, text).element.all("gazebo") for c in e.children}
    assert told == {("j", "springStiffness"): "7", ("j", "springReference"): ".5", ("", "static"): "true"}


# Files


@pytest.mark.parametrize("version", ["1.4", "1.5", "1.6", "1.7", "1.8", "1.9", "1.10", "1.11", "1.12"])
def test_all_supported_versions_are_read(tmp_path: Path, version: str) -> None:
    assert list(urdf(tmp_path, document(model(link("base")), version)).links) == ["base"]


@pytest.mark.parametrize("version", ["", "1.3", "1.13", "2.0", "1.1234", "one"])
def test_other_versions_are_errors(tmp_path: Path, version: str) -> None:
    (error,) = errors(tmp_path, document(model(link("base")), version))
    assert error.startswith("2: SDF ")


WORLD = '<world name="w">' + model(link("a") + "<static>1</static>", "floor") + model(link("b"), "one") + "{}</world>"


def test_the_only_model_of_a_world_that_is_no_scenery_is_the_robot(tmp_path: Path) -> None:
    assert urdf(tmp_path, document(WORLD.format(""))).root == "b"


def test_a_model_with_joints_is_a_robot_and_one_without_is_a_loose_object(tmp_path: Path) -> None:
    robot = model(TWO + turning("<xyz>0 0 1</xyz>"), "robot")
    assert urdf(tmp_path, document(WORLD.format(robot))).root == "base"


def test_one_of_several_models_must_be_chosen(tmp_path: Path) -> None:
    text = document(WORLD.format(model(link("c"), "two")))
    assert urdf(tmp_path, text, "two").root == "c"
    absent = "<include><uri>model://absent</uri></include>"
    assert urdf(tmp_path, text.replace("</world>", f"{absent}</world>"), "two").root == "c"
    assert errors(tmp_path, text) == ["2: the file has more than one model"]
    assert errors(tmp_path, text, "too") == ["2: the file has no model 'too'"]
    assert errors(tmp_path, document("")) == ["2: the file has no model"]


def test_names_must_be_unique(tmp_path: Path) -> None:
    assert errors(tmp_path, document(model(link("a") + link("a")))) == ["3: two links named 'a'"]
    assert errors(tmp_path, document(model(link("a") + "<link/>"))) == ["3: a link without a name"]
    nested = link("a::b") + "\n" + model(link("b"), "a") + joint("j", "a::b", "__model__")
    assert errors(tmp_path, document(model(nested), "1.6"))[0] == "4: two links named 'a::b'"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('<joint name="j" type="fixed"><child>arm</child></joint>', "joint 'j': no <parent>"),
        ('<joint name="j" type="fixed"><parent>base</parent></joint>', "joint 'j': no <child>"),
        (joint("j", "base", "hand"), "model 'm' has no frame 'hand'"),
        (turning("<xyz>0 0 0</xyz>"), "joint 'j': the axis must not be zero"),
        (turning('<xyz expressed_in="x">0 0 1</xyz>'), "model 'm' has no frame 'x'"),
        (turning("<xyz>0 0</xyz>"), "xyz must be 3 numbers, not '0 0'"),
        (turning("<xyz>0 0 1</xyz>", "<upper>nan</upper>"), "upper must be a number, not 'nan'"),
        (joint("j", "base", "arm", "<pose>1 2 3</pose>"), "pose must be 6 numbers in m and rad, not '1 2 3'"),
        (
            turning("<xyz>0 0 1</xyz><dynamics><damping>-2</damping></dynamics>"),
            "joint 'j': damping and friction must be numbers of at least 0",
        ),
        (link("hand", mass=-3.0), "link 'hand': the mass -3.0 is not a number of at least 0 (kg)"),
        (
            turning('<xyz>0 0 1</xyz><mimic joint="j"><multiplier>2</multiplier></mimic>'),
            "joint 'j' mimics itself",
        ),
        (joint("j", "base", "arm") + joint("k", "base", "arm"), "link 'arm' has two parents"),
    ],
)
def test_mistakes_are_reported_with_their_lines(tmp_path: Path, content: str, message: str) -> None:
    assert errors(tmp_path, document(model(TWO + "\n" + content)))[0] == f"4: {message}"


# Files made to be slow


COUNT = 20_000
SLOW = {
    "a circle": "".join(
        f'<link name="l{number}"><pose relative_to="l{(number + 1) % COUNT}"/></link>' for number in range(COUNT)
    ),
    "attached": '<link name="l"/>'
    + "".join(f'<frame name="f{number}" attached_to="f{number + 1}"/>' for number in range(COUNT))
    + "".join(joint(f"j{number}", "f0", "f1") for number in range(COUNT // 40)),
    "a long name": link("l", f'<pose relative_to="{"::".join("a" * 100_000)}"/>'),
    "missing models": "".join(f"<include><uri>model://m{number}</uri></include>" for number in range(COUNT)),
    "large numbers": link(
        "l", '<collision name="c"><geometry><sphere><radius>1e200</radius></sphere></geometry></collision>'
    ),
}


@pytest.mark.parametrize("content", SLOW.values(), ids=SLOW)
def test_a_file_made_to_be_slow_is_refused(tmp_path: Path, content: str) -> None:
    """Work that grew with the square of its length would take minutes."""
    assert errors(tmp_path, document(model(content)))
