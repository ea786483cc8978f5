"""Images of a megabyte from embedded DDS to a reader of ROS 2, whose socket has the receive buffer that the kernel gives it."""

from __future__ import annotations

import time

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from tests.ros.contract import Join
from tests.waiting import eventually

pytestmark = pytest.mark.ros

IMAGE = "sensor_msgs/msg/Image"
COUNT = 60


@pytest.fixture
def kind() -> str:
    return "dds to rclpy"


def test_reliable_readers_get_the_images_of_a_camera(join: Join) -> None:
    arrived: list[bytes] = []
    alice, bob = join("alice"), join("bob")
    bob.reader("/image", IMAGE, QoS(), arrived.append)
    writer = alice.writer("/image", IMAGE, QoS())
    eventually(lambda: writer.matched == 1)
    image = DEFINITIONS.initial(IMAGE)
    image.width, image.height, image.step, image.encoding = 640, 480, 1920, "rgb8"
    image.data = np.random.default_rng(0).integers(0, 256, 921_600, np.uint8)
    data = messages.encode(image)
    for _ in range(COUNT):
        writer.write(data)
        time.sleep(0.1)  # 10 Hz, as cameras do
    # The history has ten: on a busy machine a reader that falls a second behind loses the oldest.
    eventually(lambda: len(arrived) >= 55)
    assert all(bytes(one[: len(data)]) == data for one in arrived)
