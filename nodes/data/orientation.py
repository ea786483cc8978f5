"""Functions that convert between quaternions, rotation matrices and angles about x, y and z.

The last axis of an array holds one quaternion or three angles; the last two axes hold one matrix. Quaternions are (x, y, z, w).
Matrices multiply row vectors, as everywhere in OmniGraph, so they are the transposes of matrices for column vectors. Angles are
in degrees about the fixed axes x, y and z. A rotation order such as XYZ lists the axes in the order in which angles are applied.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.nodes.checked import one_of

Array = NDArray[np.float64]

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def matrix_of_quaternions(quaternions: Array) -> Array:
    """Return the rotation matrices (..., 3, 3) of quaternions (..., 4), whose norms may be any number above 0."""
    x, y, z, w = np.moveaxis(unit(quaternions), -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternions_of(matrices: Array) -> Array:
    """Return the unit quaternions (..., 4) with w >= 0 of rotation matrices (..., 3, 3).

    A rotation matrix determines the 4 x 4 matrix of the products 4 q_i q_j of all quaternion components. Each row of these
    products is a multiple of the quaternion; the row with the largest diagonal element is normalized.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(matrices, (-2, -1), (0, 1))
    products = np.array(
        [
            [1.0 + xx - yy - zz, xy + yx, xz + zx, yz - zy],
            [xy + yx, 1.0 - xx + yy - zz, yz + zy, zx - xz],
            [xz + zx, yz + zy, 1.0 - xx - yy + zz, xy - yx],
            [yz - zy, zx - xz, xy - yx, 1.0 + xx + yy + zz],
        ]
    )
    products = np.moveaxis(products, (0, 1), (-2, -1))
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    found = unit(np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :])
    return np.where(found[..., 3:] < 0.0, -found, found)


def axes_of(order: str) -> list[int]:
    """Return the axes of a rotation order such as XYZ, as indices from 0 to 2.

    Raises:
        BadValueError: the order is not one of `ORDERS`.
    """
    return ["XYZ".index(axis) for axis in one_of("rotationOrder", order, ORDERS)]


def matrix_of_angles(degrees: Array, order: str) -> Array:
    """Return the rotation matrices (..., 3, 3) of angles (..., 3) about x, y and z, in degrees, applied in the given order."""
    total: Array = np.broadcast_to(np.eye(3), (*degrees.shape[:-1], 3, 3))
    for axis in axes_of(order):
        total = total @ _about_own_axis(axis, degrees[..., axis])
    return total


def _about_own_axis(axis: int, degrees: Array) -> Array:
    """Return the matrices (..., 3, 3) of rotations about a coordinate axis, given by its index from 0 to 2."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    second, third = (axis + 1) % 3, (axis + 2) % 3
    turn = np.zeros((*degrees.shape, 3, 3))
    turn[..., axis, axis] = 1.0
    turn[..., second, second] = turn[..., third, third] = cosine
    turn[..., second, third], turn[..., third, second] = sine, -sine
    return turn


def angles_of(matrices: Array, order: str) -> Array:
    """Return the angles (..., 3) about x, y and z, in degrees, of rotation matrices (..., 3, 3), for the given rotation order.

    If the angle applied second is 90 or -90 degrees (gimbal lock), the angle applied last is set to 0.
    """
    first, second, third = axes_of(order)
    sign = 1.0 if order in ("XYZ", "YZX", "ZXY") else -1.0
    sine = np.clip(-sign * matrices[..., first, third], -1.0, 1.0)
    locked = np.abs(sine) > 1.0 - 1e-12
    angles = np.empty(matrices.shape[:-1])
    angles[..., second] = np.arcsin(sine)
    angles[..., first] = np.where(
        locked,
        np.arctan2(-sign * matrices[..., third, second], matrices[..., second, second]),
        np.arctan2(sign * matrices[..., second, third], matrices[..., third, third]),
    )
    free = np.arctan2(sign * matrices[..., first, second], matrices[..., first, first])
    angles[..., third] = np.where(locked, 0.0, free)
    return np.degrees(angles)


def matrix_about(axis: Array, degrees: Array) -> Array:
    """Return the matrices (..., 3, 3) of rotations by angles (...), in degrees, about axes (..., 3) of any length above 0."""
    half = np.radians(degrees)[..., None] / 2.0
    vector = unit(axis) * np.sin(half)
    real = np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1))
    return matrix_of_quaternions(np.concatenate([vector, real], axis=-1))


def without_scale(matrices: Array) -> Array:
    """Return the rotations (..., 3, 3) of linear maps (..., 3, 3) that first scale and then rotate.

    A map with a negative determinant is assumed to mirror all three axes.
    """
    rows = unit(matrices)
    mirrored = np.linalg.det(rows)[..., None, None] < 0.0
    turned: Array = np.where(mirrored, -rows, rows)
    return turned


def rotation_matrix(values: Array, order: str = "XYZ") -> Array:
    """Return rotation matrices (..., 3, 3) for transformation matrices, quaternions or angles.

    The number of components selects the representation.

    Args:
        values: array whose last axis holds the 16 or 9 numbers of a matrix, the 4 of a quaternion, or 3 angles in degrees.
        order: rotation order of angles.
    """
    match values.shape[-1]:
        case 16:
            return without_scale(values.reshape(*values.shape[:-1], 4, 4)[..., :3, :3])
        case 9:
            return without_scale(values.reshape(*values.shape[:-1], 3, 3))
        case 4:
            return matrix_of_quaternions(values)
    return matrix_of_angles(values, order)


def unit(vectors: Any) -> Array:
    """Return vectors (..., n) scaled to length 1; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    units: Array = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)
    return units


def slerp(start: Array, end: Array, alpha: Array) -> Array:
    """Return the quaternions (..., 4) at the fraction `alpha` (0 to 1) of the shorter arc from `start` to `end`."""
    one, other = unit(start), unit(end)
    cosine = np.sum(one * other, axis=-1, keepdims=True)
    other, cosine = np.where(cosine < 0.0, -other, other), np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    near = angle < 1e-6  # the arc is a line as far as a double can tell
    sine = np.where(near, 1.0, np.sin(angle))
    left = np.where(near, 1.0 - alpha, np.sin((1.0 - alpha) * angle) / sine)
    gone = np.where(near, alpha, np.sin(alpha * angle) / sine)
    return unit(left * one + gone * other)
