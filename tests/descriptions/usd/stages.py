"""Small robots as USD stages, written with usd-core as Isaac Sim's users and importers write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

Vector = tuple[float, float, float]


class StageWriter:
    """Writes a stage; lengths are given in metres and masses in kilograms, and converted to the units of the stage.

    Args:
        path: file to write.
        metres: length of the stage's unit, m.
        kilograms: mass of the stage's unit, kg.
        up: up axis.
    """

    def __init__(self, path: Path, metres: float = 1.0, kilograms: float = 1.0, up: str = "Z") -> None:
        self.stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.SetStageMetersPerUnit(self.stage, metres)
        UsdPhysics.SetStageKilogramsPerUnit(self.stage, kilograms)
        UsdGeom.SetStageUpAxis(self.stage, up)
        self.metres, self.kilograms, self.up = metres, kilograms, up

    def save(self) -> None:
        self.stage.GetRootLayer().Save()

    def place(
        self, prim: Usd.Prim, position: Vector, rotation: Gf.Quatd | None = None, scale: Vector | None = None
    ) -> None:
        form = UsdGeom.Xformable(prim)
        form.AddTranslateOp().Set(Gf.Vec3d(*self.length(position)))
        if rotation is not None:
            form.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(rotation)
        if scale is not None:
            form.AddScaleOp().Set(Gf.Vec3f(*scale))

    def length(self, values: Vector) -> Vector:
        """Lengths along the axes of a stage with z up, in the units and axes of this one."""
        x, y, z = (value / self.metres for value in values)
        return (x, z, -y) if self.up == "Y" else (x, y, z)

    def robot(self, path: str = "/Robot") -> Usd.Prim:
        prim = UsdGeom.Xform.Define(self.stage, path).GetPrim()
        UsdPhysics.ArticulationRootAPI.Apply(prim)
        self.stage.SetDefaultPrim(prim)
        return prim

    def body(self, path: str, position: Vector = (0.0, 0.0, 0.0), mass: float = 0.0) -> Usd.Prim:
        prim = UsdGeom.Xform.Define(self.stage, path).GetPrim()
        self.place(prim, position)
        UsdPhysics.RigidBodyAPI.Apply(prim)
        if mass:
            UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass / self.kilograms)
        return prim

    def shape(self, kind: str, path: str, position: Vector = (0.0, 0.0, 0.0), **sizes: Any) -> Usd.Prim:
        """Add a collider: `Cube` with `edges`, `Sphere` with `radius`, `Cylinder` with `radius`, `height` and `axis`."""
        edges = sizes.pop("edges", None)
        prim = getattr(UsdGeom, kind).Define(self.stage, path).GetPrim()
        x, y, z = edges or (0, 0, 0)
        scale = ((x, z, y) if self.up == "Y" else (x, y, z)) if edges else None
        self.place(prim, position, scale=tuple(edge / self.metres for edge in scale) if scale else None)  # type: ignore[arg-type]
        if kind == "Cube":
            UsdGeom.Cube(prim).CreateSizeAttr(1.0)
        for name, value in sizes.items():
            if name == "axis" and self.up == "Y":
                value = {"Y": "Z", "Z": "Y"}.get(value, value)
            prim.GetAttribute(name).Set(value if isinstance(value, str) else value / self.metres)
        UsdPhysics.CollisionAPI.Apply(prim)
        return prim

    def joint(
        self,
        kind: str,
        path: str,
        bodies: Sequence[str],
        axis: str = "X",
        at: Vector = (0.0, 0.0, 0.0),
        **limits: float,
    ) -> Usd.Prim:
        """Add a joint at a position in the frame of its first body; at the origin of the second one."""
        prim = getattr(UsdPhysics, f"{kind}Joint").Define(self.stage, path).GetPrim()
        joint = UsdPhysics.Joint(prim)
        if bodies[0]:
            joint.CreateBody0Rel().SetTargets([Sdf.Path(bodies[0])])
        joint.CreateBody1Rel().SetTargets([Sdf.Path(bodies[1])])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*self.length(at)))
        joint.CreateLocalPos1Attr(Gf.Vec3f(0.0))
        for side in ("0", "1"):
            prim.GetAttribute(f"physics:localRot{side}").Set(Gf.Quatf(1.0))
        if kind != "Fixed":
            if self.up == "Y":
                axis = {"Y": "Z", "Z": "Y"}.get(axis, axis)
            prim.GetAttribute("physics:axis").Set(axis)
        for name, value in limits.items():
            prim.GetAttribute(f"physics:{name}Limit").Set(value)
        return prim

    def drive(self, joint: Usd.Prim, name: str = "angular", **values: float) -> None:
        """Add a DriveAPI with values such as `stiffness`, in the units of the stage."""
        drive = UsdPhysics.DriveAPI.Apply(joint, name)
        for key, value in values.items():
            getattr(drive, f"Create{key[0].upper()}{key[1:]}Attr")(value)

    def graph(self, path: str, target: str, joints: Sequence[str], *kinds: str) -> None:
        """Add a graph with an ArticulationController that gets commands of some kinds from another node."""
        self.stage.DefinePrim(path, "OmniGraph").CreateAttribute("evaluator:type", Sdf.ValueTypeNames.Token).Set(
            "execution"
        )
        source = self._node(f"{path}/Source", "isaacsim.robot.wheeled_robots.DifferentialController")
        node = self._node(f"{path}/Controller", "isaacsim.core.nodes.IsaacArticulationController")
        node.CreateRelationship("inputs:targetPrim").SetTargets([Sdf.Path(target)])
        node.CreateAttribute("inputs:jointNames", Sdf.ValueTypeNames.TokenArray).Set(list(joints))
        for kind in kinds:
            given = source.CreateAttribute(f"outputs:{kind}Command", Sdf.ValueTypeNames.DoubleArray)
            taken = node.CreateAttribute(f"inputs:{kind}Command", Sdf.ValueTypeNames.DoubleArray)
            taken.SetConnections([given.GetPath()])

    def _node(self, path: str, kind: str) -> Usd.Prim:
        prim = self.stage.DefinePrim(path, "OmniGraphNode")
        prim.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set(kind)
        return prim


WHEELS = {"fl": (0.2, 0.18), "fr": (0.2, -0.18), "rl": (-0.2, 0.18), "rr": (-0.2, -0.18)}


def rover(path: Path, *, commanded: bool = True, stiffness: float = 0.0, **units: Any) -> Path:
    """A robot of 12 kg with four wheels of radius 0.08 m, whose joints have drives as its importer wrote them."""
    writer = StageWriter(path, **units)
    writer.robot("/Rover")
    writer.body("/Rover/chassis", (0.0, 0.0, 0.1), mass=10.0)
    writer.shape("Cube", "/Rover/chassis/box", edges=(0.5, 0.26, 0.08))
    for name, (x, y) in WHEELS.items():
        writer.body(f"/Rover/{name}_wheel", (x, y, 0.08), mass=0.5)
        writer.shape("Cylinder", f"/Rover/{name}_wheel/tyre", radius=0.08, height=0.04, axis="Y")
        bodies = ("/Rover/chassis", f"/Rover/{name}_wheel")
        joint = writer.joint("Revolute", f"/Rover/joints/{name}_joint", bodies, "Y", (x, y, -0.02))
        writer.drive(joint, stiffness=stiffness, damping=100.0 if stiffness else 0.0)
    if commanded:
        writer.graph("/Rover/drive", "/Rover", [f"{name}_joint" for name in WHEELS], "velocity")
    writer.save()
    return path


def arm(path: Path, *, gains: tuple[float, float] = (400.0, 40.0), **units: Any) -> Path:
    """An arm of two links of 1 kg on the world, which its position drives hold level; gains are in N m/rad and N m s/rad."""
    writer = StageWriter(path, **units)
    writer.robot("/Arm")
    writer.body("/Arm/base", mass=5.0)
    writer.shape("Cube", "/Arm/base/box", (0.0, 0.0, 0.05), edges=(0.2, 0.2, 0.1))
    writer.joint("Fixed", "/Arm/base/hold", ("", "/Arm/base"))
    place, before = 0.0, "base"
    for number, name in enumerate(("upper", "lower")):
        writer.body(f"/Arm/{name}", (place, 0.0, 0.2), mass=1.0)
        writer.shape("Cube", f"/Arm/{name}/box", (0.15, 0.0, 0.0), edges=(0.3, 0.04, 0.04))
        at = (0.3, 0.0, 0.0) if number else (0.0, 0.0, 0.2)
        joint = writer.joint(
            "Revolute", f"/Arm/{name}_joint", (f"/Arm/{before}", f"/Arm/{name}"), "Y", at, lower=-90.0, upper=90.0
        )
        unit = writer.kilograms * writer.metres**2 * 57.29577951308232
        writer.drive(
            joint, stiffness=gains[0] / unit, damping=gains[1] / unit, maxForce=87.0 * 57.29577951308232 / unit
        )
        place, before = place + 0.3, name
    writer.save()
    return path


WORKSHOP = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)
class "Prototype" {
    def Sphere "ball" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double radius = 0.02 }
}
def Xform "World" {
    def Material "Rubber" (prepend apiSchemas = ["PhysicsMaterialAPI", "PhysxMaterialAPI"]) {
        float physics:staticFriction = 0.9
        float physics:dynamicFriction = 0.8
        uniform token physxMaterial:frictionCombineMode = "multiply"
    }
    def Material "Red" {
        token outputs:surface.connect = </World/Red/Shader.outputs:surface>
        def Shader "Shader" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (1, 0, 0)
            float inputs:opacity = 0.5
            token outputs:surface
        }
    }
    def Material "Painted" {
        token outputs:surface.connect = </World/Painted/Shader.outputs:surface>
        def Shader "Shader" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </World/Painted/Picture.outputs:rgb>
            token outputs:surface
        }
        def Shader "Picture" {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @wood.png@
            float3 outputs:rgb
        }
    }
    def Xform "Cart" (prepend apiSchemas = ["PhysicsArticulationRootAPI"]) {
        string isaac:namespace = "cart_1"
        def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
            float physics:mass = 8
            string isaac:nameOverride = "base_link"
            def Mesh "hull" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"]) {
                uniform token physics:approximation = "boundingCube"
                point3f[] points = [(0, 0, 0), (0.4, 0, 0), (0, 0.2, 0), (0, 0, 0.1)]
                int[] faceVertexCounts = [3, 3, 3, 3]
                int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
                color3f[] primvars:displayColor = [(0, 1, 0)]
                double3 xformOp:translate = (0.1, 0, 0)
                float3 xformOp:scale = (-1, 1, 1)
                uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
                def GeomSubset "half" (prepend apiSchemas = ["MaterialBindingAPI"]) {
                    uniform token elementType = "face"
                    int[] indices = [0, 1]
                    rel material:binding = </World/Red>
                }
            }
            def Camera "eye" {
                float focalLength = 10
                float horizontalAperture = 20
                float verticalAperture = 10
                double3 xformOp:translate = (0.2, 0, 0.1)
                uniform token[] xformOpOrder = ["xformOp:translate"]
            }
            def OmniLidar "scanner" { string sensorModelConfig = "SICK_microScan3_ABAZ90ZA1P01" }
            def IsaacImuSensor "imu" { }
            def Xform "sim_lidar" {
                double3 xformOp:translate = (0, 0, 0.15)
                uniform token[] xformOpOrder = ["xformOp:translate"]
                def OmniLidar "Lidar" { string omni:sensor:modelName = "microScan3" }
            }
            def Xform "sim_camera" {
                double3 xformOp:translate = (0.3, 0, 0.05)
                uniform token[] xformOpOrder = ["xformOp:translate"]
                def Xform "RSD455" {
                    def Camera "Camera_OmniVision_OV9782_Color" { }
                    def Camera "Camera_Pseudo_Depth" { }
                    def IsaacImuSensor "Imu_Sensor" { }
                }
            }
            def IsaacContactSensor "bumper" { }
            def OmniLidar "unheard" { string sensorModelConfig = "Nobody_X1" }
        }
        def Xform "foot" (
            prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysxRigidBodyAPI", "PhysicsMassAPI", "MaterialBindingAPI"]
            instanceable = true
            inherits = </Prototype>
        ) {
            bool physxRigidBody:disableGravity = 1
            float physics:mass = 0.5
            rel material:binding:physics = </World/Rubber>
        }
        def Xform "finger" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
            float physics:mass = 0.25
            double3 xformOp:translate = (0, 0.2, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"]
            def Cone "tip" (prepend apiSchemas = ["PhysicsCollisionAPI"]) {
                double height = 0.1
                double radius = 0.02
                uniform token axis = "X"
            }
        }
        def Xform "thumb" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
            float physics:mass = 0.25
            def Sphere "nail" (prepend apiSchemas = ["MaterialBindingAPI"]) {
                double radius = 0.01
                rel material:binding = </World/Painted>
            }
        }
        def Xform "stub" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) { }
        def Xform "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) { float physics:mass = 0.1 }
        def PhysicsJoint "rail" (prepend apiSchemas = [
            "PhysicsLimitAPI:transY", "PhysicsLimitAPI:transZ", "PhysicsLimitAPI:rotX", "PhysicsLimitAPI:rotY",
            "PhysicsLimitAPI:rotZ", "PhysicsLimitAPI:transX", "PhysicsDriveAPI:transX"]) {
            rel physics:body0 = </World/Cart/base>
            rel physics:body1 = </World/Cart/foot>
            float limit:transX:physics:low = -0.1
            float limit:transX:physics:high = 0.3
            float drive:transX:physics:stiffness = 500
            float drive:transX:physics:targetPosition = 0.2
            float limit:transY:physics:low = 1
            float limit:transY:physics:high = -1
            float limit:transZ:physics:low = 1
            float limit:transZ:physics:high = -1
            float limit:rotX:physics:low = 1
            float limit:rotX:physics:high = -1
            float limit:rotY:physics:low = 1
            float limit:rotY:physics:high = -1
            float limit:rotZ:physics:low = 1
            float limit:rotZ:physics:high = -1
        }
        def PhysicsRevoluteJoint "grip" (prepend apiSchemas = ["PhysxJointAPI", "PhysicsDriveAPI:angular"]) {
            rel physics:body0 = </World/Cart/finger>
            rel physics:body1 = </World/Cart/base>
            uniform token physics:axis = "Z"
            float physics:lowerLimit = -45
            float physics:upperLimit = 90
            point3f physics:localPos0 = (0, -0.05, 0)
            point3f physics:localPos1 = (0, 0.15, 0)
            float physxJoint:armature = 0.02
            float physxJoint:maxJointVelocity = 180
            uniform token drive:angular:physics:type = "acceleration"
            float drive:angular:physics:stiffness = 100
        }
        def PhysicsRevoluteJoint "follow" (prepend apiSchemas = ["PhysxMimicJointAPI:rotZ"]) {
            rel physics:body0 = </World/Cart/base>
            rel physics:body1 = </World/Cart/thumb>
            uniform token physics:axis = "Z"
            float physics:lowerLimit = -90
            float physics:upperLimit = 90
            rel physxMimicJoint:rotZ:referenceJoint = </World/Cart/grip>
            float physxMimicJoint:rotZ:gearing = 0.5
            float physxMimicJoint:rotZ:offset = 10
        }
        def PhysicsFixedJoint "mark" {
            rel physics:body0 = </World/Cart/stub>
            rel physics:body1 = </World/Cart/base>
            bool physics:jointEnabled = 0
        }
        def PhysicsSphericalJoint "socket" {
            rel physics:body0 = </World/Cart/base>
            rel physics:body1 = </World/Cart/ball>
        }
        def PhysicsFixedJoint "loop" {
            rel physics:body0 = </World/Cart/thumb>
            rel physics:body1 = </World/Cart/ball>
            bool physics:excludeFromArticulation = 1
        }
        def OmniGraph "hold" {
            def OmniGraphNode "Controller" {
                token node:type = "omni.isaac.core_nodes.IsaacArticulationController"
                string inputs:robotPath = "/World/Cart"
                token[] inputs:jointNames = ["grip"]
                double[] inputs:effortCommand = [0.5]
            }
        }
    }
}
"""
"""A stage with one of most things that a stage may have."""


def workshop(path: Path) -> Path:
    path.write_text(WORKSHOP.replace(" }", "\n}").replace("}\n}", "}\n}\n"), encoding="utf-8")
    return path
