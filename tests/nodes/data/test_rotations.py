"""Translation, rotation and scale read from and put into transformation matrices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.data.orientation import ORDERS
from graphengine.nodes.data.rotations import (
    GetMatrix4Quaternion,
    GetMatrix4Rotation,
    GetMatrix4RotationMatrix,
    GetMatrix4Scale,
    GetMatrix4Translation,
    MakeTransform,
    MakeTransformLookAt,
    RotateVector,
    SetMatrix4Quaternion,
    SetMatrix4Rotation,
    SetMatrix4Scale,
    SetMatrix4Translation,
)
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player, matrix, yaw

ANGLES = st.tuples(*[st.integers(-80, 80)] * 3).map(lambda angles: tuple(map(float, angles)))
POSITIONS = st.tuples(*[st.integers(-9, 9)] * 3).map(lambda numbers: tuple(map(float, numbers)))
SCALES = st.tuples(*[st.integers(1, 9)] * 3).map(lambda numbers: tuple(map(float, numbers)))
QUARTER = yaw(math.pi / 2)


def transform(
    rotation: Any = None, translation: Any = (0.0, 0.0, 0.0), scale: Any = (1.0, 1.0, 1.0)
) -> tuple[float, ...]:
    """Scale, then a rotation matrix that acts on columns, then translation, as one matrix that acts on rows."""
    whole = np.eye(4)
    whole[:3, :3] = np.diag(scale) @ (np.eye(3) if rotation is None else rotation.T)
    whole[3, :3] = translation
    return tuple(whole.ravel().tolist())


def near(expected: tuple[float, ...]) -> Any:
    """Equal but for rounding."""
    return pytest.approx(expected, abs=1e-14)


@given(POSITIONS, SCALES, ANGLES, st.sampled_from(ORDERS))
def test_translation_rotation_and_scale_of_a_transform_are_read_back(
    position: Any, scale: Any, angles: Any, order: str
) -> None:
    made = computed(
        MakeTransform, translation=position, scale=scale, rotation_xyz=angles, rotation_order=order
    ).transform
    assert computed(GetMatrix4Translation, matrix=made).translation == position
    assert computed(GetMatrix4Scale, matrix=made).scale == pytest.approx(scale, rel=1e-12)
    assert computed(GetMatrix4Rotation, matrix=made, rotation_order=order).rotation == pytest.approx(angles, abs=1e-9)


def test_a_transform_scales_then_turns_then_moves() -> None:
    made = computed(
        MakeTransform, translation=(10.0, 0.0, 0.0), rotation_xyz=(0.0, 0.0, 90.0), scale=(2.0, 1.0, 1.0)
    ).transform
    assert made == pytest.approx(transform(matrix(QUARTER), (10.0, 0.0, 0.0), (2.0, 1.0, 1.0)), abs=1e-15)
    assert np.array([1.0, 0.0, 0.0, 1.0]) @ np.reshape(made, (4, 4)) == pytest.approx([10.0, 2.0, 0.0, 1.0])


@given(st.floats(-3.0, 3.0), SCALES)
def test_the_quaternion_of_a_matrix_is_its_rotation_without_the_scale(angle: float, scale: Any) -> None:
    found = computed(GetMatrix4Quaternion, matrix=transform(matrix(yaw(angle)), (1.0, 2.0, 3.0), scale)).quaternion
    assert found == pytest.approx(yaw(angle), abs=1e-12)
    assert {type(part) for part in found} == {float}


def test_a_rotation_is_read_equally_from_matrices_angles_and_quaternions() -> None:
    of_rows = transform(matrix(QUARTER))
    three = tuple(np.reshape(of_rows, (4, 4))[:3, :3].ravel().tolist())
    for given_rotation in (of_rows, three, (0.0, 0.0, 90.0)):
        assert computed(GetMatrix4Quaternion, matrix=given_rotation).quaternion == pytest.approx(QUARTER, abs=1e-12)
    for given_rotation in (of_rows, three, QUARTER):
        assert computed(GetMatrix4Rotation, matrix=given_rotation).rotation == pytest.approx(
            (0.0, 0.0, 90.0), abs=1e-12
        )
    for given_rotation in (of_rows, QUARTER, (0.0, 0.0, 90.0)):
        assert computed(GetMatrix4RotationMatrix, matrix=given_rotation).rotation == pytest.approx(three, abs=1e-12)


def test_arrays_give_arrays_of_the_base_of_the_input() -> None:
    angles = np.array([[0.0, 0.0, 90.0], [0.0, 0.0, 0.0]], np.float32)
    node = typed(GetMatrix4Quaternion, {"matrix": "vectorf[3][]"}, matrix=angles)
    assert (str(node.settled["quaternion"]), node.quaternion.dtype) == ("quatf[4][]", np.float32)
    np.testing.assert_allclose(node.quaternion, [QUARTER, yaw(0.0)], atol=1e-7)
    both = np.array([transform(translation=(1.0, 2.0, 3.0)), transform()])
    assert computed(GetMatrix4Translation, matrix=both).translation.tolist() == [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]


def test_setting_a_translation_changes_only_the_translation() -> None:
    before = transform(matrix(QUARTER), (1.0, 2.0, 3.0), (2.0, 2.0, 2.0))
    after = transform(matrix(QUARTER), (7.0, 8.0, 9.0), (2.0, 2.0, 2.0))
    assert computed(SetMatrix4Translation, matrix_in=before, translation=(7.0, 8.0, 9.0)).matrix_out == after
    many = computed(SetMatrix4Translation, matrix_in=before, translation=np.array([[7.0, 8.0, 9.0]])).matrix_out
    assert many.tolist() == [list(after)]


def test_setting_a_scale_changes_only_the_scale() -> None:
    before = transform(matrix(QUARTER), (1.0, 2.0, 3.0), (5.0, 6.0, 7.0))
    after = transform(matrix(QUARTER), (1.0, 2.0, 3.0), (2.0, 3.0, 4.0))
    assert computed(SetMatrix4Scale, matrix_in=before, scale=(2.0, 3.0, 4.0)).matrix_out == near(after)
    two = computed(SetMatrix4Scale, matrix_in=before, scale=np.array([(2.0, 3.0, 4.0)])).matrix_out
    assert two.tolist() == [near(after)]


def test_a_rotation_is_set_without_scale_and_the_translation_stays() -> None:
    before, after = transform(None, (1.0, 2.0, 3.0), (5.0, 6.0, 7.0)), transform(matrix(QUARTER), (1.0, 2.0, 3.0))
    assert computed(SetMatrix4Quaternion, matrix_in=before, quaternion=QUARTER).matrix_out == near(after)
    three = tuple(matrix(QUARTER).T.ravel().tolist())
    for rotation in (QUARTER, (0.0, 0.0, 90.0), three):
        assert computed(SetMatrix4Rotation, matrix_in=before, rotation_angle=rotation).matrix_out == near(after)
    how: list[dict[str, Any]] = [
        {"fixed_rotation_axis": "Z"},
        {"fixed_rotation_axis": "Custom", "rotation_axis": (0.0, 0.0, 3.0)},
    ]
    for axis in how:
        assert computed(SetMatrix4Rotation, matrix_in=before, rotation_angle=90.0, **axis).matrix_out == near(after)


def test_each_angle_of_an_array_makes_a_matrix() -> None:
    node = computed(
        SetMatrix4Rotation, matrix_in=transform(), rotation_angle=np.array([0.0, 90.0]), fixed_rotation_axis="Z"
    )
    np.testing.assert_allclose(node.matrix_out, [transform(), transform(matrix(QUARTER))], atol=1e-15)


def test_a_vector_is_turned_by_any_rotation() -> None:
    moved = transform(matrix(QUARTER), (9.0, 9.0, 9.0))
    three = tuple(matrix(QUARTER).T.ravel().tolist())
    for rotation in (moved, three, QUARTER, (0.0, 0.0, 90.0)):
        assert computed(RotateVector, rotation=rotation, vector=(1.0, 2.0, 3.0)).result == pytest.approx(
            (-2.0, 1.0, 3.0)
        )
    many = computed(RotateVector, rotation=QUARTER, vector=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])).result
    np.testing.assert_allclose(many, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], atol=1e-15)


def test_a_look_at_camera_looks_along_its_negative_z_axis_with_y_up() -> None:
    made = np.reshape(computed(MakeTransformLookAt, eye=(0.0, 0.0, 5.0), center=(0.0, 0.0, 0.0)).transform, (4, 4))
    np.testing.assert_allclose(made[:3, :3], np.eye(3), atol=1e-15)
    assert made[3].tolist() == [0.0, 0.0, 5.0, 1.0]
    aside = np.reshape(
        computed(MakeTransformLookAt, eye=(1.0, 2.0, 3.0), center=(4.0, 6.0, 3.0), up=(0.0, 0.0, 1.0)).transform, (4, 4)
    )
    np.testing.assert_allclose(-aside[2, :3], [0.6, 0.8, 0.0], atol=1e-15)
    np.testing.assert_allclose(aside[:3, :3] @ aside[:3, :3].T, np.eye(3), atol=1e-15)
    assert aside[1, :3].tolist() == pytest.approx([0.0, 0.0, 1.0])


def test_defaults_make_no_change() -> None:
    assert computed(MakeTransform).transform == transform()
    assert GetMatrix4Quaternion.kind() == "data"


def test_in_a_graph_a_pose_goes_through_a_matrix_and_back(play: Player) -> None:
    nodes = {
        "Make": "{type: MakeTransform, inputs: {translation: [1, 2, 3], rotationXYZ: [10, 20, 30]}}",
        "Where": "GetMatrix4Translation",
        "Turned": "GetMatrix4Quaternion",
        "Angles": "GetMatrix4Rotation",
    }
    wires = ["Make.transform -> Where.matrix", "Make.transform -> Turned.matrix", "Turned.quaternion -> Angles.matrix"]
    assert shown(play, "double[3] Where.translation", nodes, wires) == (1.0, 2.0, 3.0)
    assert shown(play, "vectord[3] Angles.rotation", nodes, wires) == pytest.approx((10.0, 20.0, 30.0), abs=1e-9)


def test_in_a_graph_an_unknown_rotation_order_is_refused_with_the_six_legal_orders(play: Player) -> None:
    with pytest.raises(CheckError, match=r"Make\.rotationOrder: expected one of XYZ, XZY, YXZ, YZX, ZXY, ZYX"):
        shown(play, "matrixd[4] Make.transform", {"Make": "{type: MakeTransform, inputs: {rotationOrder: XYX}}"})
