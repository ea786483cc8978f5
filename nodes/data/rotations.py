"""Translation, rotation and scale in transformation matrices (`omni.graph.nodes`).

Matrices are for row vectors, so the translation is the fourth row. Angles are in degrees about the fixed axes x, y and z, applied
in the order of `rotationOrder`. Quaternions are (x, y, z, w).
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.node import In, Matrix4d, Node, Out, PortType, Token, Vector3d
from graphengine.nodes.checked import one_of
from graphengine.nodes.data.broadcast import Operation, lift
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.matrices import flat, square
from graphengine.nodes.data.orientation import ORDERS, angles_of, matrix_about, quaternions_of, rotation_matrix, unit
from graphengine.nodes.data.unions import QUATERNIONS, VECTORS, matrices, with_arrays

_MATRIX4 = matrices(4)
_VECTOR3 = with_arrays("vectord[3]")
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_ANGLES = "angles about x, y and z (deg)"
_ORDER = "order in which angles about the fixed axes x, y and z are applied"


class _FromMatrix(Elementwise):
    """Base of nodes that read a part of a transformation matrix or of a rotation."""

    part = PortType("double", 3, False, "vector")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the output type with the base type of the input, as an array if the input is an array."""
        (source,) = given.values()
        return replace(self.part, base=source.base, array=source.array)


class GetMatrix4Translation(_FromMatrix, type="omni.graph.nodes.GetMatrix4Translation"):
    """Translation of a transformation matrix."""

    matrix: Any = In(type=_MATRIX4, required=True, doc="matrix, or array of matrices")
    translation: Any = Out(type=_VECTOR3, unit="m")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the function that reads the translation of one matrix, or of each in an array."""
        if output.array:
            return lambda matrices: np.ascontiguousarray(matrices[:, 12:15])
        return operator.itemgetter(slice(12, 15))


class GetMatrix4Scale(_FromMatrix, type="omni.graph.nodes.GetMatrix4Scale"):
    """Scale of a transformation matrix along x, y and z."""

    matrix: Any = In(type=matrices(3, 4), required=True, doc="matrix, or array of matrices")
    scale: Any = Out(type=_VECTOR3, doc="scale factors along x, y and z")

    @staticmethod
    def operation(matrix: Any) -> Any:
        """Compute the scales of an array of matrices."""
        return np.linalg.norm(square(matrix)[..., :3, :3], axis=-1)


class GetMatrix4Quaternion(_FromMatrix, type="omni.graph.nodes.GetMatrix4Quaternion"):
    """Rotation of a transformation matrix, or of angles about x, y and z, as a quaternion."""

    part = PortType("double", 4, False, "quat")

    matrix: Any = In(type=f"{matrices(3, 4)}|{VECTORS}", required=True, doc=f"matrix, {_ANGLES}, or array of these")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    quaternion: Any = Out(type=QUATERNIONS, doc="unit quaternion (x, y, z, w) with w >= 0")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion, which uses the current `rotationOrder`."""
        return lift(lambda one: quaternions_of(rotation_matrix(one, self.rotation_order)), inputs, output)


class GetMatrix4Rotation(_FromMatrix, type="omni.graph.nodes.GetMatrix4Rotation"):
    """Rotation of a transformation matrix or of a quaternion, as angles about x, y and z."""

    matrix: Any = In(type=f"{matrices(3, 4)}|{QUATERNIONS}", required=True, doc="matrix, quaternion, or array of these")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation: Any = Out(type=VECTORS, unit="deg", doc="angles about x, y and z")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion, which uses the current `rotationOrder`."""
        return lift(lambda one: angles_of(rotation_matrix(one), self.rotation_order), inputs, output)


class GetMatrix4RotationMatrix(_FromMatrix, type="omni.graph.nodes.GetMatrix4RotationMatrix"):
    """Rotation of a transformation matrix, of angles or of a quaternion, as a 3 x 3 matrix."""

    part = PortType("double", 9, False, "matrixd")

    matrix: Any = In(
        type=f"{_MATRIX4}|{with_arrays('quatd[4]|vectord[3]')}", required=True, doc=f"matrix, {_ANGLES}, or quaternion"
    )
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation: Any = Out(type=matrices(3), doc="rotation matrix, without scale")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion, which uses the current `rotationOrder`."""
        return lift(lambda one: flat(rotation_matrix(one, self.rotation_order)), inputs, output)


class _OnMatrix(Elementwise):
    """Base of nodes that set a part of a transformation matrix."""

    like = "matrix"


def _with_rotation(matrix: Any, rotation: Any) -> Any:
    """4 x 4 matrices with a new rotation (..., 3, 3) and without scale."""
    changed = np.broadcast_to(
        square(matrix), np.broadcast_shapes(square(matrix).shape, (*rotation.shape[:-2], 4, 4))
    ).copy()
    changed[..., :3, :3] = rotation
    return flat(changed)


class SetMatrix4Translation(_OnMatrix, type="omni.graph.nodes.SetMatrix4Translation"):
    """A transformation matrix with its translation replaced."""

    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix, or array of matrices")
    translation: Any = In(type=_VECTOR3, required=True, unit="m")
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new translation as its fourth row")

    @staticmethod
    def operation(matrix: Any, translation: Any) -> Any:
        """Set the translation of an array of matrices."""
        shape = np.broadcast_shapes(matrix.shape[:-1], translation.shape[:-1])
        changed = np.broadcast_to(matrix, (*shape, 16)).copy()
        changed[..., 12:15] = translation
        return changed


class SetMatrix4Scale(_OnMatrix, type="omni.graph.nodes.SetMatrix4Scale"):
    """A transformation matrix with its scale replaced."""

    matrix_in: Any = In(type=matrices(3, 4), name="matrix", required=True, doc="matrix, or array of matrices")
    scale: Any = In(type=_VECTOR3, required=True, doc="scale factors along x, y and z")
    matrix_out: Any = Out(
        type=matrices(3, 4), name="matrix", doc="matrix whose first three rows have the lengths in `scale`"
    )

    @staticmethod
    def operation(matrix: Any, scale: Any) -> Any:
        """Set the scale of an array of matrices."""
        squares = square(matrix)
        changed = np.broadcast_to(squares, np.broadcast_shapes(squares.shape, (*scale.shape[:-1], 1, 1))).copy()
        changed[..., :3, :3] = unit(changed[..., :3, :3]) * scale[..., None]
        return flat(changed)


class SetMatrix4Quaternion(_OnMatrix, type="omni.graph.nodes.SetMatrix4Quaternion"):
    """A transformation matrix with its rotation replaced by a quaternion's, and without scale.

    An older type than SetMatrix4Rotation.
    """

    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix, or array of matrices")
    quaternion: Any = In(
        type=with_arrays("quatd[4]"), required=True, doc="new rotation, a quaternion of any norm above 0"
    )
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new rotation and without scale")

    @staticmethod
    def operation(matrix: Any, quaternion: Any) -> Any:
        """Set the rotation of an array of matrices."""
        return _with_rotation(matrix, rotation_matrix(quaternion))


class SetMatrix4Rotation(_OnMatrix, type="omni.graph.nodes.SetMatrix4Rotation"):
    """A transformation matrix with its rotation replaced and without scale."""

    fixed_rotation_axis: Token = In(
        default="Y", tokens=("X", "Y", "Z", "Custom"), doc="axis of rotation; used if `rotationAngle` is a scalar"
    )
    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix, or array of matrices")
    rotation_angle: Any = In(
        type=with_arrays("double|vectord[3]|quatd[4]|matrixd[3]"),
        required=True,
        unit="deg",
        doc="new rotation: one angle about an axis, angles about x, y and z, a quaternion, or a 3 x 3 matrix",
    )
    rotation_axis: Vector3d = In(default=(0.0, 1.0, 0.0), doc="axis of rotation; used if `fixedRotationAxis` is Custom")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new rotation and without scale")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the function that sets the rotation, about an axis if `rotationAngle` is a scalar."""
        angles = inputs[1]

        def turned(matrix: Any, rotation: Any, axis: Any) -> Any:
            if angles.count > 1:
                return _with_rotation(matrix, rotation_matrix(rotation, self.rotation_order))
            return _with_rotation(matrix, matrix_about(axis, rotation[..., 0] if angles.array else rotation))

        return lift(turned, inputs, output)

    def compute(self) -> None:
        """Set the rotation.

        Raises:
            BadValueError: `fixedRotationAxis` is unknown.
        """
        axis = self.rotation_axis
        if self.fixed_rotation_axis != "Custom":
            axis = _AXES[one_of("fixedRotationAxis", self.fixed_rotation_axis, (*_AXES, "Custom"))]
        self.matrix_out = self.operate(self.matrix_in, self.rotation_angle, axis)


class MakeTransform(Node, type="omni.graph.nodes.MakeTransform"):
    """A transformation matrix that scales, then rotates, then translates."""

    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation_xyz: Vector3d = In(default=(0.0, 0.0, 0.0), name="rotationXYZ", unit="deg", doc="angles about x, y and z")
    scale: Vector3d = In(default=(1.0, 1.0, 1.0), doc="scale factors along x, y and z")
    translation: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m")
    transform: Matrix4d = Out(doc="4 x 4 matrix, row by row, with the translation as its fourth row")

    def compute(self) -> None:
        """Build the matrix.

        Raises:
            BadValueError: the rotation order is unknown.
        """
        matrix = np.eye(4)
        with np.errstate(all="ignore"):
            turn = rotation_matrix(np.array(self.rotation_xyz), self.rotation_order)
            matrix[:3, :3] = np.array(self.scale)[:, None] * turn
        matrix[3, :3] = self.translation
        self.transform = tuple(matrix.ravel().tolist())


class MakeTransformLookAt(Node, type="omni.graph.nodes.MakeTransformLookAt"):
    """The pose of a camera whose -z axis points at `center`, with y as close to `up` as possible and x to the right."""

    center: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m", doc="point to look at")
    eye: Vector3d = In(default=(1.0, 0.0, 0.0), unit="m", doc="position of the camera")
    up: Vector3d = In(
        default=(0.0, 1.0, 0.0), doc="up direction; the y axis of the camera is as close to it as possible"
    )
    transform: Matrix4d = Out(
        doc="pose of the camera as a 4 x 4 matrix, row by row, with the position as its fourth row"
    )

    def compute(self) -> None:
        """Build the matrix."""
        matrix, eye = np.eye(4), np.array(self.eye)
        with np.errstate(all="ignore"):
            backward = unit(eye - np.array(self.center))
            right = unit(np.cross(self.up, backward))
            matrix[:3, :3] = right, np.cross(backward, right), backward
        matrix[3, :3] = eye
        self.transform = tuple(matrix.ravel().tolist())


class RotateVector(Elementwise, type="omni.graph.nodes.RotateVector"):
    """A vector rotated by angles, a quaternion or a matrix; the translation of a 4 x 4 matrix is ignored."""

    like = "vector"

    rotation: Any = In(
        type=f"{matrices(3, 4)}|{QUATERNIONS}|{VECTORS}", required=True, doc=f"{_ANGLES}, quaternion or matrix"
    )
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    vector: Any = In(type=VECTORS, required=True, doc="vector, or array of vectors")
    result: Any = Out(type=VECTORS, doc="rotated vector, of the same type")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the function that applies the linear part of a matrix, or the rotation of angles or a quaternion."""
        linear = inputs[0].count > 4

        def turned(rotation: Any, vector: Any) -> Any:
            by = square(rotation)[..., :3, :3] if linear else rotation_matrix(rotation, self.rotation_order)
            return (vector[..., None, :] @ by)[..., 0, :]

        return lift(turned, inputs, output)
