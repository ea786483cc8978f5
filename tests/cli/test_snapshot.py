"""`graphrun snapshot`: pictures of the tutorial's views, read back by Pillow."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from graphengine.physics.pictures import opengl
from tests.cli.harness import Graphrun
from tests.physics.pictures.harness import needs_opengl, take_opengl_away

COLOUR, DEPTH = "Camera_OmniVision_OV9782_Color", "Camera_Pseudo_Depth"
SCENE = "dd100_flat"


def pixels(path: Path) -> NDArray[np.int64]:
    with Image.open(path) as picture:
        assert picture.format == "PNG"
        return np.array(picture).astype(np.int64)


@needs_opengl
@pytest.mark.parametrize("camera", ["top", "perspective"])
def test_a_view_shows_the_robot_in_its_colours(graphrun: Graphrun, project: Path, camera: str) -> None:
    result = graphrun("snapshot", SCENE, "--camera", camera, "--size", "160x90", "-o", "picture.png", code=0, out="")
    assert result.err.splitlines()[-1] == f"picture.png: {camera} at t = 0 s, 160 x 90"
    picture = pixels(project / "picture.png")
    assert picture.shape == (90, 160, 3)
    yellow = (picture[..., 0] > 150) & (picture[..., 1] > 120) & (picture[..., 2] < 80)
    assert yellow.sum() > 5
    assert sorted(path.name for path in project.iterdir()) == ["mine.yaml", "picture.png"]


@needs_opengl
def test_a_picture_of_a_named_camera_has_the_size_of_the_camera(graphrun: Graphrun, project: Path) -> None:
    path = f"/dd100/base_link/chassis_link/sim_camera/RSD455/{COLOUR}"
    for name in (COLOUR, path):
        assert graphrun("snapshot", SCENE, "--camera", name, "-o", "picture.png").code == 0
        assert pixels(project / "picture.png").shape == (800, 1280, 3)


@needs_opengl
def test_pictures_of_a_driving_robot_differ_after_a_second(graphrun: Graphrun, project: Path) -> None:
    graph = (
        "graph: go\nnodes:\n  Tick: OnPlaybackTick\n"
        "  Wheels: {type: ArticulationController, inputs: {robotPath: /dd100, velocityCommand: [10.0, 10.0],\n"
        "           jointNames: [front_left_wheel_joint, front_right_wheel_joint]}}\n"
        "connections:\n  - Tick.tick -> Wheels.execIn\n"
    )
    (project / "go.yaml").write_text(graph, encoding="utf-8")
    seen = []
    for at in ("0", "1s"):
        drive = ["go.yaml", "--scene", "dd100_warehouse", "--at", at, "--camera", "top", "--segmentation"]
        result = graphrun("snapshot", *drive, "--size", "1280x720", "-o", "picture.png")
        assert result.code == 0, result.err
        rows = [line.split() for line in result.lines if line.endswith("/base_link/chassis_link")]
        colour = tuple(int(rows[0][0][i : i + 2], 16) for i in (1, 3, 5))
        seen.append(np.argwhere((pixels(project / "picture.png") == colour).all(axis=-1)).mean(axis=0))
    moved = np.linalg.norm(seen[1] - seen[0]) * 35.5 / 720  # m: this world's plan is 35.5 m high
    assert moved == pytest.approx(0.45, abs=0.1)  # 10 rad/s on wheels of 0.049 m, and at first they spin


@needs_opengl
def test_depths_are_millimetres_and_0_where_nothing_is_in_range(graphrun: Graphrun, project: Path) -> None:
    arguments = ["--camera", DEPTH, "--size", "160x90", "--depth", "-o", "depth.png"]
    assert graphrun("snapshot", SCENE, *arguments).code == 0
    depth = pixels(project / "depth.png")
    focal = 80 / np.tan(np.radians(43.5))
    below = np.arange(45, 90) - 44.5
    floor = 1000 * 0.0645 * focal / below  # mm
    expected = np.where((floor >= 520) & (floor <= 6000), floor, 0)
    assert (expected > 0).sum() > 5
    np.testing.assert_allclose(depth[45:, 80], expected, rtol=0.03)
    assert (depth[:44] == 0).all()


@needs_opengl
def test_the_segmentation_table_has_the_colours_and_pixel_counts_of_the_image(
    graphrun: Graphrun, project: Path
) -> None:
    result = graphrun("snapshot", SCENE, "--size", "160x90", "--segmentation", "-o", "parts.png", code=0)
    picture = pixels(project / "parts.png").reshape(-1, 3)
    told = {path: (colour, int(count)) for colour, count, _, path in (line.split() for line in result.lines)}
    assert {"/World", "/dd100/Geometry/base_link/chassis_link"} <= set(told)
    assert len({colour for colour, _ in told.values()}) == len(told)
    for colour, count in told.values():
        red_green_blue = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        assert (picture == red_green_blue).all(axis=1).sum() == count
    assert sum(count for _, count in told.values()) == 160 * 90


@needs_opengl
def test_two_snapshots_are_alike_to_the_last_byte(graphrun: Graphrun, project: Path) -> None:
    for name in ("one.png", "two.png"):
        graphrun("snapshot", SCENE, "--at", "100ms", "--size", "160x90", "-o", name)
    assert (project / "one.png").read_bytes() == (project / "two.png").read_bytes()


@pytest.mark.parametrize(
    ("camera", "told"),
    [
        ("persepctive", "did you mean 'perspective'?"),
        ("Camera_Pseudo", "did you mean 'Camera_Pseudo_Depth'?"),
        (
            "/dd100",
            "views: top, perspective, follow\n  cameras: /dd100/Geometry/base_link/chassis_link/sim_camera/RSD455/Camera_Omni",
        ),
        ("/dd100/nowhere", "views: top, perspective, follow\n  cameras: "),
        ("/dd100/../x", "views: top, perspective, follow\n  cameras: "),
    ],
)
def test_an_unknown_camera_is_refused_with_the_known_cameras(
    graphrun: Graphrun, project: Path, camera: str, told: str
) -> None:
    result = graphrun("snapshot", SCENE, "--camera", camera, "-o", "picture.png", code=2)
    assert f"--camera {camera}: there is no view or camera with this name or path\n  {told}" in result.err
    assert not (project / "picture.png").exists()


def test_an_ambiguous_camera_name_is_refused_with_all_paths(graphrun: Graphrun, project: Path) -> None:
    robots = "".join(
        f"  {name}: {{use: robots/dd100.yaml, position: [{x}, 0, .03], namespace: {name}}}\n"
        for name, x in (("one", 0), ("two", 3))
    )
    scene = f"scene: two\nworld: worlds/flat_grid.xml\nrobots:\n{robots}"
    (project / "two.yaml").write_text(scene, encoding="utf-8")
    result = graphrun("snapshot", "two.yaml", "--camera", DEPTH, "-o", "picture.png", code=2)
    assert "2 cameras have this name\n  write one of: /one/Geometry/" in result.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["-o", "picture.jpg"], "-o picture.jpg: write the name of a PNG file"),
        (["-o", "p.png", "--size", "10"], "'10' is not a size; write 1280x720"),
        (["-o", "p.png", "--size", "0x10"], "'0x10' is not a size"),
        (["-o", "p.png", "--depth", "--segmentation"], "not allowed with argument"),
        (["-o", "p.png", "--depth", "--camera", "top"], "--depth: the view top has no depth image"),
        ([], "one of the arguments -o/--output --video is required"),
    ],
)
def test_contradictory_options_are_reported(graphrun: Graphrun, project: Path, arguments: list[str], told: str) -> None:
    result = graphrun("snapshot", SCENE, *arguments, code=2)
    assert told in result.err


@needs_opengl
def test_an_irregular_output_file_is_refused_and_kept(graphrun: Graphrun, project: Path) -> None:
    os.mkfifo(project / "picture.png")
    result = graphrun("snapshot", SCENE, "--size", "32x18", "-o", "picture.png", code=1)
    assert result.err.endswith("error: picture.png: not a regular file\n")
    assert [path.name for path in project.glob("*picture*")] == ["picture.png"]


def test_a_graph_without_a_scene_has_nothing_to_show(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("snapshot", "mine.yaml", "-o", "picture.png", code=2)
    assert "mine.yaml is a graph without a scene and has nothing to draw; give a scene with --scene" in result.err


def test_a_scene_with_mistakes_is_not_drawn(graphrun: Graphrun, project: Path) -> None:
    (project / "bad.yaml").write_text("scene: bad\nworld: nowhere.xml\n", encoding="utf-8")
    result = graphrun("snapshot", "bad.yaml", "-o", "picture.png", code=1)
    assert "S101" in result.err
    assert not (project / "picture.png").exists()


def test_without_opengl_the_packages_to_install_are_printed(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for camera in ("top", COLOUR):
        with monkeypatch.context() as patch:
            take_opengl_away(patch)
            result = graphrun("snapshot", SCENE, "--camera", camera, "-o", "picture.png")
        opengl._platform.cache_clear()
        assert result.code == 1
        assert "error: rendering images needs OpenGL, which does not work here" in result.err
        assert "apt-get install libegl1 libgl1-mesa-dri libopengl0" in result.err
    assert not (project / "picture.png").exists()
