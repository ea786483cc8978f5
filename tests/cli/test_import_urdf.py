"""`graphrun import-robot`: what it writes loads, what it refuses leaves nothing behind."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
import yaml

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.select import open_transport
from tests.cli.harness import ROOT, Graphrun, Result
from tests.jobs.harness import Job
from tests.physics.mjcf_models import QUADRUPED

CART = "ws/cart/urdf/cart.urdf"
INERTIA = '<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
BODY = f"""  <link name="base_link">
    <inertial><mass value="5"/>{INERTIA}</inertial>
    <collision><geometry><mesh filename="package://cart/meshes/body.obj"/></geometry></collision>
    <visual><geometry><mesh filename="../meshes/body.obj"/></geometry></visual>
  </link>
"""
REST = f"""  <link name="grip"><inertial><mass value="1"/>{INERTIA}</inertial></link>
  <link name="finger"><inertial><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="grip_joint" type="revolute">
    <parent link="base_link"/><child link="grip"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="20" velocity="2"/>
  </joint>
  <joint name="finger_joint" type="prismatic">
    <parent link="base_link"/><child link="finger"/><axis xyz="1 0 0"/><mimic joint="grip_joint" multiplier="0.1"/>
    <limit lower="0" upper="0.1" effort="5" velocity="0"/>
  </joint>
  <transmission name="grip_transmission"/>
  <ros2_control name="hardware" type="system"/>
  <gazebo reference="grip"><mu1>0.2</mu1><sensor name="eye" type="camera"/></gazebo>
  <gazebo><plugin name="drive" filename="libdrive.so"/></gazebo>
</robot>
"""
WHEEL = f"""  <link name="{{side}}_wheel">
    <inertial><mass value="1"/>{INERTIA}</inertial>
    <collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.2" length="0.05"/></geometry></collision>
  </link>
  <joint name="{{side}}_joint" type="continuous">
    <parent link="base_link"/><child link="{{side}}_wheel"/><origin xyz="0 {{y}} 0"/><axis xyz="0 1 0"/>
  </joint>
"""
WHEELS = WHEEL.format(side="left", y=0.3) + WHEEL.format(side="right", y=-0.3)
URDF = f'<robot name="cart">\n{BODY}{WHEELS}{REST}'
PARAMETERS = "rcl_interfaces/srv/GetParameters"
XACRO = f"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart">
  <xacro:arg name="prefix" default=""/>
{(BODY + WHEELS + REST).replace('"left_joint"', '"$(arg prefix)left_joint"')}"""
ODOMETRY = """graph: odom
nodes:
  Tick: OnPlaybackTick
  Odometry: {type: IsaacComputeOdometry, inputs: {chassisPrim: /cart/base_link}}
  Publish: ROS2PublishOdometry
connections:
  - Tick.tick -> Odometry.execIn
  - Odometry.execOut -> Publish.execIn
  - Odometry.linearVelocity -> Publish.linearVelocity
  - Odometry.angularVelocity -> Publish.angularVelocity
"""
SCENE = "scene: cart\nworld: worlds/flat_grid.xml\nrobots:\n  cart: {use: robots/cart.yaml, position: [0, 0, 0.2]}\n"


@pytest.fixture
def cart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to stand in, with a package beside scenes that wait for a robot."""
    for folder in ("ws/cart/urdf", "ws/cart/meshes", "scenes/robots"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "ws/cart/package.xml").write_text("<package><name>cart</name></package>", encoding="utf-8")
    (tmp_path / "ws/cart/meshes/body.obj").write_text(TETRAHEDRON, encoding="utf-8")
    (tmp_path / CART).write_text(URDF, encoding="utf-8")
    (tmp_path / "ws/cart/urdf/cart.urdf.xacro").write_text(XACRO, encoding="utf-8")
    (tmp_path / "scenes/cart.yaml").write_text(SCENE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def imported(graphrun: Graphrun, *arguments: str, text: str = "", **ended: Any) -> Result:
    """Import a description, or that of the cart, which may have another text."""
    if text:
        Path(CART).write_text(text, encoding="utf-8")
    return graphrun("import-robot", *(arguments or [CART]), "-o", "scenes/robots/cart.yaml", **ended)


def robot(folder: Path) -> dict[str, object]:
    data = yaml.safe_load((folder / "scenes/robots/cart.yaml").read_text(encoding="utf-8"))
    assert isinstance(data, dict)
    return data


def test_a_robot_file_names_every_link_and_joint_and_loads_in_a_scene(graphrun: Graphrun, cart: Path) -> None:
    imported(graphrun, code=0, err="")
    text = (cart / "scenes/robots/cart.yaml").read_text(encoding="utf-8")
    for name in ("base_link", "left_wheel", "right_wheel", "grip", "finger", "left_joint", "finger_joint"):
        assert name in text
    assert "base_link: 5 kg, mesh package://cart/meshes/body.obj" in text
    assert "grip_joint: revolute, base_link -> grip, axis 0 1 0, -1 to 1 rad, up to 20 N m" in text
    assert "follows grip_joint x 0.1 + 0" in text
    assert robot(cart)["joints"] == {
        "left_joint": {"drive": {"damping": 883.0}},  # 9 kg on two wheels of 0.2 m: 8.83 N m by 0.01 rad/s
        "right_joint": {"drive": {"damping": 883.0}},
        "grip_joint": {
            "drive": {
                "stiffness": 2000.0,  # its 20 N m by 0.01 rad
                "damping": 127.0,  # by 5 Hz times pi
                "max_velocity": 2.0,
                "interpolate": True,
                "gravity_compensation": True,
            }
        },
        "finger_joint": {},
    }
    checked = graphrun("check", "scenes/cart.yaml", "--allow", "ws/cart")
    assert checked.code == 0
    assert graphrun("run", "scenes/cart.yaml", "--allow", "ws", "--transport", "memory", "--for", "0.1s").code == 0


def test_the_folder_of_a_robot_file_is_made(graphrun: Graphrun, cart: Path) -> None:
    assert graphrun("import-robot", CART, "-o", "new/robots/cart.yaml").code == 0
    made = (cart / "new/robots/cart.yaml").read_text(encoding="utf-8")
    assert imported(graphrun).code == 0
    beside = (cart / "scenes/robots/cart.yaml").read_text(encoding="utf-8")
    assert made == beside


def test_the_report_lists_what_was_found_and_what_was_not_carried_over(graphrun: Graphrun, cart: Path) -> None:
    assert imported(graphrun).lines == [
        "wrote scenes/robots/cart.yaml",
        "5 links, 4 joints of which 4 move, 9 kg",
        "base link base_link, free",
        "lowest collider at z = -0.2000 m, all joints at zero",
        "meshes: 2 unchanged",
        "joints that follow another joint: finger_joint",
        "carried over: velocity limits of drives: grip_joint 2 (cart.urdf:25)",
        (
            "carried over: sensor eye: camera of 320 x 240 pixels on grip at 30 Hz, published on camera/image_raw, "
            "camera/camera_info (cart.urdf:33)"
        ),
        (
            "guessed: base: differential with 2 driven wheels, radius 0.2 m, track 0.6 m, from the wheels, which are parallel "
            "(cart.urdf:11)"
        ),
        "guessed: limits of the base: speed 1 m/s, turn 2 rad/s, acceleration 1 m/s2, turn_acceleration 2 rad/s2",
        "guessed: odometry: encoders of 4096 ticks a turn, and a slip of 0.006 m after 1 m",
        "guessed: damping of velocity drives: 883 N m s/rad, by the weight on the wheels",
        "guessed: velocity drive: left_joint, right_joint; driven wheels of the base (cart.urdf:11)",
        "guessed: position drive: grip_joint; a limit of effort suggests a motor, which holds them (cart.urdf:23)",
        (
            "guessed: gains of position drives: 5.0 Hz, at least critically damped by the mass matrix; full effort at 10 mrad or "
            "10 mm; gravity_compensation and interpolate (cart.urdf:23)"
        ),
        "guessed: friction of wheels: 1 on any floor: left_wheel, right_wheel",
        "guessed: sensor eye: no update_rate: 30 Hz (cart.urdf:33)",
        "guessed: sensor eye: no topic: published on camera/image_raw, camera/camera_info (cart.urdf:33)",
        "guessed: sensor eye: its frame eye_optical_frame is not a link: a graph publishes it on tf_static (cart.urdf:33)",
        "not carried over: link grip: friction: it has no collider (cart.urdf:33)",
        "not carried over: transmission grip_transmission: it lists no moving joint (cart.urdf:31)",
        "not carried over: ros2_control hardware: it lists no moving joint (cart.urdf:32)",
        "not carried over: gazebo plugin drive (cart.urdf:34)",
        "scenes with this robot read files outside of their folder: run them with --allow ws/cart",
        "in a scene: robots: {cart: {use: robots/cart.yaml, position: [0, 0, 0.2]}}",
    ]


ROBOT_ON_WHEELS = f"""<robot name="cart">
  <link name="base_link">
    <inertial><mass value="5"/>{INERTIA}</inertial>
    <collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision>
  </link>
  <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="ball_joint" type="fixed">
    <parent link="base_link"/><child link="ball"/><origin xyz="-0.3 0 -0.15"/>
  </joint>
{WHEEL.format(side="right", y=-0.3)}{WHEEL.format(side="left", y=0.3)}</robot>
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<robot", "<robot"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>'),  # a positive speed of the wheels takes such a robot backwards
    ],
)
def test_a_robot_with_two_wheels_drives_after_the_import_without_edits(
    graphrun: Graphrun, cart: Path, old: str, new: str
) -> None:
    imported(graphrun, text=ROBOT_ON_WHEELS.replace(old, new), code=0)
    checked = graphrun("check", "scenes/cart.yaml", "--allow", "ws/cart", "--strict")
    assert (checked.code, checked.err) == (0, ""), checked.out
    with Job(Path("scenes/cart.yaml"), allowed=[Path("ws/cart")]) as job:
        job.drive("/cmd_vel", 0.5, 0.4, 4.0)
        velocity = job.velocity("/ground_truth/odom")
    assert velocity == pytest.approx((0.5, 0.4), rel=0.01)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (WHEEL.format(side="left", y=0.3), "", "wheels on one side only: no graph drives them"),
        ('<origin xyz="0 0.3 0"/>', '<origin xyz="0.2 -0.3 0"/>', "wheels on one side only: no graph drives them"),
    ],
)
def test_a_base_without_a_graph_is_reported_with_the_reason(
    graphrun: Graphrun, cart: Path, old: str, new: str, reason: str
) -> None:
    assert old in ROBOT_ON_WHEELS
    lines = imported(graphrun, text=ROBOT_ON_WHEELS.replace(old, new), code=0).lines
    assert f"not carried over: {reason} (cart.urdf:14)" in lines
    assert "graphs" not in robot(cart)


def test_equal_remarks_are_merged_and_only_the_report_cuts_long_lines(graphrun: Graphrun, cart: Path) -> None:
    names = [f"a_long_name_of_a_link_{number}" for number in range(40)]
    tags = "".join(f'<gazebo reference="{name}"><material>Gazebo/Black</material></gazebo>' for name in names)
    (cart / "ws/cart/urdf/cart.urdf").write_text(URDF.replace("</robot>", f"{tags}</robot>"), encoding="utf-8")
    (told,) = [line for line in imported(graphrun).lines if "Gazebo/Black" in line]
    assert told.startswith(
        "not carried over: gazebo material Gazebo/Black: a_long_name_of_a_link_0, a_long_name_of_a_link_1,"
    )
    assert told.endswith("… (cart.urdf:35)")
    lines = (cart / "scenes/robots/cart.yaml").read_text(encoding="utf-8").splitlines()
    assert max(map(len, lines)) <= 130
    assert all(name in "\n".join(lines) for name in names)


@pytest.mark.parametrize(
    ("collider", "lowest"),
    [
        ('<origin xyz="0 0 -1" rpy="0.3 0 0"/><geometry><sphere radius="0.5"/></geometry>', -1.5),
        (
            '<origin xyz="0 0 -1" rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.3" length="4"/></geometry>',
            -1.3,
        ),
        ('<origin xyz="0 0 -1" rpy="0 0.7853981633974483 0"/><geometry><box size="2 2 2"/></geometry>', -1 - 2**0.5),
        ('<origin rpy="3.141592653589793 0 0"/><geometry><mesh filename="../meshes/body.obj"/></geometry>', -1.0),
    ],
)
def test_the_report_gives_the_height_of_a_robot(graphrun: Graphrun, cart: Path, collider: str, lowest: float) -> None:
    """The mesh reaches from 0 to 1 along its z axis, which is upside down here; corners of the box point down."""
    text = URDF.replace("<visual>", f"<collision>{collider}</collision><visual>", 1)
    (cart / "ws/cart/urdf/cart.urdf").write_text(text, encoding="utf-8")
    assert f"lowest collider at z = {lowest:.4f} m, all joints at zero" in imported(graphrun).lines


def test_the_report_on_a_robot_without_wheels_names_the_option_fixed_base(graphrun: Graphrun, cart: Path) -> None:
    lines = imported(graphrun, text=URDF.replace(WHEELS, "")).lines
    assert "base link base_link, free; --fixed-base fixes it to the world" in lines
    assert lines[-1] == "in a scene: robots: {cart: {use: robots/cart.yaml}}"


def test_the_urdf_of_a_xacro_robot_is_written_beside_the_robot_file(graphrun: Graphrun, cart: Path) -> None:
    result = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", "prefix:=front_")
    assert result.lines[0] == "wrote scenes/robots/cart.urdf, scenes/robots/cart.yaml"
    assert robot(cart)["urdf"] == "cart.urdf"
    assert "front_left_joint" in robot(cart)["joints"]  # type: ignore[operator]
    urdf = (cart / "scenes/robots/cart.urdf").read_text(encoding="utf-8")
    assert "<xacro:" not in urdf
    assert f'filename="{(cart / "ws/cart/meshes/body.obj").as_uri()}"' in urdf
    assert graphrun("check", "scenes/cart.yaml", "--allow", "ws").code == 0


def test_warnings_of_mujoco_are_reported(graphrun: Graphrun, cart: Path) -> None:
    textured = TETRAHEDRON.replace("f 1 3 2", "vt 0 0\nf 1/9 3/1 2/1").replace("f 1 2 4", "f 1/1 2/1 4/1")
    textured = textured.replace("f 1 4 3", "f 1/1 4/1 3/1").replace("f 2 3 4", "f 2/1 3/1 4/1")
    (cart / "ws/cart/meshes/body.obj").write_text(textured, encoding="utf-8")
    result = imported(graphrun, code=0)
    assert "ws/cart/urdf/cart.urdf:1:1: warning W205: MuJoCo: obj_decoder: invalid" in result.err


def test_arguments_of_xacro_may_stand_anywhere_on_the_command_line(graphrun: Graphrun, cart: Path) -> None:
    target = ("-o", "scenes/robots/cart.yaml")
    assert graphrun("import-robot", *target, "prefix:=a_", "ws/cart/urdf/cart.urdf.xacro").code == 0
    assert "a_left_joint" in robot(cart)["joints"]  # type: ignore[operator]
    assert graphrun("import-robot", "ws/cart/urdf/cart.urdf.xacro", *target, "--force", "prefix:=b_").code == 0
    assert "b_left_joint" in robot(cart)["joints"]  # type: ignore[operator]


def test_the_expanded_urdf_does_not_overwrite_the_description(graphrun: Graphrun, cart: Path) -> None:
    source = cart / "ws/cart/urdf/robot.urdf"
    source.write_text(XACRO, encoding="utf-8")
    result = graphrun("import-robot", "ws/cart/urdf/robot.urdf", "-o", "ws/cart/urdf/robot.yaml", "--force", code=2)
    assert "the URDF written beside it would overwrite ws/cart/urdf/robot.urdf; choose another name" in result.err
    assert source.read_text(encoding="utf-8") == XACRO


def test_a_robot_file_replaces_a_symbolic_link(graphrun: Graphrun, cart: Path) -> None:
    (cart / "elsewhere").mkdir()
    (cart / "elsewhere/old.yaml").write_text("mine", encoding="utf-8")
    (cart / "scenes/robots/cart.yaml").symlink_to(cart / "elsewhere/old.yaml")
    text = URDF.replace("../meshes", "package://cart/meshes").replace("package://cart", "../ws/cart")
    (cart / "scenes/plain.urdf").write_text(text, encoding="utf-8")
    assert imported(graphrun, "scenes/plain.urdf", "--force", "--allow", "ws").code == 0
    assert robot(cart)["urdf"] == "../plain.urdf"
    assert (cart / "elsewhere/old.yaml").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("name", ["true", "null", "nan"])
def test_a_yaml_word_is_a_legal_name_of_a_robot_file(graphrun: Graphrun, cart: Path, name: str) -> None:
    assert graphrun("import-robot", CART, "-o", f"scenes/robots/{name}.yaml").code == 0
    scene = SCENE.replace("robots/cart.yaml", f"robots/{name}.yaml")
    (cart / "scenes/cart.yaml").write_text(scene, encoding="utf-8")
    assert graphrun("check", "scenes/cart.yaml", "--allow", "ws").code == 0


def test_a_target_that_cannot_be_written_is_reported(graphrun: Graphrun, cart: Path) -> None:
    (cart / "scenes/robots/cart.yaml").mkdir()
    result = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", "--force", code=1, out="")
    assert "error: scenes/robots/cart.yaml: Is a directory" in result.err
    assert [path.name for path in (cart / "scenes/robots").iterdir()] == ["cart.yaml"]


def test_the_options_fixed_base_and_package_path_are_written_to_the_robot_file(graphrun: Graphrun, cart: Path) -> None:
    alone = cart / "elsewhere.urdf"
    alone.write_text(URDF.replace("../meshes", "ws/cart/meshes"), encoding="utf-8")
    assert (
        imported(graphrun, "elsewhere.urdf", "--package-path", "ws", "--fixed-base")
        .lines[2]
        .endswith("fixed to the world")
    )
    assert robot(cart)["fixed_base"] is True
    assert robot(cart)["package_paths"] == [str(cart / "ws/cart")]
    assert graphrun("check", "scenes/cart.yaml", "--allow", ".").code == 0


def test_installed_packages_are_found_without_being_named(
    graphrun: Graphrun, cart: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (cart / "install/share").mkdir(parents=True)
    (cart / "ws/cart").rename(cart / "install/share/cart")
    (cart / "scenes/robots/plain.urdf").write_text(URDF.replace("../meshes", "package://cart/meshes"), encoding="utf-8")
    assert imported(graphrun, "scenes/robots/plain.urdf").code == 1
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere{os.pathsep}{cart / 'install'}")
    assert imported(graphrun, "scenes/robots/plain.urdf").code == 0
    assert "package_paths" not in robot(cart)
    assert graphrun("check", "scenes/cart.yaml").code == 0
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    assert graphrun("check", "scenes/cart.yaml").code == 1


def test_nothing_is_written_over_unless_asked_for(graphrun: Graphrun, cart: Path) -> None:
    target = cart / "scenes/robots/cart.yaml"
    target.write_text("mine", encoding="utf-8")
    result = imported(graphrun, code=2)
    assert "scenes/robots/cart.yaml: existing files are overwritten only with --force" in result.err
    assert target.read_text(encoding="utf-8") == "mine"
    target.unlink()
    (cart / "scenes/robots/cart.urdf").write_text("mine", encoding="utf-8")
    assert imported(graphrun, "ws/cart/urdf/cart.urdf.xacro").code == 2
    assert not target.exists()
    assert imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", "--force").code == 0
    assert [path.name for path in sorted((cart / "scenes/robots").iterdir())] == ["cart.urdf", "cart.yaml"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("body.obj", "bdy.obj", "error S101: no file 'package://cart/meshes/bdy.obj'"),
        ("body.obj", "bdy.obj", "looked in: {ws}/meshes"),
        ('link="grip"', 'link="grp"', "did you mean 'grip'?"),
        ('mass value="1"', 'mass value="-1"', "mass '-1' is not a number of at least 0 (kg)"),
        ("</robot>", "", "XML syntax"),
        (
            "</robot>",
            '<mujoco><compiler boundmass="heavy"/></mujoco></robot>',
            "error S103: <compiler>: boundmass must be a number, not 'heavy'",
        ),
        ('link name="grip"', 'link name="1 grip"', "no child link 'grip'"),
    ],
)
def test_a_description_with_mistakes_is_explained_and_nothing_is_written(
    graphrun: Graphrun, cart: Path, old: str, new: str, told: str
) -> None:
    result = imported(graphrun, text=URDF.replace(old, new, 1), code=1, out="")
    assert told.format(ws=cart / "ws/cart") in result.err
    assert result.err.endswith("scenes/robots/cart.yaml is not written\n")
    assert list((cart / "scenes/robots").iterdir()) == []


def test_the_first_of_repeated_elements_counts_and_the_repetition_is_reported(graphrun: Graphrun, cart: Path) -> None:
    result = imported(graphrun, text=URDF.replace("<axis", '<axis xyz="1 0 0"/><axis', 1), code=0, err="")
    assert "only the first of 2 <axis> counts: delete the other <axis>" in result.out


def test_names_in_a_description_are_escaped_in_the_robot_file(graphrun: Graphrun, cart: Path) -> None:
    """A line break in a name does not become a line of YAML, nor does a colour steer the terminal."""
    odd = "a: {}&#10;graphs: {x: {use: /etc/passwd}}&#155;31m"
    result = imported(graphrun, text=URDF.replace('"grip_joint"', f'"{odd}"'), code=0, err="")
    assert "\x9b" not in result.out
    data = robot(cart)
    assert set(data) >= {"format", "robot", "urdf", "package_paths", "base_link", "joints"}
    assert "/etc/passwd" not in str(data["graphs"])
    assert "a: {}\ngraphs: {x: {use: /etc/passwd}}\x9b31m" in data["joints"]  # type: ignore[operator]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "give exactly one of a file, --topic and --node"),
        ((CART, "--topic"), "give exactly one of a file, --topic and --node"),
        (("ws/cart/urdf/car.urdf",), "no file 'ws/cart/urdf/car.urdf'"),
        ((CART, "a:=1"), "a:=1: ws/cart/urdf/cart.urdf does not use xacro"),
        (("ws/cart/urdf/cart.urdf.xacro", "prefix=1"), "prefix=1: write an argument as NAME:=VALUE, as for xacro"),
        (
            ("a:=1", "--topic", "/x"),
            "a:=1: only a xacro file takes arguments; a description from --topic or --node has none",
        ),
        ((CART, "--allow", "nowhere"), "no folder 'nowhere'"),
        (
            ("--topic", "/x", "--timeout", "nan"),
            "argument --timeout: 'nan' is not a time; write 10, 10s, 500ms or 2min",
        ),
        (("--topic", "/x", "--timeout", "0s"), "--timeout: write a time above 0 s, at most 1e+06 s"),
    ],
)
def test_a_contradictory_command_line_is_refused(
    graphrun: Graphrun, cart: Path, arguments: tuple[str, ...], told: str
) -> None:
    result = graphrun("import-robot", *arguments, "-o", "scenes/robots/cart.yaml", code=2, out="")
    assert told in result.err


@pytest.mark.parametrize("target", ["cart.urdf", "scenes/robots/my-cart.yaml"])
def test_an_illegal_name_of_the_robot_file_is_refused(graphrun: Graphrun, cart: Path, target: str) -> None:
    result = graphrun("import-robot", CART, "-o", target, code=2, out="")
    assert f"-o {target}: " in result.err


def test_an_unknown_xacro_argument_is_reported(graphrun: Graphrun, cart: Path) -> None:
    result = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", "prefx:=a", code=1)
    assert "has no argument 'prefx'" in result.err
    assert "did you mean 'prefix'?" in result.err


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "OFF")


def test_a_description_on_the_network_is_written_beside_the_robot_file(
    graphrun: Graphrun, cart: Path, domain: Domain
) -> None:
    """As robot_state_publisher latches it, over DDS."""
    transport = open_transport("dds", JoinOptions(domain, "robot_state_publisher"))
    writer = transport.writer("/robot_description", "std_msgs/msg/String", LATCHED)
    text = URDF.replace("../meshes", "package://cart/meshes")
    writer.write(messages.encode(messages.message_class("std_msgs/msg/String")(data=text)))
    result = imported(graphrun, "--topic", "--transport", "dds", "--package-path", "ws", "--timeout", "30")
    transport.close()
    assert result.code == 0, result.err
    assert "waiting for /robot_description; dds (Eclipse Cyclone DDS)" in result.err
    assert result.lines[0] == "wrote scenes/robots/cart.urdf, scenes/robots/cart.yaml"
    assert robot(cart)["urdf"] == "cart.urdf"
    assert graphrun("check", "scenes/cart.yaml", "--allow", "ws").code == 0


def test_a_topic_without_messages_is_reported(graphrun: Graphrun, cart: Path, domain: Domain) -> None:
    result = imported(graphrun, "--topic", "/quiet", "--transport", "dds", "--timeout", "200ms", code=1)
    assert "error: no message arrived on /quiet within 0.2 s" in result.err
    assert list((cart / "scenes/robots").iterdir()) == []


def test_the_parameter_of_a_node_is_read_without_ros(graphrun: Graphrun, cart: Path, domain: Domain) -> None:
    transport = open_transport("dds", JoinOptions(domain, "robot_state_publisher"))

    def answer(request_id: bytes, data: bytes) -> None:
        known = DEFINITIONS
        assert messages.decode(data, f"{PARAMETERS}_Request").names == ["robot_description"]
        response, value = known.initial(f"{PARAMETERS}_Response"), known.initial("rcl_interfaces/msg/ParameterValue")
        value.type, value.string_value = 4, URDF.replace("../meshes", "package://cart/meshes")
        response.values = [value]
        server.answer(request_id, messages.encode(response))

    server = transport.server("/robot_state_publisher/get_parameters", PARAMETERS, QoS(), answer)
    given = ("--node", "robot_state_publisher", "--transport", "dds", "--package-path", "ws", "--timeout", "30")
    result = imported(graphrun, *given)
    transport.close()
    assert result.code == 0, result.err
    assert result.lines[0] == "wrote scenes/robots/cart.urdf, scenes/robots/cart.yaml"


def test_the_robot_that_ships_is_recognised(graphrun: Graphrun, cart: Path) -> None:
    """Radius and track are those of the reference: 0.049 m and 2 x 0.2261616 m."""
    result = imported(graphrun, str(ROOT / "scenes/robots/dd100/dd100.urdf"))
    assert "15 links, 14 joints of which 2 move, 10.32 kg" in result.lines
    assert any("differential with 2 driven wheels, radius 0.049 m, track 0.452323 m" in line for line in result.lines)
    assert graphrun("check", "scenes/cart.yaml").code == 0


MACRO = f"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default=""/>
  <xacro:macro name="cart" params="height:=0.3 side">
{(BODY + WHEELS).replace("../", "package://cart/").replace('"left_joint"', '"$(arg prefix)${side}_joint"')}  </xacro:macro>
</robot>
"""


@pytest.fixture
def macro(cart: Path) -> Path:
    (cart / "ws/cart/urdf/macro.urdf.xacro").write_text(MACRO, encoding="utf-8")
    return cart


def test_a_robot_of_a_macro_gets_a_file_that_calls_it(graphrun: Graphrun, macro: Path) -> None:
    result = imported(graphrun, "ws/cart/urdf/macro.urdf.xacro", "--macro", "cart", "side:=left", "prefix:=my_")
    assert "wrote scenes/robots/cart.urdf.xacro, scenes/robots/cart.urdf, scenes/robots/cart.yaml" in result.out
    text = (macro / "scenes/robots/cart.urdf.xacro").read_text(encoding="utf-8")
    assert '<xacro:cart side="left"/>' in text
    assert "my_left_joint" in robot(macro)["joints"]  # type: ignore[operator]
    (macro / "scenes/robots/cart.urdf.xacro").write_text(text.replace('"my_"', '"your_"'), encoding="utf-8")
    imported(graphrun, "scenes/robots/cart.urdf.xacro", "--force", "--package-path", "ws", code=0)
    assert "your_left_joint" in robot(macro)["joints"]  # type: ignore[operator]


def test_the_only_macro_of_a_file_is_used_and_reported(graphrun: Graphrun, macro: Path) -> None:
    result = imported(graphrun, "ws/cart/urdf/macro.urdf.xacro", "side:=left")
    assert "note: the file defines macros but no robot; cart.urdf.xacro calls its macro 'cart'" in result.out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--macro", "carts"], "did you mean 'cart'?"),
        ([], "add to the command: side:=…"),
        (["side:=left", "hieght:=1"], "has no argument 'hieght'"),
    ],
)
def test_a_macro_that_cannot_be_called_writes_nothing(
    graphrun: Graphrun, macro: Path, arguments: list[str], told: str
) -> None:
    result = imported(graphrun, "ws/cart/urdf/macro.urdf.xacro", *arguments, code=1)
    assert told in result.err
    assert not list((macro / "scenes/robots").iterdir())


def test_the_generated_xacro_file_does_not_overwrite_the_file_of_the_macro(graphrun: Graphrun, macro: Path) -> None:
    path = macro / "scenes/robots/cart.urdf.xacro"
    path.write_text(MACRO, encoding="utf-8")
    result = imported(graphrun, str(path), "side:=left", "--force", "--package-path", "ws", code=1)
    assert "would overwrite" in result.err
    assert path.read_text(encoding="utf-8") == MACRO


def test_arguments_are_listed_with_their_defaults(graphrun: Graphrun, macro: Path) -> None:
    result = graphrun("import-robot", "ws/cart/urdf/macro.urdf.xacro", "--args")
    assert result.out.splitlines() == [
        "arguments of ws/cart/urdf/macro.urdf.xacro:",
        "  prefix  default ''",
        "parameters of the macro cart, which --macro cart imports as a robot:",
        "  height  default '0.3'",
        "  side    no default",
    ]
    assert graphrun("import-robot", CART, "--args").out == f"{CART}: no xacro syntax, so it takes no arguments\n"


def test_a_package_that_is_missing_can_be_left_out(graphrun: Graphrun, cart: Path) -> None:
    lidar = '<xacro:include filename="$(find lidars)/a2.xacro"/><xacro:a2 parent="base_link"/></robot>'
    (cart / "ws/cart/urdf/cart.urdf.xacro").write_text(XACRO.replace("</robot>", lidar), encoding="utf-8")
    result = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", code=1)
    assert "no package 'lidars'" in result.err
    assert "macros that are called but not defined: a2" in result.err
    result = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", "--without", "lidars")
    assert "note: left out on request: package 'lidars': includes: $(find lidars)/a2.xacro" in result.out


def test_meshes_of_a_package_can_be_left_out_of_a_plain_urdf(graphrun: Graphrun, cart: Path) -> None:
    text = URDF.replace("package://cart/meshes/body.obj", "package://elsewhere/body.obj")
    told = imported(graphrun, text=text, code=1).err
    assert "error S101: no package 'elsewhere'" in told
    assert "meshes: package://elsewhere/body.obj" in told
    assert "or leave out the package: --without elsewhere" in told
    result = imported(graphrun, CART, "--without", "elsewhere")
    assert "note: left out on request: a collision of link 'base_link'" in result.out
    assert "elsewhere" not in (cart / "scenes/robots/cart.urdf").read_text(encoding="utf-8")


def test_a_written_description_names_the_file_of_controllers_by_its_package(graphrun: Graphrun, cart: Path) -> None:
    plugin = '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so">'
    plugin += "<parameters>$(find cart)/config/c.yaml</parameters></plugin></gazebo></robot>"
    (cart / "ws/cart/urdf/cart.urdf.xacro").write_text(XACRO.replace("</robot>", plugin), encoding="utf-8")
    (cart / "ws/cart/config").mkdir()
    controllers = "grip: {type: position_controllers/JointGroupPositionController, joints: [grip_joint]}\n"
    (cart / "ws/cart/config/c.yaml").write_text(controllers, encoding="utf-8")
    first = imported(graphrun, "ws/cart/urdf/cart.urdf.xacro", code=0)
    written = (cart / "scenes/robots/cart.urdf").read_text(encoding="utf-8")
    assert "<parameters>package://cart/config/c.yaml</parameters>" in written
    assert str(cart) not in "".join(line for line in written.splitlines() if "mesh" not in line)
    commanded = "carried over: position drive: grip_joint; position command of controller"
    again = graphrun("import-robot", "scenes/robots/cart.urdf", "-o", "again.yaml", "--package-path", "ws", code=0)
    assert any(line.startswith(commanded) for line in first.lines)
    assert any(line.startswith(commanded) for line in again.lines)


def test_the_old_name_of_the_verb_still_works(graphrun: Graphrun, cart: Path) -> None:
    (cart / "new").mkdir()
    assert graphrun("import-urdf", CART, "-o", "new/cart.yaml").code == 0


def test_a_mujoco_model_becomes_a_robot_file_and_a_project(graphrun: Graphrun, project: Path) -> None:
    (project / "pup.xml").write_text(QUADRUPED, encoding="utf-8")
    told = graphrun("import-robot", "pup.xml", "-o", "robots/pup.yaml").out
    assert "12 move" in told
    assert "carried over: motors of the model: FL_hip_joint" in told
    assert "in a scene: robots: {pup: {use: robots/pup.yaml" in told
    robot = yaml.safe_load((project / "robots/pup.yaml").read_text(encoding="utf-8"))
    assert (robot["mjcf"], robot["base_link"], robot["start"]) == ("../pup.xml", "trunk", "home")
    assert robot["sensors"] == {"imu_sensor": {"type": "imu", "parent": "imu", "profile": {"rate": 100.0}}}
    assert graphrun("new", "dog", "--from", "pup.xml").code == 0
    assert (project / "dog/robots/dog_model/pup.xml").read_text(encoding="utf-8") == QUADRUPED
    assert graphrun("check", "dog/dog.yaml").code == 0
    assert "settle: false" in (project / "dog/dog.yaml").read_text(encoding="utf-8")


def test_arguments_of_xacro_are_no_arguments_of_a_mujoco_model(graphrun: Graphrun, project: Path) -> None:
    (project / "pup.xml").write_text(QUADRUPED, encoding="utf-8")
    result = graphrun("import-robot", "pup.xml", "-o", "robots/pup.yaml", "arm:=true", code=2, out="")
    assert "arm:=true: pup.xml is a MuJoCo model, which has no arguments" in result.err
