"""Robots and worlds of other tests, in all formats, and scenes that ship."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from tests import arm_robot
from tests.bringup.robots import arms, descriptions, imported_arms, roller_bases
from tests.bringup.robots.harness import CASTER, MESH, drum, rover, wheel
from tests.bringup.robots.imported_bases import BASES, description, sdf
from tests.descriptions.sdf.harness import BALL, INERTIA, document, joint, link, model, pose
from tests.descriptions.xacro.test_xacro import CART as XACRO
from tests.descriptions.xacro.test_xacro import WHEEL
from tests.physics import mjcf_models
from tests.physics.bases import MECANUM_WHEELS, SKID, SKID_WHEELS
from tests.physics.harness import CART
from tests.physics.model_arrays import mesh_texts

ROOT = Path(__file__).resolve().parents[3]
PARTS = ROOT / "tests/format/cases/parts"
Files = Mapping[str, str | bytes]

WHEELS = {"differential": "", "skid": SKID_WHEELS, "mecanum": MECANUM_WHEELS, "car": "self_collision: true\n"}
"""More keys of the robot files of bases."""
DRIVEN = "joints:\n  {}: {{armature: 0.02, drive: {{stiffness: 300, damping: 20}}}}\n"


def urdf(name: str, text: str, keys: str = "", more: Files | None = None) -> tuple[str, Files]:
    """Return a URDF with a robot file that has the given keys."""
    return name, {"bot.urdf": text, "bot.yaml": f"robot: bot\nurdf: bot.urdf\n{keys}", **(more or {})}


def of_urdf() -> Iterator[tuple[str, Files]]:
    """Yield URDF descriptions by name, each with a robot file."""
    for name, base in BASES.items():
        yield name, {"bot.urdf": description(base), "bot.yaml": base.files(WHEELS[name])["bot.yaml"]}
    yield urdf("omni wheels with rollers", roller_bases.rolling_base(roller_bases.THREE, rollers=4))
    yield urdf(
        "mecanum wheels with rollers", roller_bases.rolling_base(roller_bases.FOUR[:2], 3), "self_collision: true\n"
    )
    yield urdf("omni wheels", description(roller_bases.PLAIN), DRIVEN.format("w1_joint"))
    yield "arm", {"bot.urdf": arm_robot.urdf(), "bot.yaml": arm_robot.robot_file().replace("arm.urdf", "bot.urdf")}
    shown = arm_robot.robot_file().replace("arm.urdf", "bot.urdf").replace("fixed_base: true", "fixed_base: false")
    yield "arm with shapes", {"bot.urdf": arm_robot.urdf(shapes=True), "bot.yaml": shown}
    yield urdf("arm of two joints", mjcf_models.ARM_URDF, mjcf_models.ARM_KEYS)
    gripper = imported_arms.arm(3, "plate", gripper=True)
    yield urdf("arm with a gripper", imported_arms.bolted(gripper), "base_link: world\n" + DRIVEN.format("joint_2"))
    limbs = arms.limb("left", 6, at="0 .2 .1") + arms.limb("right", 4, at="0 -.2 .1", down=True)
    yield urdf("two arms", arms.robot(limbs), "fixed_base: true\n" + DRIVEN.format("left3"))
    yield urdf(
        "sensors of Gazebo", f"{descriptions.BODY}</robot>", "base_link: base_footprint\n" + DRIVEN.format("arm_joint")
    )
    yield urdf("cart", CART, DRIVEN.format("arm_joint") + "frames: {eye: {parent: base_link, position: [0.1, 0, 0]}}\n")
    drums = {"wheel.obj": drum(16)}
    meshed = rover(CASTER, wheels=wheel("left", 0.2, MESH) + wheel("right", -0.2, MESH))
    yield urdf("wheels of meshes", meshed, "wheel_colliders: {left_wheel: {radius: 0.1, width: 0.04}}\n", drums)
    inertia = '<mujoco><compiler inertiafromgeom="true" balanceinertia="true"/></mujoco></robot>'
    yield urdf(
        "wheels of meshes without masses", meshed.replace("</robot>", inertia), DRIVEN.format("left_joint"), drums
    )
    parts = {path.name: path.read_bytes() for path in PARTS.glob("*.obj")}
    yield urdf("crane", (PARTS / "crane.urdf").read_text("utf-8"), DRIVEN.format("boom_joint"), parts)
    yield urdf("rover", (PARTS / "rover.urdf").read_text("utf-8"), DRIVEN.format("left_wheel_joint"))
    keys = "xacro_arguments: {radius: 0.12, camera: true}\n"
    expanded = {"bot.xacro": XACRO, "wheel.xacro": WHEEL, "size.yaml": "track: 0.5\n"}
    yield "xacro", {**expanded, "bot.yaml": f"robot: bot\nurdf: bot.xacro\n{keys}"}


def of_mjcf() -> Iterator[tuple[str, Files]]:
    """Yield MJCF models by name, each with a robot file."""
    robots = {
        "differential": (mjcf_models.DIFFERENTIAL, "joints: {left_joint: {armature: 0.01}}\n"),
        "arm": (mjcf_models.ARM, "base_link: base\nfixed_base: true\n" + DRIVEN.format("elbow")),
        "quadruped": (mjcf_models.QUADRUPED, "base_link: trunk\nstart: home\nlinks: {trunk: {gravity: false}}\n"),
        "one of each thing": (
            mjcf_models.KITCHEN_SINK,
            "base_link: trunk\nfixed_base: true\n" + DRIVEN.format("elbow"),
        ),
        "arm on a plate": (
            (PARTS / "arm_on_a_plate.xml").read_text("utf-8"),
            "base_link: plate\n" + DRIVEN.format("shoulder"),
        ),
        "meshes and an include": (_MESHED, "base_link: trunk\n" + DRIVEN.format("hinge")),
    }
    solid = mesh_texts.solid(1.2)
    more: Files = {
        "part.xml": _PART,
        "meshes/part.stl": mesh_texts.binary_stl(solid),
        "meshes/part.obj": mesh_texts.obj(solid),
    }
    for name, (text, keys) in robots.items():
        own: Files = {"bot.xml": text, "bot.yaml": f"robot: bot\nmjcf: bot.xml\n{keys}"}
        yield f"mjcf {name}", {**own, **more} if text == _MESHED else own


_MESHED = """<mujoco>
  <compiler angle="degree" meshdir="meshes" balanceinertia="true" eulerseq="zyx"/>
  <asset><mesh file="part.stl" scale="0.5 -0.5 0.5"/><mesh name="shell" file="part.obj" inertia="shell"/></asset>
  <worldbody>
    <body name="trunk" pos="0 0 .3" euler="10 20 30">
      <freejoint/><geom type="mesh" mesh="part" mass="2"/>
      <body name="arm" pos=".1 0 .2" axisangle="1 1 0 40">
        <joint name="hinge" axis="1 2 3" range="-40 50" damping=".2"/><geom type="mesh" mesh="shell" euler="0 0 30"/>
        <include file="part.xml"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
_PART = """<mujocoinclude><body name="hand" xyaxes="0 1 0 -1 0 0"><joint name="slide" type="slide" axis="0 0 -1" range="0 .1"/>
  <inertial pos="0 0 .05" mass=".3" fullinertia=".002 .001 .0015 .0001 .0002 -.0001" /><geom size=".02" contype="0"/></body>
</mujocoinclude>
"""


def of_sdf() -> Iterator[tuple[str, Files]]:
    """Yield SDF models by name, each with a robot file."""
    for name in ("differential", "skid", "mecanum"):
        keys = BASES[name].files(WHEELS[name])["bot.yaml"]
        yield f"sdf {name}", {"bot.sdf": sdf(BASES[name]), "bot.yaml": keys.replace("bot.urdf", "bot.sdf")}
    solid = mesh_texts.solid(0.8)
    meshes: Files = {"meshes/part.stl": mesh_texts.binary_stl(solid), "wheel/model.sdf": document(model(_PEG, "peg"))}
    chain = "robot: bot\nurdf: bot.sdf\nbase_link: base\n" + DRIVEN.format("lift")
    yield "sdf chain", {"bot.sdf": document(model(_CHAIN, "chain")), "bot.yaml": chain, **meshes}
    static = document(model(f"<static>true</static>{_CHAIN}", "chain"))
    yield "sdf static chain", {"bot.sdf": static, "bot.yaml": chain + "fixed_base: true\n", **meshes}


_TURNED = "<inertia><ixx>.02</ixx><iyy>.03</iyy><izz>.025</izz><ixy>.001</ixy><ixz>-.002</ixz><iyz>.003</iyz></inertia>"
_MESH = "<geometry><mesh><uri>meshes/part.stl</uri><scale>.5 -.5 .5</scale></mesh></geometry>"
_BOX = "<geometry><box><size>.1 .2 .3</size></box></geometry>"
_RED = "<material><ambient>1 0 0 1</ambient><diffuse>.8 .1 .1 1</diffuse></material>"
_PEG = link("peg", pose(0.01, 0.02, 0.03, 0.1, 0.2, 0.3) + f'<collision name="c">{BALL}</collision>')
_CHAIN = (
    link("base", pose(0.1, 0, 0.2) + f'<collision name="c">{pose(0, 0, 0.1, 0.3)}{_BOX}</collision>', 5.0)
    + f'<link name="arm">{pose(0.3, -0.1, 0.4, 0.5, -0.6, 0.7)}<inertial>{pose(0.01, 0.02, 0.03, 0.2, 0.1, -0.3)}'
    + f'<mass>1.5</mass>{_TURNED}</inertial><collision name="c">{_MESH}</collision>'
    + f'<visual name="v">{pose(0, 0, 0.1, 0, 1.2, 0, relative_to="base")}{_MESH}{_RED}</visual></link>'
    + link("hand", pose(0, 0, 0.3, 0, 0, 1, relative_to="arm") + f'<visual name="v">{_BOX}</visual>', 0.4)
    + joint(
        "lift",
        "base",
        "arm",
        _axis := "<axis><xyz>.3 -.5 .8</xyz><limit><lower>-1</lower><upper>1.5</upper>"
        "<effort>20</effort><velocity>2</velocity></limit><dynamics><damping>.3</damping><friction>.1</friction></dynamics></axis>",
        "revolute",
    )
    + joint("slide", "arm", "hand", pose(0.01, 0, 0, 0, 0.3) + _axis.replace(".3 -.5 .8", "0 0 -1"), "prismatic")
    + '<frame name="side" attached_to="hand">'
    + pose(0.1, 0.1, 0, 0, 0, 0.5)
    + "</frame>"
    + "<include><uri>wheel</uri><name>left</name>"
    + pose(0.2, 0.1, 0, 0.1, 0, 0, relative_to="side")
    + "</include>"
    + joint("peg_joint", "hand", "left::peg")
)

SHIPPED = (
    *("dd100_flat", "dd100_fleet", "dd100_hall", "dd100_hall_pair", "dd100_warehouse", "demo"),
    *("tutorial/flat_grid", "tutorial/navigation", "tutorial/simple_warehouse"),
)
"""Scenes that ship."""

_SHAPES = (
    "<box><size>2 1 .5</size></box>",
    "<sphere><radius>.3</radius></sphere>",
    "<cylinder><radius>.3</radius><length>2</length></cylinder>",
    "<capsule><radius>.3</radius><length>2</length></capsule>",
    "<ellipsoid><radii>.1 .2 .3</radii></ellipsoid>",
    "<mesh><uri>meshes/part.stl</uri></mesh>",
)
WORLD_SDF = document(
    '<world name="w"><include><uri>model://ground_plane</uri></include>'
    + "".join(
        model(
            ("<static>true</static>" if number % 2 else "")
            + pose(2 * number, 1, 1, 0.1 * number, 0.2, 0.3)
            + f'<link name="l"><inertial><mass>2</mass>{INERTIA if number % 3 else _TURNED}</inertial>'
            + f'<collision name="c">{pose(0, 0, 0.1, 0, 0.1)}<geometry>{shape}</geometry></collision>'
            + f'<visual name="v"><geometry>{shape}</geometry>{_RED}</visual></link>',
            f"thing_{number}",
        )
        for number, shape in enumerate(_SHAPES)
    )
    + "</world>"
)
"""A world with static and loose things of all shapes."""
WORLD_FILES = {"meshes/part.stl": mesh_texts.binary_stl(mesh_texts.solid(1.0))}
FLEET = f"""scene: fleet
world: world.xml
robots:
  fleet: {{use: bot.yaml, count: 3, spacing: [1.0, 1.5], position: [0, 0, 0.3], orientation: {{rpy_deg: [0, 0, 30]}}}}
  arm: {{use: arm.yaml, position: [0, 5, 0], at: /World/arm}}
  model: {{use: model.xml, position: [5, 0, 0]}}
  text: {{use: '{CART.replace(chr(10), " ")}', position: [-3, 0, 0.2]}}
"""
FLEET_FILES: Files = {
    **SKID.files(SKID_WHEELS),
    "arm.yaml": arm_robot.robot_file(),
    "arm.urdf": arm_robot.urdf(shapes=True),
    "model.xml": mjcf_models.QUADRUPED,
}
