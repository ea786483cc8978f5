"""A camera of a robot, through the shipped graphs, as images and as compressed images."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.jobs.harness import Job
from tests.nodes.harness import write
from tests.physics.bases import MECANUM, MECANUM_WHEELS
from tests.physics.pictures.harness import needs_opengl

EYE = "sensors:\n  eye: {type: camera, profile: camera, parent: base_link, position: [0.2, 0, 0.5]}\n"
PARAMETERS = "camera: Geometry/base_link/eye/Camera, frame: eye, width: 64, height: 48"
SCENE = """scene: seen
world: world.xml
robots:
  bot: {use: bot.yaml, position: [0, 0, 0.05]}
graphs:
  raw:
    use: graphs/publishers/camera.yaml
    parameters: {robot: /bot, EYE}
  compressed:
    use: graphs/publishers/compressed_camera.yaml
    parameters: {robot: /bot, EYE, compression: FORMAT, info: camera/compressed_info}
"""
WALL = """<mujoco><worldbody><geom type="plane" size="0 0 1"/>
  <geom type="box" size=".1 9 9" pos="8.1 0 0" rgba="0 0 1 1"/></worldbody></mujoco>"""


@needs_opengl
@pytest.mark.parametrize(("compression", "close"), [("png", 0.0), ("jpeg", 2.0)])
def test_a_compressed_picture_is_the_picture(tmp_path: Path, compression: str, close: float) -> None:
    write(tmp_path, MECANUM.files(MECANUM_WHEELS + EYE) | {"world.xml": WALL})
    (tmp_path / "scene.yaml").write_text(SCENE.replace("EYE", PARAMETERS).replace("FORMAT", compression), "utf-8")
    with Job(tmp_path / "scene.yaml") as job:
        job.run(0.5)
        (topic,) = (name for name in job.types() if name.endswith("camera/image_raw"))
        raw, sent = job.newest(topic), job.newest(f"{topic}/compressed")
    assert (sent.header, sent.format) == (raw.header, f"rgb8; {compression} compressed bgr8")
    expected = np.frombuffer(bytes(raw.data), np.uint8).reshape(48, 64, 3).astype(int)
    with Image.open(io.BytesIO(bytes(sent.data))) as picture:
        assert np.abs(np.asarray(picture).astype(int) - expected).mean() <= close
