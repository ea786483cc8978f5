"""ROS2PublishCompressedImage."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from graphengine.nodes.ros2.compressed_image import ROS2PublishCompressedImage
from graphengine.testing import RecordingContext
from tests.nodes.harness import ready

TOPIC = "/image_raw/compressed"


@pytest.mark.parametrize("field", ["data", "data_ptr"])
@pytest.mark.parametrize("format", ["jpeg", "png"])
def test_a_picture_goes_out_as_it_was_compressed(field: str, format: str, context: RecordingContext) -> None:
    file = io.BytesIO()
    Image.new("RGB", (4, 3), (255, 0, 0)).save(file, format)
    pixels = np.frombuffer(file.getvalue(), np.uint8)
    ready(ROS2PublishCompressedImage, context, format=format, **{field: pixels}).compute()
    (sent,) = context.transport.messages(TOPIC)
    assert sent.format == format
    with Image.open(io.BytesIO(bytes(sent.data))) as picture:
        assert (picture.size, picture.format) == ((4, 3), format.upper())


def test_film_is_told_as_the_reference_tells_it(context: RecordingContext) -> None:
    ready(ROS2PublishCompressedImage, context, data=[0, 0, 0, 1]).compute()
    assert context.transport.messages(TOPIC)[0].format == "h264"


@pytest.mark.parametrize("inputs", [{}, {"data_ptr": b""}])
def test_without_bytes_nothing_goes_out(inputs: dict[str, bytes], context: RecordingContext) -> None:
    ready(ROS2PublishCompressedImage, context, **inputs).compute()
    assert context.transport.raw(TOPIC) == []
