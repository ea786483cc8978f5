"""Solid boxes around what a camera sees."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.devices.rotation import multiply, rotate
from tests.physics.pictures.harness import filming, needs_opengl, segmented, simulation_of

Floats = NDArray[np.float64]

PARTS = """
<geom name="floor" type="plane" size="0 0 1"/>
<geom name="wall" type="box" size=".1 1 1" pos="9 0 1"/>
<body name="crate" pos="3 .4 1.3" quat=".8 .2 .4 .4"><geom type="box" size=".3 .2 .5"/></body>
<body name="tool" pos="2 -1 1"><freejoint/>
  <geom type="box" size=".1 .2 .3" quat=".7071067811865476 0 0 .7071067811865476"/><geom size=".1" pos="1 0 0"/>
  <geom size="5" group="4"/>
</body>
<body name="ground" pos="4 0 0"><geom type="plane" size="0 0 1"/></body>
"""


def corners(box: np.void) -> Floats:
    """The eight corners in the camera's optical frame, by the meaning of the rows of the transform."""
    rows = box["transform"].astype(float)
    ends = itertools.product(*zip(box["low"].tolist(), box["high"].tolist(), strict=True))
    return np.array([np.array(end) @ rows[:3, :3] + rows[3, :3] for end in ends])


def test_every_body_that_ends_somewhere_has_a_box_around_its_shapes_along_its_own_axes() -> None:
    simulation = simulation_of(PARTS)
    studio = simulation.studio
    boxes = {
        studio.labels[int(box["semanticId"])]: box for box in studio.boxes(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    }
    assert set(boxes) == {"/World/crate", "/World/tool"}
    assert boxes["/World/crate"]["high"].tolist() == pytest.approx([0.3, 0.2, 0.5])
    assert boxes["/World/tool"]["low"].tolist() == pytest.approx([-0.2, -0.1, -0.3])
    assert boxes["/World/tool"]["high"].tolist() == pytest.approx([1.1, 0.1, 0.3])


def test_boxes_are_in_the_optical_frame_of_the_camera() -> None:
    simulation = simulation_of(PARTS)
    place, turn = (1.0, 2.0, 3.0), (0.1, 0.7, -0.1, 0.7)
    for box in simulation.studio.boxes((place, turn)):
        path = simulation.studio.labels[int(box["semanticId"])]
        position, orientation = simulation.frame(simulation.stage.find(path)).pose()
        local = itertools.product(*zip(box["low"].tolist(), box["high"].tolist(), strict=True))
        # Along z of the optical frame is -z of the camera's, and y points down.
        optical = multiply(turn, (1.0, 0.0, 0.0, 0.0))
        x, y, z, w = optical
        expected = [
            rotate((-x, -y, -z, w), tuple(np.add(position, rotate(orientation, point)) - np.array(place)))
            for point in local
        ]
        assert corners(box) == pytest.approx(np.array(expected), abs=1e-5)


@needs_opengl
def test_a_box_is_where_the_pixels_of_its_prim_are() -> None:
    simulation, camera = filming(PARTS, size=(320, 240))
    picture, crate = segmented(camera, "/World/crate")
    assert picture.boxes is not None
    fx, fy, cx, cy = camera.intrinsics
    boxes = picture.boxes
    (number,) = (number for number, path in camera.labels.items() if path == "/World/crate")
    rows, columns = np.nonzero(crate)
    x, y, z = corners(boxes[boxes["semanticId"] == number][0]).T
    across, down = cx + fx * x / z, cy + fy * y / z
    found = [columns.min(), columns.max(), rows.min(), rows.max()]
    assert found == pytest.approx([across.min(), across.max(), down.min(), down.max()], abs=2.0)
    assert camera.picture().boxes is None
    simulation.close()
