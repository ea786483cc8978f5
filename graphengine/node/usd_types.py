"""The USD types of prims and attributes, and the OmniGraph types that correspond to attribute types."""

from __future__ import annotations

from graphengine.devices.stage import PHYSICS_SCENE, Prim, PrimKind
from graphengine.format.errors import ContextError
from graphengine.format.kinds import DEVICES
from graphengine.format.wording import did_you_mean, listing
from graphengine.node.types import PortType

_USD_TYPES: dict[PrimKind, str] = {"scope": "Scope", "material": "Material", "graph": "OmniGraph"}
_USD_TYPES |= dict.fromkeys(("robot", "link", "frame", "body", "sensor"), "Xform")
_JOINT_TYPES = dict.fromkeys(("revolute", "continuous"), "PhysicsRevoluteJoint")
_JOINT_TYPES |= {"prismatic": "PhysicsPrismaticJoint", "fixed": "PhysicsFixedJoint"}

PORT_TYPES = {
    "bool": PortType("bool"),
    "color3f": PortType("float", 3, role="color"),
    "double3": PortType("double", 3),
    "float": PortType("float"),
    "float2": PortType("float", 2),
    "quatd": PortType("double", 4, role="quat"),
    "string": PortType("string"),
    "token": PortType("token"),
    "vector3f": PortType("float", 3, role="vector"),
}
"""OmniGraph type of an attribute, by the USD type of the attribute."""

ATTRIBUTE_TYPES = {"xformOp:translate": "double3", "xformOp:orient": "quatd", "physics:mass": "float"}
ATTRIBUTE_TYPES |= {"clippingRange": "float2", "inputs:intensity": "float", "inputs:color": "color3f"}
ATTRIBUTE_TYPES |= {"physics:gravityDirection": "vector3f", "physics:gravityMagnitude": "float"}
ATTRIBUTE_TYPES |= {"physics:staticFriction": "float", "physics:dynamicFriction": "float"}
ATTRIBUTE_TYPES |= {"physics:jointEnabled": "bool", "isaac:namespace": "string", "isaac:nameOverride": "string"}
ATTRIBUTE_TYPES["isaac:status"] = "token"
for _motion in ("angular", "linear"):
    ATTRIBUTE_TYPES |= {f"state:{_motion}:physics:{what}": "float" for what in ("position", "velocity")}
    ATTRIBUTE_TYPES |= {f"drive:{_motion}:physics:{what}": "float" for what in ("targetPosition", "targetVelocity")}
"""USD type of each attribute, by attribute name; an attribute has the same type on every prim."""


def type_of_attribute(name: str) -> PortType:
    """Return the OmniGraph type of the attribute with this name.

    Raises:
        ContextError: no kind of prim has an attribute with this name.
    """
    if name not in ATTRIBUTE_TYPES:
        near = did_you_mean(name, ATTRIBUTE_TYPES) or listing(ATTRIBUTE_TYPES, "attributes")
        raise ContextError(f"no prim can have an attribute {name!r}", name, near)
    return PORT_TYPES[ATTRIBUTE_TYPES[name]]


def usd_type(prim: Prim) -> str:
    """Return the USD type name of a prim."""
    if is_physics_scene(prim):
        return "PhysicsScene"
    if prim.kind == "light":
        return "DistantLight" if prim.facts.get("directional") else "SphereLight"
    if prim.kind == "joint":
        return _JOINT_TYPES.get(prim.facts.get("type", ""), "PhysicsJoint")
    return _USD_TYPES.get(prim.kind) or str(DEVICES.all[prim.kind].usd)


def is_physics_scene(prim: Prim) -> bool:
    """Return whether the prim is the USD physics scene, `/physicsScene`."""
    return prim.path == PHYSICS_SCENE and prim.kind == "scope"
