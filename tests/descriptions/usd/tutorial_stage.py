"""The stages that the tutorial "ROS 2 Putting It All Together" saves, made with usd-core step by step as its text says.

- `dd100.usda`: the URDF with all joints disabled but three, dampings of 10000, two physics materials.
- `dd100_with_sensors.usda`: with a RealSense D455, a microScan3, three ActionGraphs and the namespaces.
- `dd100_warehouse_navigation.usda`: the robot in a hall, with the clock graph.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from graphengine.devices.rotation import from_rpy
from tests.descriptions.usd.stages import StageWriter

ROOT = Path(__file__).resolve().parents[3]
URDF = ROOT / "scenes/robots/dd100/dd100.urdf"
GRAPHS = ROOT / "tests/isaac/stage/tutorial.usda"
"""The tutorial's four graphs as OmniGraph prims."""
KEPT = ("front_left_wheel_joint", "front_right_wheel_joint", "rear_caster_joint")
CHASSIS = "Geometry/base_link/chassis_link"
PLACE = (-3.0, 6.0, 0.025)
BOXES = {"shelf_1": (0.0, 8.0), "shelf_2": (-6.0, 8.0), "pillar": (-3.0, 12.0)}
"""Static boxes of 1 m x 2 m x 2 m of the hall, by name: x and y of their middle, m."""


def numbers(element: ElementTree.Element | None, name: str, default: str = "0 0 0") -> tuple[float, ...]:
    return tuple(map(float, (element.get(name, default) if element is not None else default).split()))


def place(writer: StageWriter, prim: Usd.Prim, origin: ElementTree.Element | None) -> None:
    x, y, z, w = from_rpy(*numbers(origin, "rpy"))
    writer.place(prim, numbers(origin, "xyz"), Gf.Quatd(w, x, y, z))  # type: ignore[arg-type]


def inertia(prim: Usd.Prim, inertial: ElementTree.Element) -> None:
    mass, moments = inertial.find("mass"), inertial.find("inertia")
    assert mass is not None
    assert moments is not None
    made = UsdPhysics.MassAPI.Apply(prim)
    made.CreateMassAttr(float(mass.get("value", "0")))
    made.CreateDiagonalInertiaAttr(Gf.Vec3f(*(float(moments.get(name, "0")) for name in ("ixx", "iyy", "izz"))))
    made.CreatePrincipalAxesAttr(Gf.Quatf(1.0))
    made.CreateCenterOfMassAttr(Gf.Vec3f(0.0))


def shapes(writer: StageWriter, path: str, link: ElementTree.Element) -> None:
    for number, part in enumerate(each for each in link if each.tag in ("collision", "visual")):
        geometry = part.find("geometry")
        assert geometry is not None
        form = geometry[0]
        below = f"{path}/{part.tag}_{number}"
        if form.tag == "box":
            prim = UsdGeom.Cube.Define(writer.stage, below).GetPrim()
            UsdGeom.Cube(prim).CreateSizeAttr(1.0)
        elif form.tag == "cylinder":
            prim = UsdGeom.Cylinder.Define(writer.stage, below).GetPrim()
            UsdGeom.Cylinder(prim).CreateHeightAttr(float(form.get("length", "0")))
        else:
            prim = UsdGeom.Sphere.Define(writer.stage, below).GetPrim()
        if form.tag != "box":
            prim.GetAttribute("radius").Set(float(form.get("radius", "0")))
        place(writer, prim, part.find("origin"))
        if form.tag == "box":
            UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(*numbers(form, "size")))
        if part.tag == "collision":
            UsdPhysics.CollisionAPI.Apply(prim)
            UsdGeom.Imageable(prim).CreatePurposeAttr("guide")


def robot(path: Path, damping: float = 10000.0) -> Path:
    """`dd100.usd` after the steps "Import" and "Adjust Model Physics"."""
    document = ElementTree.parse(URDF).getroot()
    joints = {joint.find("child").get("link"): joint for joint in document.iter("joint")}  # type: ignore[union-attr]
    links = {link.get("name"): link for link in document.iter("link")}
    writer = StageWriter(path)
    writer.robot("/dd100")
    paths = {"base_link": "/dd100/Geometry/base_link"}
    while len(paths) < len(links):
        for name, joint in joints.items():
            above = joint.find("parent").get("link")  # type: ignore[union-attr]
            if above in paths and name not in paths:
                paths[str(name)] = f"{paths[above]}/{name}"
    for name, below in paths.items():
        prim = UsdGeom.Xform.Define(writer.stage, below).GetPrim()
        place(writer, prim, joints[name].find("origin") if name in joints else None)
        UsdPhysics.RigidBodyAPI.Apply(prim)
        if (inertial := links[name].find("inertial")) is not None:
            inertia(prim, inertial)
        shapes(writer, below, links[name])
    for name, joint in joints.items():
        _joint(writer, joint, paths[joint.find("parent").get("link")], paths[str(name)], damping)  # type: ignore[union-attr,index]
    for material, friction, bodies in (
        ("CasterMaterial", 0.0, ("rear_caster",)),
        ("WheelMaterial", 1.0, ("front_left_wheel_link", "front_right_wheel_link")),
    ):
        _material(writer, f"/dd100/Materials/{material}", friction, [paths[body] for body in bodies])
    UsdGeom.Xform.Define(writer.stage, f"/dd100/{CHASSIS}/base_link")
    writer.save()
    return path


def _joint(writer: StageWriter, joint: ElementTree.Element, parent: str, child: str, damping: float) -> None:
    name, turns = str(joint.get("name")), joint.get("type") == "continuous"
    made = writer.joint("Revolute" if turns else "Fixed", f"/dd100/Physics/{name}", (parent, child), "Y")
    origin = joint.find("origin")
    x, y, z, w = from_rpy(*numbers(origin, "rpy"))
    made.GetAttribute("physics:localPos0").Set(Gf.Vec3f(*numbers(origin, "xyz")))
    made.GetAttribute("physics:localRot0").Set(Gf.Quatf(w, x, y, z))
    UsdPhysics.Joint(made).CreateJointEnabledAttr(name in KEPT)
    if turns:
        writer.drive(made, stiffness=0.0, damping=damping)


def _material(writer: StageWriter, path: str, friction: float, bodies: list[str]) -> None:
    material = UsdShade.Material.Define(writer.stage, path)
    made = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    made.CreateStaticFrictionAttr(friction)
    made.CreateDynamicFrictionAttr(friction)
    for body in bodies:
        binding = UsdShade.MaterialBindingAPI.Apply(writer.stage.GetPrimAtPath(body))
        binding.Bind(material, materialPurpose="physics")


def with_sensors(path: Path, *, namespaces: bool = True) -> Path:
    """`dd100_with_sensors.usd` after the steps "Adding Sensors", "Building OmniGraph Nodes" and "Add Automatic Namespace"."""
    robot(path)
    stage = Usd.Stage.Open(str(path))
    chassis = f"/dd100/{CHASSIS}"
    for name, position in (("sim_camera", (0.3, 0.0, 0.05)), ("sim_lidar", (0.0, 0.0, 0.15))):
        mount = UsdGeom.Xform.Define(stage, f"{chassis}/{name}")
        mount.AddTranslateOp().Set(Gf.Vec3d(*position))
    housing = UsdGeom.Xform.Define(stage, f"{chassis}/sim_camera/RSD455").GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(housing).CreateRigidBodyEnabledAttr(False)
    for camera in ("Camera_OmniVision_OV9782_Color", "Camera_Pseudo_Depth"):
        UsdGeom.Camera.Define(stage, f"{chassis}/sim_camera/RSD455/{camera}")
    lidar = stage.DefinePrim(f"{chassis}/sim_lidar/Lidar", "OmniLidar")
    lidar.CreateAttribute("omni:sensor:modelName", Sdf.ValueTypeNames.String).Set("microScan3")
    if namespaces:
        for below, text in ((f"{chassis}/sim_lidar", "sim_lidar"), (f"{chassis}/sim_camera", "sim_camera")):
            _namespace(stage, below, text)
        _namespace(stage, "/dd100/Geometry/base_link", "dd100_0000")
    graphs = Sdf.Layer.FindOrOpen(str(GRAPHS))
    layer = stage.GetRootLayer()
    for below in (f"{CHASSIS}/joint_states", f"{CHASSIS}/cmd_vel", f"{CHASSIS}/sim_lidar/scan"):
        Sdf.CopySpec(graphs, f"/dd100/{below}", layer, f"/dd100/{below}")
    layer.Save()
    return path


def _namespace(stage: Usd.Stage, path: str, text: str) -> None:
    stage.GetPrimAtPath(path).CreateAttribute("isaac:namespace", Sdf.ValueTypeNames.String).Set(text)


def hall(folder: Path, *, namespaces: bool = True, at: tuple[float, float, float] = PLACE) -> Path:
    """`dd100_warehouse_navigation.usda` after the step "Simulation Scene", beside the stage of the robot."""
    with_sensors(folder / "dd100_with_sensors.usda", namespaces=namespaces)
    path = folder / "dd100_warehouse_navigation.usda"
    writer = StageWriter(path)
    world = UsdGeom.Xform.Define(writer.stage, "/World").GetPrim()
    writer.stage.SetDefaultPrim(world)
    UsdPhysics.Scene.Define(writer.stage, "/physicsScene")
    writer.shape("Plane", "/World/full_warehouse/GroundPlane")
    for name, (x, y) in BOXES.items():
        writer.shape("Cube", f"/World/full_warehouse/{name}", (x, y, 1.0), edges=(1.0, 2.0, 2.0))
    dingo = UsdGeom.Xform.Define(writer.stage, "/World/dd100_with_sensors").GetPrim()
    dingo.GetReferences().AddReference("dd100_with_sensors.usda")
    writer.place(dingo, at, Gf.Quatd(0.5**0.5, 0.0, 0.0, 0.5**0.5))
    Sdf.CopySpec(Sdf.Layer.FindOrOpen(str(GRAPHS)), "/World/clock", writer.stage.GetRootLayer(), "/World/clock")
    writer.save()
    return path
