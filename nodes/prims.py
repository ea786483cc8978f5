"""Nodes that read and write attributes and poses of prims (`omni.graph.nodes`).

Prims have these attributes, with USD's names and units:

- prims with a pose: `xformOp:translate` (m) and `xformOp:orient`, both relative to the parent prim;
- bodies and links: `physics:mass` (kg);
- joints: `physics:jointEnabled`;
- prims with a namespace or a name override: `isaac:namespace`, `isaac:nameOverride`;
- cameras: `clippingRange`;
- surface grippers: `isaac:status`, which is `Open`, `Closing` or `Closed`;
- revolute joints, in degrees: `state:angular:physics:position` and `state:angular:physics:velocity`; if the drive has such a
  target, `drive:angular:physics:targetPosition` and `drive:angular:physics:targetVelocity`;
- prismatic joints, in m: the same attributes with `linear` instead of `angular`;
- /physicsScene: `physics:gravityDirection` and `physics:gravityMagnitude` (m/s2);
- materials of a robot: `physics:staticFriction` and `physics:dynamicFriction`;
- lights of the world: `inputs:intensity` (initially 1) and `inputs:color`.

Graphs can write poses of robots and free bodies, drive targets, gravity, friction and lights. MuJoCo has a single friction
coefficient; it gets the value of `physics:dynamicFriction`, and `physics:staticFriction` has no effect.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.devices.motion import Frame
from graphengine.devices.rotation import Pose, rotate
from graphengine.format.errors import BadValueError, ContextError, PhysicsError
from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, Out, PrimAttribute
from graphengine.node.types import Double3, PortType, Target, Token
from graphengine.node.usd_types import type_of_attribute
from graphengine.nodes.touched import ANY, WIRED, attribute_of, drives_of, reading_poses

_UNUSED = "no effect: attributes have neither time samples nor layers"
_USE_PATH = "true: `primPath` selects the prim; false: `prim` selects it"


class PrimNode(Node):
    """Base of nodes that need a prim, selected by the target `prim` or by the path in `primPath`."""

    prim: Target = In(default=(), setup=True, required="prim", doc="the prim; used if `usePath` is false")
    prim_path: Token = In(default="", setup=True, required="prim", doc="path of the prim; used if `usePath` is true")

    use_path: bool

    def given(self) -> str:
        """Return the path of the prim; an empty string if no input selects a prim, or a wire selects the prim during the run."""
        return self.prim_path if self.use_path else next(iter(self.prim), "")

    def path(self) -> str:
        """Return the path of the prim that the inputs select.

        Raises:
            ContextError: the input that selects the prim is empty.
        """
        path = self.given()
        if not path:
            name, other = ("primPath", "prim") if self.use_path else ("prim", "primPath")
            unused = self.prim if self.use_path else self.prim_path
            hint = f"{other} is set, but is used only if usePath is {str(not self.use_path).lower()}" if unused else ""
            raise ContextError(f"{name} is empty", "", hint)
        return path


class AttributeNode(PrimNode):
    """Base of nodes that read or write an attribute of a prim."""

    name: Token = In(default="", setup=True, required=True, doc="USD name of the attribute, for example `physics:mass`")
    use_path: bool = In(default=False, setup=True, doc=_USE_PATH)

    attribute: PrimAttribute = Bound()


class ReadPrimAttribute(AttributeNode, type="omni.graph.nodes.ReadPrimAttribute", volatile=True):
    """Reads an attribute of a prim."""

    usd_timecode: Any = In(type="timecode", unit="s", doc=_UNUSED)
    value: Any = Out(type="any", doc="value of the attribute; quaternions are (x, y, z, w)")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the attribute as the type of `value`. The name alone determines the type.

        Raises:
            ContextError: no prim has an attribute with this name.
        """
        return {"value": type_of_attribute(self.name)} if self.name else {}

    def setup(self, context: Context) -> None:
        """Look up the attribute and keep a handle to it.

        Raises:
            ContextError: the prim or the attribute does not exist.
        """
        self.attribute = context.attribute(self.path(), self.name)

    def compute(self) -> None:
        """Output the current value of the attribute."""
        self.value = self.attribute.read()

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the attribute; for a drive target, also the key of all drive targets of the robot."""
        path = self.given()
        if not path or not self.name:
            return ANY, WIRED
        told = (drives_of(path),) if self.name.startswith("drive:") else ()
        return (attribute_of(path, self.name), *told, WIRED)


class WritePrimAttribute(AttributeNode, type="omni.graph.nodes.WritePrimAttribute"):
    """Writes an attribute of a prim; nodes that read it later in the same pass get the new value."""

    exec_in = ExecIn()
    value: Any = In(required=True, doc="value to write; numeric attributes accept numbers of any type")
    usd_write_back: bool = In(default=True, doc=_UNUSED)
    layer_identifier: Token = In(default="", doc=_UNUSED)
    exec_out = ExecOut()

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Check that a value of the known type can be written to the attribute. Returns no types.

        Raises:
            ContextError: no prim has an attribute with this name.
            ValueError: one of the two types is numeric and the other is not, or they differ in the number of components.
        """
        given, wanted = known.get("value"), type_of_attribute(self.name) if self.name else None
        if given is not None and wanted is not None:
            as_long = given.array or given.count == wanted.count  # how long an array is shows when it is written
            if given.is_number != wanted.is_number or not as_long:
                raise ValueError(f"a value of type {given} cannot be written to {self.name} of type {wanted}")
        return {}

    def setup(self, context: Context) -> None:
        """Look up the attribute and keep a writable handle to it.

        Raises:
            ContextError: the prim or the attribute does not exist, or the attribute cannot change during a simulation.
        """
        self.attribute = context.attribute(self.path(), self.name, writable=True)

    def compute(self) -> None:
        """Write `value` to the attribute.

        Raises:
            BadValueError: the value cannot be converted to the attribute's type, is not finite, or is out of range.
        """
        try:
            self.attribute.write(self.value)
        except (ContextError, PhysicsError) as error:
            raise BadValueError("value", self.value) from error

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the attribute."""
        path = self.given()
        return (attribute_of(path, self.name) if path and self.name else WIRED, ANY)


class PosedNode(PrimNode, volatile=True):
    """Base of nodes that read the pose of a prim in the world frame."""

    use_path: bool = In(default=True, setup=True, doc=_USE_PATH)

    frame: Frame = Bound()

    def setup(self, context: Context) -> None:
        """Look up the prim and keep a handle to its pose.

        Raises:
            ContextError: no prim is selected, or the prim does not exist.
        """
        self.frame = context.frame(self.path())

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the prim's pose."""
        return reading_poses([self.given()] if self.given() else [])


class GetPrimLocalToWorldTransform(PosedNode, type="omni.graph.nodes.GetPrimLocalToWorldTransform"):
    """Reads the pose of a prim in the world frame as a matrix for row vectors, with the position (m) in its last row."""

    local_to_world_transform: Any = Out(
        type="matrixd[4]", doc="pose in the world frame: 4 x 4 matrix, row by row; the last row is the position, m"
    )

    def compute(self) -> None:
        """Output the current pose as a matrix."""
        self.local_to_world_transform = matrix_of(self.frame.pose())


class GetPrimDirectionVector(PosedNode, type="omni.graph.nodes.GetPrimDirectionVector"):
    """Outputs the axes of a prim as unit vectors in the world frame; x is right, y is up, -z is forward, as for USD cameras."""

    backward_vector: Double3 = Out(doc="direction of the prim's z axis in the world frame")
    down_vector: Double3 = Out(doc="direction of the prim's -y axis in the world frame")
    forward_vector: Double3 = Out(doc="direction of the prim's -z axis in the world frame")
    left_vector: Double3 = Out(doc="direction of the prim's -x axis in the world frame")
    right_vector: Double3 = Out(doc="direction of the prim's x axis in the world frame")
    up_vector: Double3 = Out(doc="direction of the prim's y axis in the world frame")

    def compute(self) -> None:
        """Rotate the axes of the prim into the world frame and output them."""
        _, orientation = self.frame.pose()
        self.right_vector, self.left_vector = (rotate(orientation, (sign, 0.0, 0.0)) for sign in (1.0, -1.0))
        self.up_vector, self.down_vector = (rotate(orientation, (0.0, sign, 0.0)) for sign in (1.0, -1.0))
        self.backward_vector, self.forward_vector = (rotate(orientation, (0.0, 0.0, sign)) for sign in (1.0, -1.0))


class ReadPrimLocalTransform(Node, type="omni.graph.nodes.ReadPrimLocalTransform", volatile=True):
    """Reads the pose of a prim relative to its parent prim, as a matrix for row vectors with the position (m) in its last row."""

    prim: Target = In(required=True, setup=True, doc="prim whose pose is read")
    value: Any = Out(
        type="matrixd[4]", doc="pose relative to the parent: 4 x 4 matrix, row by row; the last row is the position, m"
    )

    translate: PrimAttribute = Bound()
    orient: PrimAttribute = Bound()

    def setup(self, context: Context) -> None:
        """Look up the position and orientation attributes of the prim and keep handles to them.

        Raises:
            ContextError: the prim does not exist or has no pose.
        """
        self.translate = context.attribute(self.prim[0], "xformOp:translate")
        self.orient = context.attribute(self.prim[0], "xformOp:orient")

    def compute(self) -> None:
        """Output the current pose as a matrix."""
        self.value = matrix_of((self.translate.read(), self.orient.read()))

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the prim's pose."""
        return reading_poses(self.prim)


def matrix_of(pose: Pose) -> tuple[float, ...]:
    """Return the 16 numbers of a pose as a 4 x 4 matrix M, row by row: three rows hold the axes, the last one the position (m).

    A point with the row vector p = (x, y, z, 1) is transformed to p M.
    """
    position, orientation = pose
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    rows = [(*rotate(orientation, axis), 0.0) for axis in axes]
    return (*rows[0], *rows[1], *rows[2], *position, 1.0)
