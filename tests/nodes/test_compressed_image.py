"""ROS2PublishCompressedImage."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from graphengine.messages import messages
from graphengine.nodes.ros2.compressed_image import ROS2PublishCompressedImage
from graphengine.testing import RecordingContext
from tests.nodes.harness import ready
from tests.other_process import in_another_process

TOPIC = "/image_raw/compressed"


@pytest.mark.parametrize("field", ["data", "data_ptr"])
@pytest.mark.parametrize("format", ["jpeg", "png"])
def test_compressed_bytes_are_published_unchanged(field: str, format: str, context: RecordingContext) -> None:
    file = io.BytesIO()
    Image.new("RGB", (4, 3), (255, 0, 0)).save(file, format)
    pixels = np.frombuffer(file.getvalue(), np.uint8)
    ready(ROS2PublishCompressedImage, context, format=format, **{field: pixels}).compute()
    (sent,) = context.transport.messages(TOPIC)
    assert sent.format == format
    with Image.open(io.BytesIO(bytes(sent.data))) as picture:
        assert (picture.size, picture.format) == ((4, 3), format.upper())


def test_a_video_packet_has_the_format_string_of_isaac_sim(context: RecordingContext) -> None:
    ready(ROS2PublishCompressedImage, context, data=[0, 0, 0, 1]).compute()
    assert context.transport.messages(TOPIC)[0].format == "h264"


@pytest.mark.parametrize("inputs", [{}, {"data_ptr": b""}])
def test_without_bytes_nothing_is_published(inputs: dict[str, bytes], context: RecordingContext) -> None:
    ready(ROS2PublishCompressedImage, context, **inputs).compute()
    assert context.transport.raw(TOPIC) == []


SIZES = {"rgb8": (3, "RGB"), "rgba8": (4, "RGB"), "mono8": (1, "L"), "16UC1": (2, "I;16")}
"""Bytes per pixel of each encoding, and pillow's mode of what is decoded."""


def smooth(encoding: str, width: int = 32, height: int = 24) -> NDArray[np.uint8]:
    """Rows of pixels without edges, which JPEG keeps well, as bytes."""
    ramp = np.add.outer(np.arange(height) * 3, np.arange(width) * 2)
    if encoding == "16UC1":
        return (ramp * 300).astype("<u2").view(np.uint8).ravel()
    return np.repeat(ramp.astype(np.uint8)[:, :, None], SIZES[encoding][0], axis=2).ravel()


def decoded(message: messages.CompressedImage) -> Image.Image:
    """The picture that a subscriber gets."""
    picture = Image.open(io.BytesIO(bytes(message.data)))
    picture.load()
    return picture


@pytest.mark.parametrize("encoding", SIZES)
def test_png_keeps_every_pixel(encoding: str, context: RecordingContext) -> None:
    pixels = smooth(encoding)
    inputs: dict[str, Any] = {"width": 32, "height": 24, "encoding": encoding, "format": "png", "data_ptr": pixels}
    ready(ROS2PublishCompressedImage, context, **inputs).compute()
    (sent,) = context.transport.messages(TOPIC)
    pixel_bytes, mode = SIZES[encoding]
    picture, expected = decoded(sent), pixels.view("<u2").reshape(24, 32) if encoding == "16UC1" else pixels
    assert (picture.format, picture.size, picture.mode) == ("PNG", (32, 24), mode)
    if encoding != "16UC1":
        expected = pixels.reshape(24, 32, pixel_bytes)[:, :, : min(pixel_bytes, 3)].squeeze()
    assert np.array_equal(np.asarray(picture), expected)


@pytest.mark.parametrize("encoding", ["rgb8", "rgba8", "mono8"])
def test_jpeg_is_close_to_the_pixels(encoding: str, context: RecordingContext) -> None:
    inputs: dict[str, Any] = {"width": 32, "height": 24, "encoding": encoding, "data": smooth(encoding)}
    ready(ROS2PublishCompressedImage, context, **inputs).compute()
    picture = decoded(context.transport.messages(TOPIC)[0])
    assert (picture.format, picture.size, picture.mode) == ("JPEG", (32, 24), SIZES[encoding][1])
    expected = smooth("mono8").reshape(24, 32).astype(int)
    assert np.abs(np.asarray(picture.convert("L")).astype(int) - expected).max() <= 3


@pytest.mark.parametrize(
    ("encoding", "compression", "written"),
    [
        ("rgb8", "jpeg", "rgb8; jpeg compressed bgr8"),
        ("rgba8", "png", "rgba8; png compressed bgr8"),
        ("mono8", "jpeg", "mono8; jpeg compressed "),
        ("16UC1", "png", "16UC1; png compressed "),
    ],
)
def test_the_format_string_is_that_of_image_transport(encoding: str, compression: str, written: str) -> None:
    inputs: dict[str, Any] = {
        "width": 32,
        "height": 24,
        "encoding": encoding,
        "format": compression,
        "data": smooth(encoding),
    }
    assert ready(ROS2PublishCompressedImage, RecordingContext(), **inputs).message().format == written


def noise_in_quality(quality: int) -> bytes:
    noise = np.random.default_rng(1).integers(0, 256, 32 * 24 * 3, np.uint8)
    inputs: dict[str, Any] = {"width": 32, "height": 24, "encoding": "rgb8", "data": noise}
    return bytes(ready(ROS2PublishCompressedImage, RecordingContext(), **inputs, jpeg_quality=quality).message().data)


def test_a_higher_quality_gives_more_bytes_and_equal_quality_equal_bytes() -> None:
    low, high = noise_in_quality(20), noise_in_quality(90)
    assert len(low) < len(high)
    assert in_another_process(noise_in_quality, 90) == high


@pytest.mark.parametrize(
    ("inputs", "error"),
    [
        ({"encoding": "16UC1", "format": "jpeg"}, "one of rgb8, rgba8, mono8"),
        ({"jpeg_quality": 0}, "from 1 to 100"),
        ({"jpeg_quality": 101}, "from 1 to 100"),
        ({"width": 0}, "from 1 to 65500"),
        ({"height": 65501}, "from 1 to 65500"),
        ({"height": 25}, "of 2400 bytes for 32 x 25 pixels of rgb8, it is 2304"),
    ],
)
def test_an_image_that_cannot_be_compressed_is_an_error(inputs: dict[str, Any], error: str) -> None:
    legal: dict[str, Any] = {"width": 32, "height": 24, "encoding": "rgb8", "data": smooth("rgb8")}
    node = ready(ROS2PublishCompressedImage, RecordingContext(), **{**legal, **inputs})
    with pytest.raises(ValueError, match=error):
        node.message()


def test_without_subscribers_no_image_is_compressed() -> None:
    context = RecordingContext(wanted=False)
    # It has no size: it could not be compressed.
    ready(ROS2PublishCompressedImage, context, encoding="rgb8", data=[1, 2, 3]).compute()
    assert context.transport.raw(TOPIC) == []
