"""ROS2CameraInfoHelper and ROS2PublishCameraInfo: the calibration of a camera, and of a stereo pair."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from rosbags.typesys import Stores, get_typestore

from graphengine.devices import rotation
from graphengine.devices.camera import CameraStub
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import ContextError, PrimError
from graphengine.messages import messages
from graphengine.nodes.ros2.camera import ROS2CameraHelper
from graphengine.nodes.ros2.camera_info import ROS2CameraInfoHelper, ROS2PublishCameraInfo
from graphengine.testing import RecordingContext
from tests.nodes.harness import HelperBench, matrix, ready

LEFT, RIGHT = "/robot/Geometry/base_link/Left", "/robot/Geometry/base_link/Right"
FORWARD = (0.5, -0.5, -0.5, 0.5)
"""Of a camera that looks along its parent's x axis, with z up in the picture."""
OPTICAL = np.diag([1.0, -1.0, -1.0])
"""From the axes of a prim, which looks along -z with y up, to those of the optical frame."""


class Bench(HelperBench):
    """A camera of 1280 x 720 pixels and 87 degrees, and a helper on it.

    With `right`, how another differs that stands 95 mm to the right, they are a pair.
    """

    def __init__(
        self, *, right: Mapping[str, Any] | None = None, wanted: bool = True, rate: float = 30.0, **inputs: Any
    ) -> None:
        self.context = RecordingContext(wanted=wanted)
        self.context.world.add_robot("/robot")
        self.place(LEFT, (0.0, 0.0475, 0.0), rate=rate)
        second = {"path": RIGHT, "position": (0.0, -0.0475, 0.0), "rate": rate, **(right or {})}
        self.place(**second)
        inputs = {"render_product_path": LEFT, **inputs}
        if right is not None:
            inputs["render_product_path_right"] = second["path"]
        self.camera = self.context.world.device(CameraStub, self.context.world.stage.find(LEFT))
        self.node = ready(ROS2CameraInfoHelper, self.context, **inputs)

    def place(self, path: str, position: Vector3, turn: Quaternion = FORWARD, **facts: Any) -> None:
        facts = {"size": (1280, 720), "fov_deg": (87.0, 58.0), **facts}
        self.context.world.stage.add(path, "camera", position=position, orientation=turn, facts=facts)

    def tick(self, *, due: bool) -> None:
        """A tick in which the camera has a sample, or has none."""
        self.context.tick()
        self.camera.due = due
        self.executed()

    def calibration(self, topic: str = "/camera_info") -> Any:
        """What is published for a sample."""
        self.tick(due=True)
        self.tick(due=False)
        (info,) = self.context.transport.messages(topic)
        return info


def projected(p: ArrayLike, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixel of a point, as sensor_msgs/CameraInfo defines P."""
    u, v, w = np.array(p).reshape(3, 4) @ [*point, 1.0]
    return np.array([u / w, v / w])


# One camera


def test_a_pinhole_camera_has_square_pixels_no_distortion_and_identity_rectification() -> None:
    info = Bench(frame_id="front").calibration()
    fx = 640.0 / math.tan(math.radians(87.0) / 2)
    assert info.k.tolist() == pytest.approx([fx, 0, 639.5, 0, fx, 359.5, 0, 0, 1])
    assert info.r.tolist() == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert info.p.tolist() == pytest.approx([fx, 0, 639.5, 0, 0, fx, 359.5, 0, 0, 0, 1, 0])
    assert not np.signbit(info.p).any()  # `ros2 topic echo` shows -0.0 as such
    assert (info.distortion_model, info.d.tolist()) == ("plumb_bob", [0.0] * 5)
    assert (info.width, info.height, info.header.frame_id) == (1280, 720, "front")
    assert (info.binning_x, info.binning_y, info.roi.width, info.roi.do_rectify) == (0, 0, 0, False)


@given(width=st.integers(1, 4096), height=st.integers(1, 4096), degrees=st.floats(1.0, 179.0))
def test_points_at_the_edge_of_the_field_of_view_project_onto_the_edge_of_the_image(
    width: int, height: int, degrees: float
) -> None:
    context = RecordingContext()
    context.world.add_device(CameraStub, "/Camera", size=(width, height), fov_deg=(degrees, degrees))
    node = ready(ROS2CameraInfoHelper, context, render_product_path="/Camera")
    info = node.message(node.eyes[0], 0.0)
    # The middle of pixel 0 is 0, so the picture reaches from -0.5 to width - 0.5.
    edge = math.tan(math.radians(degrees) / 2)
    expected = (height - 1) / 2
    assert projected(info.p, np.array([edge, 0.0, 1.0])) == pytest.approx([width - 0.5, expected], abs=1e-6)
    assert projected(info.p, np.array([-edge, 0.0, 1.0])) == pytest.approx([-0.5, expected], abs=1e-6)


def test_the_calibration_has_the_image_size_of_the_render_product(context: RecordingContext) -> None:
    context.world.add_device(CameraStub, "/Camera", size=(1280, 720), fov_deg=(90.0, 60.0))
    node = ready(ROS2CameraInfoHelper, context, render_product_path=context.render_product("/Camera", 640, 360))
    info = node.message(node.eyes[0], 0.0)
    assert (info.width, info.height) == (640, 360)
    assert info.k.tolist() == pytest.approx([320.0, 0, 319.5, 0, 320.0, 179.5, 0, 0, 1])


def test_rosbags_decodes_the_camera_info_message() -> None:
    bench = Bench()
    for _ in range(3):  # later ones by a template of the first
        bench.tick(due=True)
    first, second = bench.context.transport.raw("/camera_info")
    store = get_typestore(Stores.ROS2_JAZZY)
    one, two = (store.deserialize_cdr(data, "sensor_msgs/msg/CameraInfo") for data in (first, second))
    messages.check(messages.decode(first, "sensor_msgs/msg/CameraInfo"))
    assert one.k.tolist() == two.k.tolist() == bench.node.message(bench.node.eyes[0], 0.0).k.tolist()  # type: ignore[attr-defined]
    assert one.header.stamp != two.header.stamp  # type: ignore[attr-defined]


# A stereo pair


def seen_by(context: RecordingContext, path: str, point: Vector3) -> NDArray[np.float64]:
    """A point of the world in a camera's optical frame, from the poses of the prims alone."""
    position, orientation = context.frame(path).pose()
    in_optical: NDArray[np.float64] = OPTICAL @ matrix(orientation).T @ np.subtract(point, position)
    return in_optical


@given(
    point=st.tuples(st.floats(0.5, 20.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0)),
    mount=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_both_projections_of_a_pair_agree_with_the_poses_of_the_cameras(
    point: Vector3, mount: tuple[float, float, float]
) -> None:
    bench = Bench(right={})
    turn = rotation.from_rpy(*mount)
    bench.context.world.body(bench.context.world.stage.find("/robot")).orientation = turn
    left, right = (bench.node.message(eye, 0.0) for eye in bench.node.eyes)
    in_world = rotation.rotate(turn, point)
    at_left, at_right = (seen_by(bench.context, path, in_world) for path in (LEFT, RIGHT))
    # P of both takes points in the left camera's frame.
    assert projected(left.p, at_left) == pytest.approx(pixel(left.k, at_left), abs=1e-6)
    assert projected(right.p, at_left) == pytest.approx(pixel(right.k, at_right), abs=1e-6)


def pixel(k: ArrayLike, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixel of a point in the camera's own frame, as sensor_msgs/CameraInfo defines K."""
    u, v, w = np.array(k).reshape(3, 3) @ point
    return np.array([u / w, v / w])


def test_the_projection_of_the_right_camera_contains_the_baseline() -> None:
    bench = Bench(right={}, frame_id_right="right", topic_name_right="right_info")
    right = bench.calibration("/right_info")
    fx = 640.0 / math.tan(math.radians(87.0) / 2)
    assert right.p.tolist() == pytest.approx([fx, 0, 639.5, -fx * 0.095, 0, fx, 359.5, 0, 0, 0, 1, 0])
    assert right.r.tolist() == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert right.header.frame_id == "right"
    (left,) = bench.sent
    assert left.p[3] == 0.0
    assert left.header.stamp == right.header.stamp


def refused(match: str, **right: Any) -> None:
    """A right camera with those facts is refused, and the mistake is that of its path."""
    with pytest.raises(ContextError, match=match) as mistake:
        Bench(right=right)
    assert mistake.value.value == right.get("path", RIGHT)


@pytest.mark.parametrize("changes", [{"size": (640, 480)}, {"fov_deg": (69.0, 42.0)}, {"rate": 15.0}])
def test_a_pair_whose_cameras_differ_is_refused(changes: dict[str, Any]) -> None:
    refused("differ in size, lens or rate", **changes)


@pytest.mark.parametrize(
    "turn", [rotation.from_rpy(0.0, 0.0, 0.01), rotation.from_rpy(0.01, 0.0, 0.0), rotation.from_rpy(0.0, math.pi, 0.0)]
)
def test_a_pair_whose_axes_are_not_parallel_is_refused(turn: Quaternion) -> None:
    refused("not a rectified stereo pair\nthe optical axes must be parallel", turn=rotation.multiply(turn, FORWARD))


@pytest.mark.parametrize("position", [(0.0, 0.0475, -0.095), (0.05, -0.0475, 0.0)])
def test_a_pair_one_above_or_behind_the_other_is_refused(position: Vector3) -> None:
    refused("side by side", position=position)


def test_a_pair_that_was_exchanged_is_refused() -> None:
    refused("not to the right of .*Left\nexchange the two render products", position=(0.0, 0.2, 0.0))


def test_one_camera_for_both_sides_of_a_pair_is_refused() -> None:
    with pytest.raises(ContextError, match="not to the right"):
        Bench(render_product_path_right=LEFT)


def test_a_pair_on_two_bodies_is_refused() -> None:
    refused("move relative to each other\nmount both cameras on the same body", path="/World/Camera")


# When it publishes


def test_the_calibration_is_published_with_its_image_after_the_latency_with_the_same_stamp() -> None:
    bench = Bench()
    bench.camera.latency = 2
    sent = []
    for tick in range(6):
        bench.tick(due=tick % 2 == 0)
        sent.append(len(bench.sent))
    assert sent == [0, 0, 1, 1, 2, 2]
    stamps = [info.header.stamp for info in bench.sent]
    assert stamps == [messages.stamp(1 / 60), messages.stamp(3 / 60)]


def test_image_and_calibration_have_the_same_stamp() -> None:
    bench = Bench()
    picture = ready(ROS2CameraHelper, bench.context, render_product_path=LEFT)
    bench.tick(due=True)
    bench.camera.show(np.zeros((720, 1280, 3)), time=bench.context.clock.time)
    bench.tick(due=False)
    picture.update()
    (info,), (image,) = (bench.context.transport.messages(topic) for topic in ("/camera_info", "/rgb"))
    assert info.header == image.header


def test_no_image_is_rendered_for_the_calibration() -> None:
    bench = Bench()
    bench.calibration()
    assert bench.camera.requests == 0


def test_without_subscribers_no_calibration_message_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(wanted=False)
    monkeypatch.setattr(ROS2CameraInfoHelper, "message", None)
    bench.tick(due=True)
    bench.tick(due=False)
    assert bench.sent == []


def test_frame_skip_count_skips_the_same_samples_as_for_images() -> None:
    bench = Bench(rate=20.0, frame_skip_count=2)
    for tick in range(1, 62):
        bench.camera.index = tick // 3
        bench.tick(due=tick == 1 or tick % 3 == 0)
    stamps = [info.header.stamp for info in bench.sent]
    # Samples 0, 3, 6, … of 20 a second; sample 0 belongs to the first tick.
    assert stamps == [messages.stamp(1 / 60), *(messages.stamp(9 * n / 60) for n in range(1, 7))]
    assert bench.context.services.claims[0].rate == pytest.approx(20.0 / 3)


def test_an_execution_with_enabled_false_ends_publishing_and_discards_captured_images() -> None:
    bench = Bench()
    bench.tick(due=True)
    bench.node.enabled = False
    bench.node.compute()
    assert not bench.node.active
    bench.node.enabled = True
    bench.tick(due=False)
    assert bench.sent == []


def test_a_stop_ends_publishing_and_discards_captured_images() -> None:
    bench = Bench()
    bench.tick(due=True)
    bench.context.stop(bench.node)
    assert not bench.node.active
    bench.tick(due=False)
    assert bench.sent == []


def test_stamps_without_reset_on_stop_include_the_earlier_plays() -> None:
    bench = Bench(reset_simulation_time_on_stop=False)
    bench.context.tick(60)
    bench.context.stop(bench.node)
    stamp = bench.calibration().header.stamp
    assert stamp.sec + stamp.nanosec * 1e-9 == pytest.approx(1.0 + 1 / 60, abs=1e-8)


# Where it publishes


def test_each_topics_namespace_is_collected_from_its_own_camera() -> None:
    bench = Bench(right={})
    stage = bench.context.world.stage
    stage.find("/robot").namespace = "robot_1"
    stage.find(LEFT).namespace, stage.find(RIGHT).namespace = "infra1", "infra2"
    bench.context.close()
    bench.node.setup(bench.context)
    topics = [claim.topic for claim in bench.context.services.claims]
    assert topics == ["/robot_1/infra1/camera_info", "/robot_1/infra2/camera_info_right"]


@pytest.mark.parametrize("which", ["render_product_path", "render_product_path_right"])
@pytest.mark.parametrize("path", ["/robot", "/nowhere"])
def test_a_prim_that_is_not_a_camera_is_refused_in_setup(which: str, path: str) -> None:
    inputs: dict[str, Any] = {which: path}
    with pytest.raises(PrimError):
        Bench(**inputs)


# ROS2PublishCameraInfo


def info_of(**inputs: Any) -> messages.CameraInfo:
    """The message of a node with those inputs."""
    return ready(ROS2PublishCameraInfo, RecordingContext(), **inputs).message()


def test_the_publisher_copies_its_inputs_to_the_message() -> None:
    k, r, p = np.arange(9.0), np.arange(10.0, 19.0), np.arange(20.0, 32.0)
    info = info_of(
        width=640,
        height=480,
        k=k,
        r=r,
        p=p,
        physical_distortion_model="rational_polynomial",
        physical_distortion_coefficients=[0.5, 0.25],
        projection_type="pinhole",
    )
    messages.check(info)
    assert (info.width, info.height, info.distortion_model) == (640, 480, "rational_polynomial")
    assert (info.k.tolist(), info.r.tolist(), info.p.tolist()) == (k.tolist(), r.tolist(), p.tolist())
    assert info.d.tolist() == [0.5, 0.25]


def test_without_a_distortion_model_the_projection_type_is_published_without_coefficients() -> None:
    info = info_of(projection_type="pinhole", physical_distortion_coefficients=[0.5])
    assert (info.distortion_model, info.d.tolist()) == ("pinhole", [])


def test_missing_matrices_are_zeros() -> None:
    info = info_of()
    messages.check(info)
    assert (info.k.tolist(), info.r.tolist(), info.p.tolist()) == ([0.0] * 9, [0.0] * 9, [0.0] * 12)


@pytest.mark.parametrize(("port", "count"), [("k", 9), ("r", 9), ("p", 12)])
def test_a_matrix_of_another_size_is_an_error(port: str, count: int) -> None:
    with pytest.raises(ValueError, match=f"{port} must be {count} numbers, or none"):
        info_of(**{port: np.zeros(8)})
