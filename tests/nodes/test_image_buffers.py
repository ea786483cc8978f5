"""IsaacConvertRGBAToRGB and IsaacConvertDepthToPointCloud: images of buffers and of cameras."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.devices.camera import CameraStub
from graphengine.format.errors import PrimError
from graphengine.messages import messages
from graphengine.nodes.core.image_buffers import IsaacConvertDepthToPointCloud, IsaacConvertRGBAToRGB
from graphengine.nodes.ros2.image import image
from graphengine.testing import RecordingContext
from tests.nodes.harness import ready

CAMERA = "/robot/Geometry/base_link/Camera"
INF, NAN = math.inf, math.nan
RGBA = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
RGB = [[[0, 1, 2], [4, 5, 6], [8, 9, 10]], [[12, 13, 14], [16, 17, 18], [20, 21, 22]]]
DEPTH = np.array([[1.0, INF, 2.0], [4.0, 3.0, 0.5]], np.float32)
LENS = {"focal_length": 10.4775, "horizontal_aperture": 20.955}
"""Of a camera with a field of view of 90 degrees: the focal length is half the width."""


@pytest.fixture
def camera(context: RecordingContext) -> CameraStub:
    context.world.add_robot("/robot")
    return context.world.add_device(CameraStub, CAMERA, rate=20.0, size=(3, 2))


def array(buffer: Any, dtype: str, *shape: int) -> NDArray[Any]:
    """What a reader of the buffer finds."""
    return np.frombuffer(memoryview(buffer), dtype).reshape(shape)


# Colours


@pytest.mark.parametrize("buffer", [RGBA, RGBA.tobytes(), RGBA.reshape(-1).repeat(2)[::2]])
def test_alpha_is_dropped(context: RecordingContext, buffer: Any) -> None:
    node = ready(IsaacConvertRGBAToRGB, context, data_ptr=buffer, width=3, height=2)
    assert node.compute() is IsaacConvertRGBAToRGB.exec_out
    assert array(node.data_ptr_out, "u1", 2, 3, 3).tolist() == RGB
    assert (node.width_out, node.height_out, node.encoding_out) == (3, 2, "rgb8")
    assert (node.buffer_size_out, node.cuda_device_index_out) == (18, -1)
    sent = image(messages.header(0.0, "eye"), node.encoding_out, (node.width_out, node.height_out), node.data_ptr_out)
    assert bytes(sent.data) == bytes(np.ravel(RGB).tolist())


def test_an_output_buffer_is_not_overwritten_by_the_next_execution(context: RecordingContext) -> None:
    node = ready(IsaacConvertRGBAToRGB, context, data_ptr=RGBA, width=3, height=2)
    node.compute()
    first = node.data_ptr_out
    node.data_ptr = RGBA + 100
    node.compute()
    assert array(first, "u1", 2, 3, 3).tolist() == RGB


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"encoding": "rgb8"}, "encoding must be one of rgba8"),
        ({"width": 4}, "of 32 bytes for 4 x 2 pixels, it is 24"),
        ({"width": 0}, "width, height must be above 0"),
        (
            {"data_ptr": 0},
            "dataPtr, renderProductPath must be a buffer in dataPtr or a camera path in renderProductPath",
        ),
    ],
)
def test_an_image_that_does_not_fit_is_refused_and_changes_no_output(
    context: RecordingContext, inputs: dict[str, Any], message: str
) -> None:
    node = ready(IsaacConvertRGBAToRGB, context, **{"data_ptr": RGBA, "width": 3, "height": 2, **inputs})
    with pytest.raises(ValueError, match=message):
        node.compute()
    assert (node.data_ptr_out, node.width_out, node.encoding_out) == (0, 0, "")


def test_an_image_of_a_camera_is_requested_when_due_and_output_once(
    context: RecordingContext, camera: CameraStub
) -> None:
    node = ready(IsaacConvertRGBAToRGB, context, render_product_path=CAMERA)
    assert node.compute() is None
    assert camera.requests == 0
    camera.show(RGB)
    assert node.compute() is IsaacConvertRGBAToRGB.exec_out
    assert camera.requests == 1
    assert array(node.data_ptr_out, "u1", 2, 3, 3).tolist() == RGB


def test_a_prim_that_is_not_a_camera_is_refused(context: RecordingContext, camera: CameraStub) -> None:
    with pytest.raises(PrimError, match="not a camera"):
        ready(IsaacConvertRGBAToRGB, context, render_product_path="/robot")


# Depths


def points(node: IsaacConvertDepthToPointCloud) -> NDArray[Any]:
    return array(node.data_ptr_out, "<f4", node.height_out * node.width_out, 3)


EXPECTED = [
    [1.0 * (0 - 1.5) / 1.5, 1.0 * (0 - 1.0) / 1.5, 1.0],
    [NAN, NAN, NAN],
    [2.0 * (2 - 1.5) / 1.5, 2.0 * (0 - 1.0) / 1.5, 2.0],
    [4.0 * (0 - 1.5) / 1.5, 0.0, 4.0],
    [3.0 * (1 - 1.5) / 1.5, 0.0, 3.0],
    [0.5 * (2 - 1.5) / 1.5, 0.0, 0.5],
]
"""Isaac Sim's kernel: z (column - width / 2) / fx, z (row - height / 2) / fy, z; and NaN where the depth is infinite."""


def test_depths_become_points_by_isaac_sims_formula(context: RecordingContext) -> None:
    node = ready(IsaacConvertDepthToPointCloud, context, data_ptr=DEPTH, width=3, height=2, **LENS)
    assert node.compute() is IsaacConvertDepthToPointCloud.exec_out
    np.testing.assert_allclose(points(node), EXPECTED, rtol=1e-6)
    assert (node.width_out, node.height_out, node.buffer_size_out, node.cuda_device_index_out) == (6, 1, 72, -1)


def test_depths_of_a_camera_have_its_focal_length(context: RecordingContext, camera: CameraStub) -> None:
    node = ready(IsaacConvertDepthToPointCloud, context, render_product_path=CAMERA)
    camera.show(RGB, DEPTH)
    assert node.compute() is IsaacConvertDepthToPointCloud.exec_out
    np.testing.assert_allclose(points(node), EXPECTED, rtol=1e-6)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"format": 11}, r"format must be 33 \(one float32 per pixel\)"),
        ({"height": 3}, "of 36 bytes for 3 x 3 pixels, it is 24"),
        ({"focal_length": 0.0}, "focalLength, horizontalAperture must be above 0"),
        ({"horizontal_aperture": -1.0}, "focalLength, horizontalAperture must be above 0"),
        ({"data_ptr": 0}, "must be a buffer in dataPtr or a camera path in renderProductPath"),
    ],
)
def test_depths_that_do_not_fit_are_refused_and_change_no_output(
    context: RecordingContext, inputs: dict[str, Any], message: str
) -> None:
    given = {"data_ptr": DEPTH, "width": 3, "height": 2, **LENS, **inputs}
    node = ready(IsaacConvertDepthToPointCloud, context, **given)
    with pytest.raises(ValueError, match=message):
        node.compute()
    assert (node.data_ptr_out, node.width_out, node.height_out) == (0, 0, 1)
