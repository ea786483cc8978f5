"""ROS2PublishPointCloud: points and their metadata from arrays and buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from graphengine.messages import messages
from graphengine.nodes.ros2.point_cloud import ROS2PublishPointCloud
from graphengine.testing import RecordingContext
from tests.nodes.harness import read_points, ready

POINTS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], np.float32)
METADATA: dict[str, tuple[Any, dict[str, list[Any]], list[int]]] = {
    # A kind's two records, its fields with their values, and their datatypes in sensor_msgs/PointField.
    "intensity": (np.array([7, 255], np.float32), {"intensity": [7.0, 255.0]}, [7]),
    "timestamp": (np.array([5, 2**32 + 6], np.uint64), {"timestamp": [(5, 0), (6, 1)]}, [6]),
    "emitter_id": (np.array([1, 2], np.uint32), {"emitter_id": [1, 2]}, [6]),
    "channel_id": (np.array([3, 4], np.uint32), {"channel_id": [3, 4]}, [6]),
    "material_id": (np.array([5, 6], np.uint32), {"material_id": [5, 6]}, [6]),
    "tick_id": (np.array([7, 8], np.uint32), {"tick_id": [7, 8]}, [6]),
    "hit_normal": (np.eye(2, 3, dtype=np.float32), {"nx": [1.0, 0.0], "ny": [0.0, 1.0], "nz": [0.0, 0.0]}, [7, 7, 7]),
    "velocity": (
        np.array([[0.5] * 3, [0.0] * 3], np.float32),
        {"vx": [0.5, 0.0], "vy": [0.5, 0.0], "vz": [0.5, 0.0]},
        [7, 7, 7],
    ),
    "object_id": (np.arange(8, dtype=np.uint32), {"object_id": [(0, 1, 2, 3), (4, 5, 6, 7)]}, [6]),
    "echo_id": (np.array([0, 1], np.uint8), {"echo_id": [0, 1]}, [2]),
    "tick_state": (b"\x02\x03", {"tick_state": [2, 3]}, [2]),
    "radial_velocity_ms": (np.array([-1.5, 2.5], np.float32), {"radial_velocity_ms": [-1.5, 2.5]}, [7]),
}

every_kind = pytest.mark.parametrize("kind", METADATA)


def cloud_of(*kinds: str, **inputs: Any) -> Any:
    """The message of the two points with those metadata."""
    chosen: dict[str, Any] = {f"output_{kind}": True for kind in kinds}
    chosen |= {f"{kind}_ptr": METADATA[kind][0] for kind in kinds}
    return ready(ROS2PublishPointCloud, RecordingContext(), **{"data": POINTS, **chosen, **inputs}).message()


def test_points_are_rows_of_three_floats() -> None:
    cloud = cloud_of()
    messages.check(cloud)
    assert read_points(cloud) == {"x": [1.0, 4.0], "y": [2.0, 5.0], "z": [3.0, 6.0]}
    assert [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields] == [
        ("x", 0, 7, 1),
        ("y", 4, 7, 1),
        ("z", 8, 7, 1),
    ]
    assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (1, 2, 12, 24)
    assert (cloud.is_bigendian, cloud.is_dense) == (False, True)


@every_kind
def test_selected_metadata_become_fields(kind: str) -> None:
    cloud = cloud_of(kind)
    messages.check(cloud)
    _, expected, datatypes = METADATA[kind]
    assert read_points(cloud) == {"x": [1.0, 4.0], "y": [2.0, 5.0], "z": [3.0, 6.0]} | expected
    assert [field.datatype for field in cloud.fields] == [7, 7, 7, *datatypes]


@given(kinds=st.permutations(list(METADATA)).flatmap(lambda all_: st.integers(0, 12).map(lambda n: all_[:n])))
def test_any_selection_of_metadata_has_isaac_sims_order(kinds: list[str]) -> None:
    expected = [name for kind in METADATA if kind in kinds for name in METADATA[kind][1]]
    cloud = cloud_of(*kinds)
    assert list(read_points(cloud)) == ["x", "y", "z", *expected]
    assert cloud.point_step == 12 + sum(memoryview(METADATA[kind][0]).nbytes // 2 for kind in kinds)


@every_kind
def test_metadata_that_are_not_selected_are_left_out(kind: str) -> None:
    assert list(read_points(cloud_of(kind, **{f"output_{kind}": False}))) == ["x", "y", "z"]


@every_kind
def test_metadata_without_a_buffer_are_an_error_that_names_the_port(kind: str) -> None:
    port = ROS2PublishPointCloud.fields[f"{kind}_ptr"].name
    with pytest.raises(ValueError, match=f", {port} must be a buffer"):
        cloud_of(kind, **{f"{kind}_ptr": 0})


@every_kind
def test_a_buffer_without_one_record_per_point_is_an_error(kind: str) -> None:
    with pytest.raises(ValueError, match="bytes for each of 1 points"):
        cloud_of(kind, data=POINTS[:1])


def test_points_may_come_as_a_buffer() -> None:
    assert bytes(cloud_of("intensity", data=[], data_ptr=POINTS).data) == bytes(cloud_of("intensity").data)


def test_a_buffer_that_is_not_a_whole_number_of_points_is_an_error() -> None:
    with pytest.raises(ValueError, match="dataPtr must be a multiple of 12 bytes, three float32 per point, it is 16"):
        cloud_of(data=[], data_ptr=np.zeros(4, np.float32))


def test_an_array_takes_precedence_over_a_buffer() -> None:
    assert read_points(cloud_of(data_ptr=np.zeros(6, np.float32)))["x"] == [1.0, 4.0]


def test_points_without_metadata_are_not_copied() -> None:
    node: Any = ready(ROS2PublishPointCloud, RecordingContext(), data=POINTS)
    assert np.shares_memory(node.message().data, node.data)


@pytest.mark.parametrize("kinds", [(), tuple(METADATA)])
def test_no_points_are_an_empty_cloud_with_all_its_fields(kinds: tuple[str, ...]) -> None:
    empty = {f"{kind}_ptr": b"" for kind in kinds}
    cloud = cloud_of(*kinds, data=[], **empty)
    messages.check(cloud)
    assert (cloud.width, cloud.row_step, len(cloud.data)) == (0, 0, 0)
    assert [f.name for f in cloud.fields] == ["x", "y", "z", *(name for kind in kinds for name in METADATA[kind][1])]


def test_rosbags_reads_the_bytes_back() -> None:
    data = messages.encode(cloud_of(*METADATA))
    read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, "sensor_msgs/msg/PointCloud2")
    expected = {name: values for _, fields, _ in METADATA.values() for name, values in fields.items()}
    assert read_points(read) == {"x": [1.0, 4.0], "y": [2.0, 5.0], "z": [3.0, 6.0]} | expected


def test_points_and_metadata_need_not_be_contiguous() -> None:
    rows = np.repeat(POINTS, 2, axis=0)[::2]
    cloud = cloud_of(data=[], data_ptr=rows, output_echo_id=True, echo_id_ptr=np.arange(4, dtype=np.uint8)[::2])
    assert read_points(cloud) == {"x": [1.0, 4.0], "y": [2.0, 5.0], "z": [3.0, 6.0], "echo_id": [0, 2]}
