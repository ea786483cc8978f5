"""ROS2CameraHelper: what a camera sees as Image, PointCloud2 and boxes."""

from __future__ import annotations

import io
import json
import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from rosbags.typesys import Stores, get_typestore

from graphengine.devices.camera import BOX_3D, CameraStub
from graphengine.format.errors import ContextError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.camera import ROS2CameraHelper, organized_points
from graphengine.testing import RecordingContext
from tests.nodes.harness import HelperBench, Player, dd100, read_points, ready, vector

CAMERA = "/robot/Geometry/base_link/Camera"
INF = math.inf
SEGMENTATIONS = ("instance_segmentation", "semantic_segmentation")
TYPES = ("rgb", "depth", "depth_pcl", *SEGMENTATIONS)
COLOURS = [[[1, 2, 3], [4, 5, 6], [7, 8, 9]], [[10, 11, 12], [13, 14, 15], [16, 17, 18]]]
"""Two rows of three pixels."""
DEPTHS = [[1.0, INF, 2.0], [INF, 3.0, 4.5]]
PRIMS = [[0, 1, 1], [2, 2, 0]]

every_type = pytest.mark.parametrize("kind", TYPES)
every_segmentation = pytest.mark.parametrize("kind", SEGMENTATIONS)


class Bench(HelperBench):
    """A camera of 3 x 2 pixels and 90 degrees, and a helper on it."""

    def __init__(self, kind: str = "rgb", *, wanted: bool = True, rate: float = 30.0, **inputs: Any) -> None:
        self.context = RecordingContext(wanted=wanted)
        self.context.world.add_robot("/robot")
        self.camera = self.context.world.add_device(CameraStub, CAMERA, rate=rate, size=(3, 2), fov_deg=(90.0, 67.4))
        self.camera.labels = {1: "/World/shelf", 2: "/World/crate"}
        inputs = {"type_in": kind, "render_product_path": CAMERA, **inputs}
        self.node = ready(ROS2CameraHelper, self.context, **inputs)

    def deliver(self, index: int = 0, captured: float = 0.0, boxes: Any = None) -> list[Any]:
        """What is published in a tick in which that picture is delivered, once the helper was executed."""
        self.camera.show(COLOURS, DEPTHS, PRIMS, boxes, time=captured, index=index)
        self.context.tick()
        return self.executed()


# Images


def test_colours_are_rows_of_rgb8_from_the_upper_edge() -> None:
    (picture,) = Bench().deliver()
    assert (picture.width, picture.height, picture.encoding, picture.step) == (3, 2, "rgb8", 9)
    assert picture.is_bigendian == 0
    assert bytes(picture.data) == bytes(range(1, 19))


@pytest.mark.parametrize(("compression", "close"), [("png", 0), ("jpeg", 16)])
def test_compressed_colours_have_the_stamp_and_frame_of_the_picture(compression: str, close: int) -> None:
    bench = Bench(compression=compression, jpeg_quality=100)
    (sent,) = bench.deliver(captured=0.5)
    assert bench.context.services.claims[0].message_type == "sensor_msgs/msg/CompressedImage"
    assert (sent.header.frame_id, sent.header.stamp.nanosec) == ("sim_camera", 500_000_000)
    assert sent.format == f"rgb8; {compression} compressed bgr8"
    with Image.open(io.BytesIO(bytes(sent.data))) as picture:
        assert picture.format == compression.upper()
        assert np.abs(np.asarray(picture).astype(int) - COLOURS).max() <= close


@pytest.mark.parametrize("kind", ["depth", "depth_pcl", *SEGMENTATIONS])
def test_only_colours_can_be_compressed(kind: str) -> None:
    with pytest.raises(ContextError, match=f"images of type '{kind}' cannot be compressed"):
        Bench(kind, compression="png")


def test_depth_is_metres_in_single_precision_and_inf_where_nothing_was_seen() -> None:
    (picture,) = Bench("depth").deliver()
    assert (picture.width, picture.height, picture.encoding, picture.step) == (3, 2, "32FC1", 12)
    assert struct.unpack("<6f", bytes(picture.data)) == (1.0, INF, 2.0, INF, 3.0, 4.5)


@every_segmentation
def test_a_segmentation_image_has_the_id_of_the_prim_at_each_pixel(kind: str) -> None:
    (picture,) = Bench(kind).deliver()
    assert (picture.width, picture.height, picture.encoding, picture.step) == (3, 2, "32SC1", 12)
    assert struct.unpack("<6i", bytes(picture.data)) == (0, 1, 1, 2, 2, 0)


def test_tight_boxes_are_around_the_pixels_of_each_prim() -> None:
    bench = Bench("bbox_2d_tight")
    (seen,) = bench.deliver(captured=0.5)
    (claim,) = bench.context.services.claims
    assert claim.message_type == "vision_msgs/msg/Detection2DArray"
    assert (seen.header.frame_id, seen.header.stamp.nanosec) == ("sim_camera", 500_000_000)
    boxes = [(box.results[0].hypothesis.class_id, box.bbox) for box in seen.detections]
    assert [name for name, _ in boxes] == ["1", "2"]
    # PRIMS: number 1 has the pixels 1 and 2 of the first row, number 2 the pixels 0 and 1 of the second.
    centres = [(box.center.position.x, box.center.position.y) for _, box in boxes]
    assert centres == [(2.0, 0.5), (1.0, 1.5)]
    assert [(box.size_x, box.size_y) for _, box in boxes] == [(2.0, 1.0), (2.0, 1.0)]


def test_loose_boxes_enclose_the_whole_prims_that_have_a_visible_pixel() -> None:
    bench = Bench("bbox_2d_loose")
    boxes = np.zeros(2, BOX_3D)
    boxes["semanticId"], boxes["low"], boxes["high"] = (3, 1), [-0.5, -0.5, 0.0], [0.5, 0.5, 4.0]
    boxes["transform"] = np.eye(4)
    boxes["transform"][:, 3, :3] = [0.0, 0.0, 2.0]
    ((detection,),) = (message.detections for message in bench.deliver(boxes=boxes))
    box = detection.bbox
    # Half a metre at 2 m is a quarter of the focal length, 3/8 of a pixel: from the picture's middle, 3/8 into two rows' pixels.
    assert (box.center.position.x, box.center.position.y, box.size_x, box.size_y) == (1.5, 1.0, 1.0, 2.0)
    assert detection.results[0].hypothesis.class_id == "1"


def test_3d_boxes_are_published_for_prims_that_have_a_visible_pixel() -> None:
    bench = Bench("bbox_3d")
    boxes = np.zeros(3, BOX_3D)
    boxes["semanticId"], boxes["low"], boxes["high"] = (3, 2, 1), [-1.0, -1.0, 0.0], [1.0, 1.0, 4.0]
    boxes["transform"] = np.eye(4)
    boxes["transform"][:, 3, :3] = [[0.0, 0.0, 9.0], [0.0, 0.5, 7.0], [0.5, 0.0, 5.0]]
    (seen,) = bench.deliver(captured=0.5, boxes=boxes)
    assert bench.context.services.claims[0].message_type == "vision_msgs/msg/Detection3DArray"
    assert (seen.header.frame_id, seen.header.stamp.nanosec) == ("sim_camera", 500_000_000)
    found = [(box.results[0].hypothesis.class_id, vector(box.bbox.center.position)) for box in seen.detections]
    assert found == [("2", (0.0, 0.5, 9.0)), ("1", (0.5, 0.0, 7.0))]
    assert [vector(box.bbox.size) for box in seen.detections] == [(2.0, 2.0, 4.0)] * 2


@every_type
def test_messages_have_the_selected_type_and_rosbags_decodes_them(kind: str) -> None:
    bench = Bench(kind)
    bench.deliver()
    (claim,) = bench.context.services.claims
    (data,) = bench.context.transport.raw(claim.topic)
    read: Any = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, claim.message_type)
    messages.check(messages.decode(data, claim.message_type))
    assert read.header.frame_id == claim.frame_id == "sim_camera"
    assert len(read.data) == (read.row_step if kind == "depth_pcl" else read.step * read.height)


def test_pixels_are_not_copied_on_their_way_into_the_message() -> None:
    bench = Bench()
    bench.deliver()
    picture: Any = bench.camera.delivered()
    message = bench.node.message(messages.header(0.0, ""), picture)
    assert np.shares_memory(message.data, picture.rgb)


def test_images_that_are_not_contiguous_are_published_row_by_row() -> None:
    bench = Bench()
    bench.deliver()
    picture: Any = bench.camera.delivered()
    upside_down = type(picture)(0.0, 0, picture.rgb[::-1], picture.depth[::-1])
    message = bench.node.message(messages.header(0.0, ""), upside_down)
    assert bytes(message.data) == bytes([*range(10, 19), *range(1, 10)])


# Points


def test_a_cloud_has_one_point_for_each_pixel_with_a_surface() -> None:
    (cloud,) = Bench("depth_pcl").deliver()
    points = read_points(cloud)
    # 90 degrees over three pixels: fx = 1.5, and the axis meets the middle of the picture at (1, 0.5).
    seen = [(0, 0, 1.0), (2, 0, 2.0), (1, 1, 3.0), (2, 1, 4.5)]
    assert points["x"] == pytest.approx([z * (u - 1.0) / 1.5 for u, v, z in seen])
    assert points["y"] == pytest.approx([z * (v - 0.5) / 1.5 for u, v, z in seen])
    assert points["z"] == [1.0, 2.0, 3.0, 4.5]
    assert (cloud.height, cloud.width, cloud.is_dense, cloud.header.frame_id) == (1, 4, True, "sim_camera")


@pytest.mark.parametrize(("depths", "dense"), [(DEPTHS, False), ([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], True)])
def test_an_organized_cloud_has_a_point_for_each_pixel_and_says_whether_all_are_finite(
    depths: list[list[float]], dense: bool
) -> None:
    bench = Bench("depth_pcl", organized=True, colored=True)
    bench.camera.show(COLOURS, depths, PRIMS, None, time=0.0, index=0)
    bench.context.tick()
    (cloud,) = bench.executed()
    assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (2, 3, 16, 48)
    assert cloud.is_dense is dense
    points = read_points(cloud)
    z = np.array(depths).ravel()
    seen = np.isfinite(z)
    assert np.array_equal(np.isnan(points["x"]), ~seen)
    assert np.array_equal(np.array(points["z"])[seen], z[seen])
    assert np.array(points["x"])[seen] == pytest.approx(z[seen] * np.tile([-1.0, 0.0, 1.0], 2)[seen] / 1.5)
    assert np.array(points["rgb"], "<f4").view("<u4").tolist() == [
        red << 16 | green << 8 | blue for row in COLOURS for red, green, blue in row
    ]


def test_a_coloured_cloud_in_one_row_has_the_colours_of_the_pixels_with_a_surface() -> None:
    (cloud,) = Bench("depth_pcl", colored=True).deliver()
    assert (cloud.height, cloud.width, cloud.is_dense) == (1, 4, True)
    blue = np.array(read_points(cloud)["rgb"], "<f4").view("<u4") & 0xFF
    assert blue.tolist() == [3, 9, 15, 18]


@given(
    size=st.tuples(st.integers(1, 7), st.integers(1, 7)),
    lens=st.tuples(st.floats(1.0, 1e4), st.floats(1.0, 1e4), st.floats(-5.0, 10.0), st.floats(-5.0, 10.0)),
    seed=st.integers(0, 2**32 - 1),
)
def test_each_point_is_projected_back_onto_its_pixel(
    size: tuple[int, int], lens: tuple[float, float, float, float], seed: int
) -> None:
    random = np.random.default_rng(seed)
    depth = np.where(random.random(size) < 0.3, INF, random.uniform(0.1, 50.0, size)).astype(np.float32)
    fx, fy, cx, cy = lens
    rows, columns = np.nonzero(np.isfinite(depth))
    points = organized_points(depth, lens)
    assert np.array_equal(np.isnan(points).all(axis=-1), ~np.isfinite(depth))
    x, y, z = points[rows, columns].astype(float).T
    assert np.array_equal(z, depth[rows, columns])
    assert np.allclose(fx * x / z + cx, columns, atol=1e-5)
    assert np.allclose(fy * y / z + cy, rows, atol=1e-5)


def test_an_image_without_surfaces_gives_an_empty_cloud() -> None:
    bench = Bench("depth_pcl")
    bench.camera.show(COLOURS, np.full((2, 3), INF), PRIMS, None, time=0.0, index=0)
    bench.context.tick()
    (cloud,) = bench.executed()
    assert (cloud.height, cloud.width, len(cloud.data), cloud.is_dense) == (1, 0, 0, True)


def test_points_follow_the_lens_of_the_current_camera_of_the_render_product(context: RecordingContext) -> None:
    context.world.add_device(CameraStub, "/wide", size=(3, 2), fov_deg=(90.0, 67.4))
    context.world.add_device(CameraStub, "/narrow", size=(3, 2), fov_deg=(45.0, 30.0))
    path = context.render_product("/wide", 3, 2)
    node = ready(ROS2CameraHelper, context, render_product_path=path, type_in="depth_pcl", topic_name="points")
    context.exchange_camera(path, "/narrow")()
    context.world.device(CameraStub, context.world.stage.find("/narrow"), size=(3, 2)).show(COLOURS, depth=1.0)
    node.update()
    (cloud,) = context.transport.messages("/points")
    assert read_points(cloud)["x"][0] == pytest.approx(-1.0 / (1.5 / math.tan(math.radians(22.5))))


# Labels


@every_segmentation
def test_the_labels_message_maps_each_segmentation_id_to_its_prim(kind: str) -> None:
    bench = Bench(kind, enable_semantic_labels=True, semantic_labels_topic_name="names")
    bench.deliver(captured=1.25)
    (text,) = bench.context.transport.messages("/names")
    assert json.loads(text.data) == {
        "0": {"class": "BACKGROUND"},
        "1": {"class": "/World/shelf"},
        "2": {"class": "/World/crate"},
        "time_stamp": {"sec": 1, "nanosec": 250_000_000},
    }


def test_labels_and_image_have_the_same_stamp() -> None:
    bench = Bench(SEGMENTATIONS[0], enable_semantic_labels=True)
    (picture,) = bench.deliver(captured=1 / 30)
    (text,) = bench.context.transport.messages("/semantic_labels")
    stamp = json.loads(text.data)["time_stamp"]
    assert (stamp["sec"], stamp["nanosec"]) == (picture.header.stamp.sec, picture.header.stamp.nanosec)


def test_with_subscribers_only_for_labels_only_labels_are_published() -> None:
    bench = Bench(SEGMENTATIONS[0], wanted=False, enable_semantic_labels=True)
    heard: list[bytes] = []
    bench.context.transport.reader("/semantic_labels", "std_msgs/msg/String", QoS(), heard.append)
    assert bench.deliver() == []
    assert len(heard) == 1


def test_without_labels_the_labels_topic_does_not_exist() -> None:
    assert len(Bench(SEGMENTATIONS[0]).context.services.claims) == 1


@pytest.mark.parametrize("kind", ["rgb", "depth", "depth_pcl"])
def test_labels_for_images_without_segmentation_log_that_they_have_no_effect(kind: str) -> None:
    context = Bench(kind, enable_semantic_labels=True).context
    assert [severity for severity, _ in context.logged] == ["warning"]
    assert len(context.services.claims) == 1


# What is asked of the camera


class Asked:
    """Notes what a helper asks a camera for."""

    def __init__(self, bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
        self.segmentations: list[bool] = []
        monkeypatch.setattr(bench.camera, "request", self.request)

    def request(self, *, segmentation: bool = False) -> None:
        self.segmentations.append(segmentation)


@every_type
def test_a_segmentation_is_requested_only_for_types_that_publish_it(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(kind)
    asked = Asked(bench, monkeypatch)
    bench.deliver()
    assert asked.segmentations == [kind in SEGMENTATIONS]


def test_between_two_samples_no_image_is_requested_but_a_delivered_image_is_published() -> None:
    bench = Bench()
    bench.camera.show(COLOURS)
    bench.camera.due = False
    bench.node.update()
    assert (bench.camera.requests, len(bench.sent)) == (0, 1)


def test_before_a_picture_is_delivered_nothing_is_published() -> None:
    bench = Bench()
    bench.camera.due = True
    bench.node.update()
    assert (bench.camera.requests, bench.sent) == (1, [])


@every_segmentation
def test_an_image_requested_by_another_helper_without_segmentation_is_not_published(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = Bench(kind)
    bench.camera.show(COLOURS)
    picture: Any = bench.camera.delivered()
    without = type(picture)(picture.time, picture.index, picture.rgb, picture.depth)
    monkeypatch.setattr(bench.camera, "delivered", lambda: without)
    bench.node.update()
    assert bench.sent == []


# When it publishes


@every_type
def test_the_stamp_is_the_time_of_the_capture_and_not_of_the_delivery(kind: str) -> None:
    bench = Bench(kind)
    bench.context.tick(60)
    (message,) = bench.deliver(captured=0.75)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (0, 750_000_000)


# Where it publishes


def test_namespaces_are_collected_from_the_cameras_prim_for_both_topics() -> None:
    context = RecordingContext("/World/elsewhere/Helper")
    context.world.add_robot("/robot")
    context.world.add_device(CameraStub, CAMERA)
    context.world.stage.find("/robot/base_link").namespace = "robot_1"
    context.world.stage.find(CAMERA).namespace = "front"
    inputs = {"render_product_path": CAMERA, "type_in": SEGMENTATIONS[1], "enable_semantic_labels": True}
    ready(ROS2CameraHelper, context, topic_name="seen", **inputs)
    ready(ROS2CameraHelper, context, node_namespace="given", **inputs)
    assert [claim.topic for claim in context.services.claims] == [
        "/robot_1/front/seen",
        "/robot_1/front/semantic_labels",
        "/given/rgb",
        "/given/semantic_labels",
    ]


@every_type
def test_the_type_selects_the_message_and_the_rate_is_the_cameras(kind: str) -> None:
    (claim,) = Bench(kind, rate=12.5, queue_size=3, context=8).context.services.claims
    name = "PointCloud2" if kind == "depth_pcl" else "Image"
    assert (claim.message_type, claim.rate, claim.qos) == (f"sensor_msgs/msg/{name}", 12.5, QoS(depth=3))
    assert claim.ros_context == 8


def test_the_error_of_an_unavailable_type_lists_the_available_types() -> None:
    with pytest.raises(ContextError, match=r"'rgb_h264' are not available\n.*rgb, depth, depth_pcl") as refused:
        Bench("rgb_h264")
    assert refused.value.value == "rgb_h264"


def test_an_unknown_type_is_refused() -> None:
    with pytest.raises(ValueError, match="one of rgb"):
        Bench("camera_info")


# In the graph that ships


def test_the_shipped_graph_publishes_colours_depth_and_calibration_with_one_stamp_and_the_cameras_place(
    play: Player,
) -> None:
    world = dd100()
    path = "/dd100/Geometry/base_link/chassis_link/sim_camera/RSD455/Camera_OmniVision_OV9782_Color"
    world.add_device(CameraStub, path, fov_deg=(90.0, 64.0))
    camera = world.device(CameraStub, world.stage.find(path), size=(640, 400))
    camera.show(np.zeros((400, 640, 3)), depth=2.0, time=1 / 60)
    playing = play.shipped("camera", world).tick(2)
    root = "/dd100_0000/sim_camera"
    colour, depth, info = (playing.published(f"{root}/{name}")[0] for name in ("rgb", "depth", "camera_info"))
    assert colour.header == depth.header == info.header
    assert colour.header.frame_id == "Camera_OmniVision_OV9782_Color"
    assert (colour.width, colour.height, info.width, info.height) == (640, 400, 640, 400)
    (tree,) = playing.published("/dd100_0000/tf_static")
    assert [(t.header.frame_id, t.child_frame_id) for t in tree.transforms] == [("base_link", colour.header.frame_id)]
