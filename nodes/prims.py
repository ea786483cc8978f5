"""Attributes and poses of prims (`omni.graph.nodes`).

Prims have these attributes, with USD's names and units:

- any prim, as far as they apply: `xformOp:translate` (m) and `xformOp:orient` relative to the parent prim, `physics:mass` (kg),
  `physics:jointEnabled`, `isaac:namespace`, `isaac:nameOverride`;
- cameras: `clippingRange`;
- surface grippers: `isaac:status`, which is `Open`, `Closing` or `Closed`;
- revolute joints, in degrees: `state:angular:physics:position` and `:velocity`, and `drive:angular:physics:targetPosition` and
  `targetVelocity` if the drive has them;
- prismatic joints, in m: the same attributes with `linear` instead of `angular`;
- /physicsScene: `physics:gravityDirection` and `physics:gravityMagnitude` (m/s2);
- materials of a robot: `physics:staticFriction` and `physics:dynamicFriction`;
- lights of the world: `inputs:intensity`, 1 at the start, and `inputs:color`.

Graphs can write poses of robots and free bodies, drive targets, gravity, friction and lights. MuJoCo has a single friction
coefficient, which is the dynamic one; `physics:staticFriction` has no effect.
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
_USE_PATH = "true: `primPath` gives the prim; false: `prim` does"


class PrimNode(Node):
    """Base of nodes that need a prim, given as a target or by its path."""

    prim: Target = In(default=(), setup=True, required="prim", doc="the prim; used if `usePath` is false")
    prim_path: Token = In(default="", setup=True, required="prim", doc="path of the prim; used if `usePath` is true")

    use_path: bool

    def given(self) -> str:
        """Return the path of the prim, or an empty string if a wire will set it."""
        return self.prim_path if self.use_path else next(iter(self.prim), "")

    def path(self) -> str:
        """Return the path of the prim.

        Raises:
            ContextError: no prim is given.
        """
        path = self.given()
        if not path:
            name, other = ("primPath", "prim") if self.use_path else ("prim", "primPath")
            given = self.prim if self.use_path else self.prim_path
            hint = (
                f"{other} is set, which counts while usePath is {'false' if self.use_path else 'true'}" if given else ""
            )
            raise ContextError(f"{name} is empty", "", hint)
        return path


class AttributeNode(PrimNode):
    """Base of nodes that read or write an attribute of a prim."""

    name: Token = In(
        default="", setup=True, required=True, doc="USD name of the attribute, such as `xformOp:translate`"
    )
    use_path: bool = In(default=False, setup=True, doc=_USE_PATH)

    attribute: PrimAttribute = Bound()


class ReadPrimAttribute(AttributeNode, type="omni.graph.nodes.ReadPrimAttribute", volatile=True):
    """Reads an attribute of a prim."""

    usd_timecode: Any = In(type="timecode", unit="s", doc=_UNUSED)
    value: Any = Out(type="any", doc="value of the attribute; quaternions are (x, y, z, w)")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the attribute's type for `value`; it follows from the attribute's name.

        Raises:
            ContextError: no prim has an attribute of this name.
        """
        return {"value": type_of_attribute(self.name)} if self.name else {}

    def setup(self, context: Context) -> None:
        """Bind the attribute.

        Raises:
            ContextError: the prim or the attribute does not exist.
        """
        self.attribute = context.attribute(self.path(), self.name)

    def compute(self) -> None:
        """Read the value."""
        self.value = self.attribute.read()

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the attribute; for a drive target, also those of the robot's drive targets."""
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
        """Return no types; only check before the run that the value can be converted to the attribute's type.

        Raises:
            ContextError: no prim has an attribute of this name.
            ValueError: the types are incompatible, such as strings and numbers, or differ in the number of components.
        """
        given, wanted = known.get("value"), type_of_attribute(self.name) if self.name else None
        if given is not None and wanted is not None:
            as_long = given.array or given.count == wanted.count  # how long an array is shows when it is written
            if given.is_number != wanted.is_number or not as_long:
                raise ValueError(f"a value of type {given} cannot be written to {self.name} of type {wanted}")
        return {}

    def setup(self, context: Context) -> None:
        """Bind the attribute.

        Raises:
            ContextError: the prim or attribute does not exist, or it cannot change during a simulation.
        """
        self.attribute = context.attribute(self.path(), self.name, writable=True)

    def compute(self) -> None:
        """Write the value.

        Raises:
            BadValueError: the value has another type, is not finite, or is out of the attribute's range.
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
    """Base of nodes that read the world pose of a prim."""

    use_path: bool = In(default=True, setup=True, doc=_USE_PATH)

    frame: Frame = Bound()

    def setup(self, context: Context) -> None:
        """Bind the prim.

        Raises:
            ContextError: the prim does not exist.
        """
        self.frame = context.frame(self.path())

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the prim's pose."""
        return reading_poses([self.given()] if self.given() else [])


class GetPrimLocalToWorldTransform(PosedNode, type="omni.graph.nodes.GetPrimLocalToWorldTransform"):
    """Reads the world pose of a prim as a matrix for row vectors, with the position (m) in its last row."""

    local_to_world_transform: Any = Out(
        type="matrixd[4]", doc="4 x 4 matrix, row by row; the position (m) is the last row"
    )

    def compute(self) -> None:
        """Read the pose."""
        self.local_to_world_transform = matrix_of(self.frame.pose())


class GetPrimDirectionVector(PosedNode, type="omni.graph.nodes.GetPrimDirectionVector"):
    """Reads the axes of a prim as directions in the world frame: x is right, y up and -z forward, as for USD cameras."""

    backward_vector: Double3 = Out(doc="direction of the prim's z axis in the world frame")
    down_vector: Double3 = Out(doc="direction of the prim's -y axis in the world frame")
    forward_vector: Double3 = Out(doc="direction of the prim's -z axis in the world frame")
    left_vector: Double3 = Out(doc="direction of the prim's -x axis in the world frame")
    right_vector: Double3 = Out(doc="direction of the prim's x axis in the world frame")
    up_vector: Double3 = Out(doc="direction of the prim's y axis in the world frame")

    def compute(self) -> None:
        """Rotate the axes into the world frame."""
        _, orientation = self.frame.pose()
        self.right_vector, self.left_vector = (rotate(orientation, (sign, 0.0, 0.0)) for sign in (1.0, -1.0))
        self.up_vector, self.down_vector = (rotate(orientation, (0.0, sign, 0.0)) for sign in (1.0, -1.0))
        self.backward_vector, self.forward_vector = (rotate(orientation, (0.0, 0.0, sign)) for sign in (1.0, -1.0))


class ReadPrimLocalTransform(Node, type="omni.graph.nodes.ReadPrimLocalTransform", volatile=True):
    """Reads the pose of a prim relative to its parent as a matrix for row vectors, with the position (m) in its last row."""

    prim: Target = In(required=True, setup=True, doc="prim whose pose is read")
    value: Any = Out(type="matrixd[4]", doc="4 x 4 matrix, row by row; the position (m) is the last row")

    translate: PrimAttribute = Bound()
    orient: PrimAttribute = Bound()

    def setup(self, context: Context) -> None:
        """Bind the prim's pose.

        Raises:
            ContextError: the prim does not exist, or it has no pose.
        """
        self.translate = context.attribute(self.prim[0], "xformOp:translate")
        self.orient = context.attribute(self.prim[0], "xformOp:orient")

    def compute(self) -> None:
        """Read the pose."""
        self.value = matrix_of((self.translate.read(), self.orient.read()))

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the prim's pose."""
        return reading_poses(self.prim)


def matrix_of(pose: Pose) -> tuple[float, ...]:
    """Return a pose as a 4 x 4 matrix M, row by row: three rows with the axes, one with the position.

    M transforms the row vector of a point p = (x, y, z, 1) to p M.
    """
    position, orientation = pose
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    rows = [(*rotate(orientation, axis), 0.0) for axis in axes]
    return (*rows[0], *rows[1], *rows[2], *position, 1.0)
