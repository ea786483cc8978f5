"""A few lines on messages with many values, whatever a stranger's message says of itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.message_input import parse
from graphengine.messages.message_summary import BARS, PICTURE_WIDTH, sparkline, summarize

HEADER = "header: {stamp: {sec: 12, nanosec: 345000000}, frame_id: lidar}"
UNREADABLE = "  values not shown: an unknown encoding, or data of another size"


def make(kind: str, text: str = "", **fields: Any) -> Any:
    message = parse(f"{{{HEADER}, {text}}}", f"sensor_msgs/msg/{kind}", DEFINITIONS).stamp(0)
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def summary(message: Any, width: int = 80, *, picture: bool = True) -> list[str]:
    text = summarize(message, width, picture=picture)
    assert text is not None
    return text.split("\n")


# Scans


def make_scan(*ranges: float, intensities: tuple[float, ...] = ()) -> Any:
    text = "angle_min: -1.5707963, angle_max: 1.5707963, range_min: 0.1, range_max: 25.0, scan_time: 0.05"
    values = np.array(ranges, np.float32), np.array(intensities, np.float32)
    return make("LaserScan", text, ranges=values[0], intensities=values[1])


def test_a_scan_is_summarized_by_beams_extent_and_a_line_of_bars() -> None:
    nan, inf = math.nan, math.inf
    assert summary(make_scan(1.0, 2.0, inf, 8.0, nan, 4.0, 0.05, 30.0, intensities=(5.0, 200.0))) == [
        "LaserScan of frame 'lidar' at 12.345 s",
        "  8 beams from -90.0 to 90.0 deg, 20 Hz, can measure 0.1 to 25 m",
        "  ranges 1 to 8 m, 4 without return",
        "  intensities 5 to 200",
        "  -90.0 deg ▂▃ █ ▅   90.0 deg",
    ]


def test_a_scan_without_any_return_has_no_bars() -> None:
    assert summary(make_scan(math.inf, math.inf))[2:] == ["  no return"]
    assert summary(make_scan())[1:] == [
        "  0 beams from -90.0 to 90.0 deg, 20 Hz, can measure 0.1 to 25 m",
        "  no return",
    ]


def test_each_bar_shows_the_nearest_of_its_beams() -> None:
    values = np.full(1000, 8.0)
    values[500] = 1.0
    line = sparkline(values, 10)
    assert line == "█████▂████"


@given(st.lists(st.floats(0.0, 1e6) | st.sampled_from([math.nan, math.inf]), max_size=50), st.integers(-3, 80))
def test_a_sparkline_is_never_too_wide_and_has_higher_bars_for_greater_values(values: list[float], width: int) -> None:
    line = sparkline(np.array(values), width)
    assert len(line) == max(0, min(width, len(values)))
    if len(line) == len(values):
        assert [bar == " " for bar in line] == [not math.isfinite(value) for value in values]
        bars = [(value, BARS.index(bar)) for value, bar in zip(values, line, strict=True) if bar != " "]
        assert [index for _, index in sorted(bars)] == sorted(index for _, index in bars)


# Images


def make_image(pixels: NDArray[Any], encoding: str, **fields: Any) -> Any:
    data = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
    height, width = pixels.shape[:2]
    return make(
        "Image",
        **{"height": height, "width": width, "encoding": encoding, "step": len(data) // height, "data": data} | fields,
    )


def test_an_image_is_summarized_by_size_encoding_and_extent_of_each_channel() -> None:
    pixels = np.zeros((2, 4, 3), np.uint8)
    pixels[0, 0] = 10, 20, 40
    assert summary(make_image(pixels, "bgr8"), picture=False) == [
        "Image of frame 'lidar' at 12.345 s",
        "  4 x 2, bgr8, 24 bytes",
        "  blue 0 to 10, mean 1.25; green 0 to 20, mean 2.5; red 0 to 40, mean 5",
    ]


def test_the_summary_of_a_depth_image_counts_values_that_are_not_finite() -> None:
    pixels = np.array([[1.0, 2.0], [np.inf, np.nan]], np.float32)
    assert summary(make_image(pixels, "32FC1"), picture=False)[2] == "  1 to 2, mean 1.5, 2 not finite"


@pytest.mark.parametrize("order", ["<", ">"])
def test_big_endian_images_are_read_in_their_byte_order(order: str) -> None:
    pixels = np.array([[1, 256], [513, 2]], f"{order}u2")
    assert summary(make_image(pixels, "16UC1", is_bigendian=order == ">"))[2].startswith("  1 to 513, mean 193")


def test_padding_at_the_end_of_rows_is_ignored() -> None:
    pixels = np.full((2, 4), 99, np.uint8)
    pixels[:, :3] = 5
    assert summary(make_image(pixels, "mono8", width=3))[2] == "  5 to 5, mean 5"


def test_bright_pixels_of_a_picture_are_drawn_as_full_blocks() -> None:
    pixels = np.zeros((40, 80), np.uint8)
    pixels[:, 40:] = 255
    *_, first, last = summary(make_image(pixels, "mono8"))
    assert first == last == "  " + " " * 32 + "█" * 32
    assert len(summary(make_image(pixels, "mono8"))) == 3 + 16
    assert max(map(len, summary(make_image(pixels, "mono8"), 20)[3:])) == 20


@pytest.mark.parametrize(
    "fields", [{"encoding": "bayer_rggb8"}, {"encoding": "8FC1"}, {"height": 3}, {"step": 1}, {"width": 2**32 - 1}]
)
def test_an_unreadable_image_is_summarized_by_its_size(fields: dict[str, Any]) -> None:
    lines = summary(make_image(np.zeros((2, 4), np.uint8), **{"encoding": "mono8"} | fields))
    assert lines[2:] == [UNREADABLE]


@given(
    st.sampled_from(["rgb8", "bgra16", "mono16", "32FC1", "64FC4", "8SC3", "16SC", "jpeg", ""]),
    *[st.integers(0, 5) | st.integers(0, 2**32 - 1)] * 3,
    st.binary(max_size=200),
    st.integers(0, 100),
)
def test_no_malformed_image_raises_an_error(
    encoding: str, height: int, width: int, step: int, data: bytes, columns: int
) -> None:
    values: dict[str, Any] = {"encoding": encoding, "height": height, "width": width, "step": step}
    lines = summary(make("Image", **values, data=np.frombuffer(data, np.uint8)), columns)
    assert all(len(line) <= max(columns, 2) for line in lines[3:])
    assert len(lines) < 5 * PICTURE_WIDTH


# Clouds


def make_cloud(points: NDArray[Any], **fields: Any) -> Any:
    text = "fields: [{name: x, offset: 0, datatype: 7, count: 1}, {name: y, offset: 4, datatype: 7, count: 1}, \
{name: ring, offset: 8, datatype: 2, count: 1}]"
    rows = {"height": 1, "width": len(points), "point_step": 12, "row_step": 12 * len(points)}
    return make("PointCloud2", text, **rows | {"data": points.view(np.uint8).reshape(-1)} | fields)


POINTS = np.array(
    [(1.0, -2.0, 3, b""), (np.nan, 0.0, 0, b""), (4.0, 0.5, 7, b"")],
    [("x", "f4"), ("y", "f4"), ("ring", "u1"), ("rest", "S3")],
)


def test_a_cloud_is_summarized_by_its_number_of_points_and_the_extent_of_each_field() -> None:
    assert summary(make_cloud(POINTS)) == [
        "PointCloud2 of frame 'lidar' at 12.345 s",
        "  3 points (3 x 1) of 12 bytes: x, y, ring",
        "  x 1 to 4, y -2 to 0.5, ring 3 to 7",
        "  without finite values: 1",
    ]


@pytest.mark.parametrize("fields", [{"height": 2}, {"point_step": 2}, {"width": 2**32 - 1}, {"row_step": 0}])
def test_an_unreadable_cloud_is_summarized_by_its_size(fields: dict[str, Any]) -> None:
    assert summary(make_cloud(POINTS, **fields))[2:] == [UNREADABLE]


@given(*[st.integers(0, 5) | st.integers(0, 2**32 - 1)] * 4, st.binary(max_size=100), st.booleans())
def test_no_malformed_cloud_raises_an_error(
    height: int, width: int, step: int, row: int, data: bytes, big: bool
) -> None:
    sizes = {"height": height, "width": width, "point_step": step, "row_step": row, "is_bigendian": big}
    assert len(summary(make_cloud(POINTS, **sizes, data=np.frombuffer(data, np.uint8)))) >= 3


def test_other_messages_have_no_summary() -> None:
    assert summarize(parse("{data: hello}", "std_msgs/msg/String", DEFINITIONS).stamp(0), 80) is None
