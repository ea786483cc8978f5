"""The drawing of a square shows every path, in any viewer."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from graphengine.bringup.calibration.figures import Calibration, Odometry, Square
from graphengine.bringup.calibration.square_picture import draw
from tests.other_process import in_another_process

SVG = "{http://www.w3.org/2000/svg}"
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 1.57), (0, 1, 3.14), (0, 0, 4.71)], float)


def result(topic: str = "/odom") -> Calibration:
    square = Square("counterclockwise", 1.0, 0.1, 0.01, CORNERS, 1.1 * CORNERS, {topic: 0.9 * CORNERS})
    return Calibration("bot", "", "", 0.3, 0.6, moves=True, squares=(square,), odometry=(Odometry(topic, ""),))


def paths(picture: str) -> list[list[list[float]]]:
    """The corners of the paths that are no grid and no legend, in pixels."""
    curves = [path.attrib["d"] for path in ET.fromstring(picture).iter(f"{SVG}path")]  # our own
    found = [curve[1:].split() for curve in curves if "h" not in curve and "v" not in curve]
    return [[list(map(float, curve[i : i + 2])) for i in range(0, len(curve), 2)] for curve in found]


def test_paths_are_drawn_to_one_scale_with_x_up_and_y_to_the_left() -> None:
    commanded, truth, odometry = paths(draw(result()))
    assert [len(commanded), len(truth), len(odometry)] == [5, 5, 5]
    up, left = commanded[0][1] - commanded[1][1], commanded[1][0] - commanded[2][0]
    assert up == pytest.approx(left, abs=0.2)
    assert up > 100
    assert truth[0][1] - truth[1][1] == pytest.approx(1.1 * up, abs=0.2)
    assert odometry[0][1] - odometry[1][1] == pytest.approx(0.9 * up, abs=0.2)


def test_a_topic_cannot_add_elements() -> None:
    texts = [text.text for text in ET.fromstring(draw(result("/a<script>"))).iter(f"{SVG}text")]  # our own
    assert "/a<script>" in texts


def test_the_same_calibration_gives_the_same_drawing_in_another_process() -> None:
    assert in_another_process(draw, result()) == draw(result())


def test_a_calibration_without_a_square_is_not_drawn() -> None:
    with pytest.raises(ValueError, match="did not drive a square path"):
        draw(Calibration("bot", "", "", 0.3, 0.6, moves=False))
