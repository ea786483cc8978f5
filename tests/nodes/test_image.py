"""ROS2PublishImage: pixels from arrays and buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graphengine.compiler.registry import Registry, default_registry
from graphengine.format.errors import NodeError
from graphengine.messages import messages
from graphengine.node import Buffer, Node, Out
from graphengine.nodes.ros2.image import ROS2PublishImage
from graphengine.scene.loaded_scene import Options
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready

ENCODINGS = {"rgb8": 3, "rgba8": 4, "32FC1": 4, "32SC1": 4}
"""Bytes of a pixel, from the names: three or four channels of 8 bits, one of 32."""

every_encoding = pytest.mark.parametrize("encoding", ENCODINGS)


def pixels(count: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """That many bytes, no two neighbours alike."""
    return (np.arange(count) % 251).astype(np.uint8)


def image_of(**inputs: Any) -> messages.Image:
    """The message of a node with those inputs."""
    return ready(ROS2PublishImage, RecordingContext(), **inputs).message()


@every_encoding
def test_the_step_of_an_image_is_the_number_of_bytes_of_a_row(encoding: str) -> None:
    data = pixels(5 * 3 * ENCODINGS[encoding])
    picture = image_of(width=5, height=3, encoding=encoding, data=data)
    messages.check(picture)
    assert (picture.width, picture.height, picture.encoding) == (5, 3, encoding)
    assert (picture.step, picture.is_bigendian) == (5 * ENCODINGS[encoding], 0)
    assert bytes(picture.data) == bytes(data)


@pytest.mark.parametrize(
    "buffer", [bytes(range(24)), bytearray(range(24)), np.arange(24, dtype=np.uint8).reshape(2, 4, 3)]
)
def test_pixels_may_come_as_a_buffer(buffer: Any) -> None:
    picture = image_of(width=4, height=2, data_ptr=buffer)
    messages.check(picture)
    assert bytes(picture.data) == bytes(range(24))


def test_the_bytes_of_a_buffer_of_numbers_are_published() -> None:
    depth = np.array([[1.0, np.inf], [0.5, 2.0]], np.float32)
    picture = image_of(width=2, height=2, encoding="32FC1", data_ptr=depth)
    assert np.frombuffer(bytes(picture.data), "<f4").tolist() == [1.0, np.inf, 0.5, 2.0]


@pytest.mark.parametrize("port", ["data", "data_ptr"])
def test_a_buffer_need_not_be_contiguous(port: str) -> None:
    cls: Any = ROS2PublishImage
    node = ready(cls, RecordingContext(), width=2, height=2)
    setattr(node, port, pixels(24)[::2])
    assert bytes(node.message().data) == bytes(range(0, 24, 2))


def test_pixels_are_not_copied_into_the_message() -> None:
    data = pixels(12)
    assert np.shares_memory(image_of(width=2, height=2, data_ptr=data).data, data)


def test_an_array_takes_precedence_over_a_buffer() -> None:
    picture = image_of(width=1, height=1, data=[1, 2, 3], data_ptr=b"abc")
    assert bytes(picture.data) == b"\x01\x02\x03"


@every_encoding
@pytest.mark.parametrize("difference", [-1, 1])
def test_a_number_of_bytes_that_does_not_fit_the_size_is_an_error(encoding: str, difference: int) -> None:
    count = 4 * 3 * ENCODINGS[encoding]
    with pytest.raises(
        ValueError, match=f"of {count} bytes for 4 x 3 pixels of {encoding}, it is {count + difference}"
    ):
        image_of(width=4, height=3, encoding=encoding, data=pixels(count + difference))


def test_an_unknown_encoding_is_refused() -> None:
    with pytest.raises(ValueError, match="one of rgb8, rgba8, 32FC1, 32SC1"):
        image_of(encoding="bgr8")


@pytest.mark.parametrize("address", [140_000, "pixels", 1.5, True])
def test_a_pointer_literal_other_than_0_is_refused(address: Any) -> None:
    with pytest.raises(TypeError, match="only a wire can provide a buffer"):
        image_of(data_ptr=address)


def test_in_a_graph_a_wrong_size_stops_the_run_and_names_the_node(play: Player) -> None:
    text = """
        nodes: {Tick: OnPlaybackTick, Publish: {type: PublishImage, inputs: {width: 2, height: 2, data: [1, 2, 3]}}}
        connections: [Tick.tick -> Publish.execIn]
        """
    with pytest.raises(NodeError, match=r"Publish[^\n]*of 12 bytes for 2 x 2 pixels of rgb8, it is 3"):
        play.graph(text).tick()


class Drawn(Node, type="tests.Drawn", volatile=True):
    """Two pixels that somebody drew."""

    data_ptr: Buffer = Out()

    def compute(self) -> None:
        self.data_ptr = np.array([[[1, 2, 3], [4, 5, 6]]], np.uint8)


def test_in_a_graph_a_wire_between_pointers_carries_the_buffer(play: Player) -> None:
    known = default_registry()
    registry = Registry(dict(known.types), dict(known.short_names), dict(known.owners))
    registry.add(Drawn)
    text = """
        nodes: {Tick: OnPlaybackTick, Drawn: tests.Drawn, Publish: {type: PublishImage, inputs: {width: 2, height: 1}}}
        connections: [Tick.tick -> Publish.execIn, Drawn.dataPtr -> Publish.dataPtr]
        """
    playing = play.graph(text, options=Options(registry=registry)).tick()
    (picture,) = playing.published("/rgb")
    assert bytes(picture.data) == bytes(range(1, 7))
