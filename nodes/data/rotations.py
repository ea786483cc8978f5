"""Nodes that read and set translation, rotation and scale in transformation matrices (`omni.graph.nodes`).

Matrices multiply row vectors, so the translation is the fourth row. Angles are in degrees about the fixed axes x, y and z, and
are applied in the order of `rotationOrder`. Quaternions are (x, y, z, w).
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
_ORDER = "order in which the angles about the fixed axes x, y and z are applied"


class _FromMatrix(Elementwise):
    """Base class of nodes that output one part of a transformation matrix, or convert a rotation."""

    part = PortType("double", 3, False, "vector")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output; the base type is that of the input, and an array input gives an array."""
        (source,) = given.values()
        return replace(self.part, base=source.base, array=source.array)


class GetMatrix4Translation(_FromMatrix, type="omni.graph.nodes.GetMatrix4Translation"):
    """Outputs the translation of a transformation matrix."""

    matrix: Any = In(type=_MATRIX4, required=True, doc="transformation matrix, or array of matrices")
    translation: Any = Out(type=_VECTOR3, unit="m")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that reads the translation of a matrix, or of each matrix in an array."""
        if output.array:
            return lambda matrices: np.ascontiguousarray(matrices[:, 12:15])
        return operator.itemgetter(slice(12, 15))


class GetMatrix4Scale(_FromMatrix, type="omni.graph.nodes.GetMatrix4Scale"):
    """Outputs the scale of a transformation matrix along x, y and z."""

    matrix: Any = In(type=matrices(3, 4), required=True, doc="transformation matrix, or array of matrices")
    scale: Any = Out(type=_VECTOR3, doc="scale factors along x, y and z")

    @staticmethod
    def operation(matrix: Any) -> Any:
        """Return the scales, shape (..., 3), of flattened 3x3 matrices (..., 9) or 4x4 matrices (..., 16)."""
        return np.linalg.norm(square(matrix)[..., :3, :3], axis=-1)


class GetMatrix4Quaternion(_FromMatrix, type="omni.graph.nodes.GetMatrix4Quaternion"):
    """Outputs a rotation as a quaternion; the input is a transformation matrix, or angles about x, y and z."""

    part = PortType("double", 4, False, "quat")

    matrix: Any = In(type=f"{matrices(3, 4)}|{VECTORS}", required=True, doc=f"matrix, {_ANGLES}, or array of these")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    quaternion: Any = Out(type=QUATERNIONS, doc="unit quaternion (x, y, z, w) with w >= 0")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion as a function of port values; it reads `rotationOrder` at each execution."""
        return lift(lambda one: quaternions_of(rotation_matrix(one, self.rotation_order)), inputs, output)


class GetMatrix4Rotation(_FromMatrix, type="omni.graph.nodes.GetMatrix4Rotation"):
    """Outputs a rotation as angles about x, y and z; the input is a transformation matrix or a quaternion."""

    matrix: Any = In(type=f"{matrices(3, 4)}|{QUATERNIONS}", required=True, doc="matrix, quaternion, or array of these")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation: Any = Out(type=VECTORS, unit="deg", doc="angles about x, y and z")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion as a function of port values; it reads `rotationOrder` at each execution."""
        return lift(lambda one: angles_of(rotation_matrix(one), self.rotation_order), inputs, output)


class GetMatrix4RotationMatrix(_FromMatrix, type="omni.graph.nodes.GetMatrix4RotationMatrix"):
    """Outputs a rotation as a 3 x 3 matrix; the input is a transformation matrix, angles or a quaternion."""

    part = PortType("double", 9, False, "matrixd")

    matrix: Any = In(
        type=f"{_MATRIX4}|{with_arrays('quatd[4]|vectord[3]')}", required=True, doc=f"matrix, {_ANGLES}, or quaternion"
    )
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation: Any = Out(type=matrices(3), doc="rotation matrix, without scale")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the conversion as a function of port values; it reads `rotationOrder` at each execution."""
        return lift(lambda one: flat(rotation_matrix(one, self.rotation_order)), inputs, output)


class _OnMatrix(Elementwise):
    """Base class of nodes that replace one part of a transformation matrix."""

    like = "matrix"


def _with_rotation(matrix: Any, rotation: Any) -> Any:
    """Return 4 x 4 matrices with the given rotations (..., 3, 3) and without scale; the translations are kept."""
    shape = np.broadcast_shapes(matrix.shape[:-1], rotation.shape[:-2])
    changed = np.broadcast_to(square(matrix), (*shape, 4, 4)).copy()
    changed[..., :3, :3] = rotation
    return flat(changed)


class SetMatrix4Translation(_OnMatrix, type="omni.graph.nodes.SetMatrix4Translation"):
    """Replaces the translation of a transformation matrix."""

    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix to change, or array of matrices")
    translation: Any = In(type=_VECTOR3, required=True, unit="m")
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new translation as its fourth row")

    @staticmethod
    def operation(matrix: Any, translation: Any) -> Any:
        """Return matrices (..., 16) with new translations (..., 3)."""
        shape = np.broadcast_shapes(matrix.shape[:-1], translation.shape[:-1])
        changed = np.broadcast_to(matrix, (*shape, 16)).copy()
        changed[..., 12:15] = translation
        return changed


class SetMatrix4Scale(_OnMatrix, type="omni.graph.nodes.SetMatrix4Scale"):
    """Replaces the scale of a transformation matrix."""

    matrix_in: Any = In(type=matrices(3, 4), name="matrix", required=True, doc="matrix to change, or array of matrices")
    scale: Any = In(type=_VECTOR3, required=True, doc="scale factors along x, y and z")
    matrix_out: Any = Out(
        type=matrices(3, 4), name="matrix", doc="matrix whose first three rows have the lengths in `scale`"
    )

    @staticmethod
    def operation(matrix: Any, scale: Any) -> Any:
        """Return matrices, given as numbers (..., 9) or (..., 16), with new scales (..., 3)."""
        squares = square(matrix)
        changed = np.broadcast_to(squares, np.broadcast_shapes(squares.shape, (*scale.shape[:-1], 1, 1))).copy()
        changed[..., :3, :3] = unit(changed[..., :3, :3]) * scale[..., None]
        return flat(changed)


class SetMatrix4Quaternion(_OnMatrix, type="omni.graph.nodes.SetMatrix4Quaternion"):
    """Replaces the rotation of a transformation matrix by a quaternion, and removes the scale.

    SetMatrix4Rotation is the newer node type.
    """

    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix to change, or array of matrices")
    quaternion: Any = In(type=with_arrays("quatd[4]"), required=True, doc="quaternion (x, y, z, w) of any norm above 0")
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new rotation and without scale")

    @staticmethod
    def operation(matrix: Any, quaternion: Any) -> Any:
        """Return matrices (..., 16) with the rotations of quaternions (..., 4) and without scale."""
        return _with_rotation(matrix, rotation_matrix(quaternion))


class SetMatrix4Rotation(_OnMatrix, type="omni.graph.nodes.SetMatrix4Rotation"):
    """Replaces the rotation of a transformation matrix, and removes the scale."""

    fixed_rotation_axis: Token = In(
        default="Y", tokens=("X", "Y", "Z", "Custom"), doc="axis of rotation; used if `rotationAngle` is a scalar"
    )
    matrix_in: Any = In(type=_MATRIX4, name="matrix", required=True, doc="matrix to change, or array of matrices")
    rotation_angle: Any = In(
        type=with_arrays("double|vectord[3]|quatd[4]|matrixd[3]"),
        required=True,
        unit="deg",
        doc="new rotation: angle about an axis, angles about x, y and z, quaternion, or 3 x 3 matrix",
    )
    rotation_axis: Vector3d = In(default=(0.0, 1.0, 0.0), doc="axis of rotation; used if `fixedRotationAxis` is Custom")
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    matrix_out: Any = Out(type=_MATRIX4, name="matrix", doc="matrix with the new rotation and without scale")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that replaces the rotation; a scalar `rotationAngle` is an angle about the given axis."""
        angles = inputs[1]

        def turned(matrix: Any, rotation: Any, axis: Any) -> Any:
            if angles.count > 1:
                return _with_rotation(matrix, rotation_matrix(rotation, self.rotation_order))
            return _with_rotation(matrix, matrix_about(axis, rotation[..., 0] if angles.array else rotation))

        return lift(turned, inputs, output)

    def compute(self) -> None:
        """Set the output to the matrix with the new rotation.

        Raises:
            BadValueError: `fixedRotationAxis` or `rotationOrder` is unknown.
        """
        axis = self.rotation_axis
        if self.fixed_rotation_axis != "Custom":
            axis = _AXES[one_of("fixedRotationAxis", self.fixed_rotation_axis, (*_AXES, "Custom"))]
        self.matrix_out = self.operate(self.matrix_in, self.rotation_angle, axis)


class MakeTransform(Node, type="omni.graph.nodes.MakeTransform"):
    """Builds a transformation matrix that scales, then rotates, then translates."""

    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    rotation_xyz: Vector3d = In(default=(0.0, 0.0, 0.0), name="rotationXYZ", unit="deg", doc="angles about x, y and z")
    scale: Vector3d = In(default=(1.0, 1.0, 1.0), doc="scale factors along x, y and z")
    translation: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m")
    transform: Matrix4d = Out(doc="4 x 4 matrix, row by row, with the translation as its fourth row")

    def compute(self) -> None:
        """Set `transform` to the matrix.

        Raises:
            BadValueError: `rotationOrder` is unknown.
        """
        matrix = np.eye(4)
        with np.errstate(all="ignore"):
            turn = rotation_matrix(np.array(self.rotation_xyz), self.rotation_order)
            matrix[:3, :3] = np.array(self.scale)[:, None] * turn
        matrix[3, :3] = self.translation
        self.transform = tuple(matrix.ravel().tolist())


class MakeTransformLookAt(Node, type="omni.graph.nodes.MakeTransformLookAt"):
    """Builds the pose of a camera that looks at a point.

    The -z axis of the camera points at `center`, the y axis is as close to `up` as possible, and the x axis points to the right.
    """

    center: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m", doc="point to look at")
    eye: Vector3d = In(default=(1.0, 0.0, 0.0), unit="m", doc="position of the camera")
    up: Vector3d = In(default=(0.0, 1.0, 0.0), doc="up direction, to which the camera's y axis is closest")
    transform: Matrix4d = Out(doc="pose of the camera: 4 x 4 matrix, row by row; its fourth row is the position")

    def compute(self) -> None:
        """Set `transform` to the pose of the camera."""
        matrix, eye = np.eye(4), np.array(self.eye)
        with np.errstate(all="ignore"):
            backward = unit(eye - np.array(self.center))
            right = unit(np.cross(self.up, backward))
            matrix[:3, :3] = right, np.cross(backward, right), backward
        matrix[3, :3] = eye
        self.transform = tuple(matrix.ravel().tolist())


class RotateVector(Elementwise, type="omni.graph.nodes.RotateVector"):
    """Rotates a vector by angles, a quaternion or a matrix; the translation of a 4 x 4 matrix is ignored."""

    like = "vector"

    rotation: Any = In(
        type=f"{matrices(3, 4)}|{QUATERNIONS}|{VECTORS}", required=True, doc=f"{_ANGLES}, quaternion or matrix"
    )
    rotation_order: Token = In(default="XYZ", tokens=ORDERS, doc=_ORDER)
    vector: Any = In(type=VECTORS, required=True, doc="vector to rotate, or array of vectors")
    result: Any = Out(type=VECTORS, doc="rotated vector, of the same type")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that rotates vectors. If the rotation is a matrix, its scale is applied too."""
        linear = inputs[0].count > 4

        def turned(rotation: Any, vector: Any) -> Any:
            by = square(rotation)[..., :3, :3] if linear else rotation_matrix(rotation, self.rotation_order)
            return (vector[..., None, :] @ by)[..., 0, :]

        return lift(turned, inputs, output)
