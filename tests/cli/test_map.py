"""`graphrun map`: what map_server and a lidar make of the files that it writes."""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, find_file
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.loading import load_world
from tests.bringup.maps.map_server import ReadMap, read_map
from tests.cli.harness import Graphrun, process

ROOM = """<mujoco><worldbody>
  <geom type="plane" size="0 0 1"/>
  <body name="walls">
    <geom type="box" size="0.05 1.5 0.5" pos="-0.95 0.5 0.5"/>
    <geom type="box" size="0.05 1.5 0.5" pos="0.95 0.5 0.5"/>
    <geom type="box" size="1 0.05 0.5" pos="0 -0.95 0.5"/>
    <geom type="box" size="1 0.05 0.5" pos="0 1.95 0.5"/>
  </body>
  <body name="step"><geom type="box" size="0.2 0.2 0.05" pos="0.5 0.5 0.14"/></body>
</worldbody></mujoco>
"""


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with room.yaml: x -1 to 1, y -1 to 2 with its walls, and a step that ends at z = 0.19."""
    (tmp_path / "world.xml").write_text(ROOM, encoding="utf-8")
    (tmp_path / "room.yaml").write_text("scene: room\nworld: world.xml\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def loaded(name: str) -> LoadedWorld:
    path, findings = find_file(name).absolute(), Findings()
    scene = read(SceneSpec, path, findings)
    assert scene is not None
    world = load_world(scene, Files.of(path), findings)
    assert world is not None
    return world


def without_what_moves(world: LoadedWorld) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The same, with robots and loose things where no ray meets them."""
    model, data = world.simulation.model, world.simulation.data
    model.geom_group[model.body_weldid[model.geom_bodyid] != 0] = 5
    return model, data


def cast(
    model: mujoco.MjModel, data: mujoco.MjData, origin: NDArray[np.float64], angles: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where horizontal rays end, as x and y; those that meet nothing are left out."""
    rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
    geoms, distances = np.empty(len(rays), np.int32), np.empty(len(rays))
    groups = np.array([1, 1, 1, 1, 1, 0], np.uint8)
    mujoco.mj_multiRay(model, data, origin, rays.ravel(), groups, 1, -1, geoms, distances, None, len(rays), 100.0)
    hit = distances >= 0
    ends: NDArray[np.float64] = origin[:2] + distances[hit, None] * rays[hit, :2]
    return ends


def grown(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells, and the eight around each."""
    wide = np.pad(cells, 1)
    rows, columns = cells.shape
    near: NDArray[np.bool_] = np.any([wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)], axis=0)
    return near


# What the map is for


def test_a_scan_anywhere_in_the_warehouse_ends_at_an_occupied_cell_of_the_map(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert graphrun("map", "dd100_warehouse", "--z", "0.2", "0.62").code == 0
    chart = read_map(tmp_path / "dd100_warehouse_map.yaml")
    world = loaded("dd100_warehouse")
    lidar = world.simulation.frame(world.stage.find("/dd100/base_link/chassis_link/sim_lidar/Lidar"))
    height = lidar.pose()[0][2]
    model, data = without_what_moves(world)
    near = grown(chart.data == 100)
    dice = np.random.default_rng(1)
    free = np.argwhere(chart.data == 0)
    ends = []
    for row, column in free[dice.choice(len(free), 200, replace=False)].tolist():
        x, y = np.array([column, row]) * chart.resolution + chart.origin[:2] + dice.uniform(0, chart.resolution, 2)
        ends.append(cast(model, data, np.array([x, y, height]), np.linspace(-np.pi, np.pi, 360) + dice.uniform(0, 1)))
    met = near[chart.cell(*np.concatenate(ends).T)]
    sys.stdout.write(f"{met.mean():.3%} of {len(met)} beams end within a cell of an occupied one\n")
    assert len(met) == 200 * 360
    assert met.mean() >= 0.99


# What is written


def test_the_image_and_the_yaml_describe_the_room(graphrun: Graphrun, room: Path) -> None:
    result = graphrun("map", "room.yaml", "--cell", "0.1", "--bounds", "-1.2", "-1", "1", "2.2", code=0, err="")
    assert result.lines[0].startswith("room_map.png and room_map.yaml, in ")
    assert result.lines[1:] == [
        "22 x 32 cells of 0.1 m, origin (-1.2, -1) m, z 0.2 to 0.62 m",
        "occupied 13.6 %, free 71.6 %, unknown 14.8 %",
    ]
    assert (room / "room_map.yaml").read_text(encoding="utf-8") == (
        "image: room_map.png\nmode: trinary\nresolution: 0.1\norigin: [-1.2, -1.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    with Image.open(room / "room_map.png") as image:
        assert (image.mode, image.size) == ("L", (22, 32))
    check_room(read_map(room / "room_map.yaml"))


def check_room(chart: ReadMap) -> None:
    """Cells of 0.1 m: a frame of 20 x 30 that is one cell thick; west and north of it, two columns and rows unknown."""
    expected = np.full((32, 22), -1)
    expected[:30, 2:] = 100
    expected[1:29, 3:21] = 0
    assert chart.data.tolist() == expected.tolist()
    assert chart.origin == (-1.2, -1.0, 0.0)


def test_localizability_is_written_and_summed_up(graphrun: Graphrun, room: Path) -> None:
    head = "robot: r\nurdf: r.urdf\nbase_link: base\n"
    text = f"{head}sensors:\n  lidar: {{type: lidar, profile: lidar_360, parent: base, position: [0, 0, 0.3]}}\n"
    (room / "r.yaml").write_text(text, encoding="utf-8")
    box = '<geometry><box size="0.2 0.2 0.2"/></geometry>'
    urdf = f'<robot name="r"><link name="base"><collision>{box}</collision></link></robot>'
    (room / "r.urdf").write_text(urdf, encoding="utf-8")
    use = "robots:\n  r: {use: r.yaml, position: [0, 0, 0.1]}\n"
    (room / "room.yaml").write_text(f"scene: room\nworld: world.xml\n{use}", encoding="utf-8")
    done = graphrun("map", "room.yaml", "--localizability")
    assert done.code == 0, done
    assert "room_map_localizability.png and room_map_localizability.csv" in done.out
    assert "16 headings" in done.out
    assert "ambiguous" in done.out
    head, *rows = (room / "room_map_localizability.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("x,y,spread,direction_deg,near,far")
    assert rows
    for option, value, words in (
        ("--robot", "q", "no robot 'q'"),
        ("--lidar", "/nothing", "/nothing"),
        ("--scans", "0", "above 0"),
    ):
        refused = graphrun("map", "room.yaml", "--localizability", option, value)
        assert refused.code == 2
        assert words in refused.err


def test_localizability_needs_a_robot(graphrun: Graphrun, room: Path) -> None:
    done = graphrun("map", "room.yaml", "--localizability")
    assert done.code == 2
    assert "the scene has no robot" in done.err


def test_a_pgm_map_equals_the_png_map(graphrun: Graphrun, room: Path) -> None:
    bounds = ("--bounds", "-1.2", "-1", "1", "2.2")
    assert graphrun("map", "room.yaml", "--cell", "0.1", *bounds, "--format", "pgm", "-o", "maps/floor.1").code == 0
    assert sorted(path.name for path in (room / "maps").iterdir()) == ["floor.1.pgm", "floor.1.yaml"]
    assert (room / "maps/floor.1.pgm").read_bytes().startswith(b"P5\n22 32\n255\n")
    check_room(read_map(room / "maps/floor.1.yaml"))


def test_the_same_scene_gives_the_same_bytes_in_another_process(graphrun: Graphrun, room: Path) -> None:
    assert graphrun("map", "room.yaml", "-o", "one/map.png").code == 0
    process("map", "room.yaml", "-o", "two/map.yaml", cwd=room, env={"PYTHONHASHSEED": "4242"}, code=0)
    for ending in ("png", "yaml"):
        assert (room / f"one/map.{ending}").read_bytes() == (room / f"two/map.{ending}").read_bytes()


def test_in_isaacs_convention_the_text_the_window_and_the_pixels_are_isaacs(graphrun: Graphrun, room: Path) -> None:
    """The window 0.2 to 0.62 becomes 0.175 to 0.675, in which the step at 0.09 to 0.19 is; the origin is a cell's centre."""
    result = graphrun("map", "room.yaml", "--convention", "isaac")
    assert "origin (-1, -1) m, z 0.175 to 0.675 m" in result.lines[1]
    assert (room / "room_map.yaml").read_bytes() == (
        b"image: room_map.png\nresolution: 0.05\norigin: [-0.975, -0.975, 0.0000]\n"
        b"negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196"
    )
    with Image.open(room / "room_map.png") as image:
        assert (image.mode, image.size) == ("RGBA", (40, 60))
        colours = {colour for _, colour in image.getcolors() or []}
        assert image.getpixel((30, 30)) == (0, 0, 0, 255)  # x 0.5 to 0.55, y 0.45 to 0.5: the step
    assert colours == {(0, 0, 0, 255), (255, 255, 255, 255)}
    assert graphrun("map", "room.yaml").code == 0
    with Image.open(room / "room_map.png") as image:
        assert image.getpixel((30, 30)) == 255


def test_a_name_that_yaml_would_misread_is_quoted(graphrun: Graphrun, room: Path) -> None:
    for convention in ("ros", "isaac"):
        assert graphrun("map", "room.yaml", "-o", "a: #1", "--convention", convention).code == 0
        assert read_map(room / "a: #1.yaml").data.shape == (60, 40)


# What NVIDIA's own map of the small warehouse has


def extent(
    cells: NDArray[np.bool_], chart: ReadMap, near: tuple[float, float], reach: tuple[float, float]
) -> list[float]:
    """Outer borders of the occupied cells around a point: west, east, south, north."""
    row, column = (int(value) for value in chart.cell(*near))
    wide, high = (round(r / chart.resolution) for r in reach)
    south, west = max(row - high, 0), max(column - wide, 0)
    rows, columns = cells[south : row + high, west : column + wide].nonzero()
    x = [chart.origin[0] + chart.resolution * (west + edge) for edge in (columns.min(), columns.max() + 1)]
    y = [chart.origin[1] + chart.resolution * (south + edge) for edge in (rows.min(), rows.max() + 1)]
    return [*x, *y]


def test_the_map_of_the_small_warehouse_agrees_with_nvidias_within_a_cell(graphrun: Graphrun, tmp_path: Path) -> None:
    assert graphrun("map", "tutorial/simple_warehouse", "-o", str(tmp_path / "map")).code == 0
    chart = read_map(tmp_path / "map.yaml")
    cell, occupied = chart.resolution, chart.data == 100
    west, east, south, north = extent(chart.data == 0, chart, (0.0, 0.0), (30.0, 30.0))
    assert (west, east, south, north) == pytest.approx((-10.30, 9.40, -12.20, 17.95), abs=cell + 1e-6)
    for x in (-9.25, -0.25, 8.75):
        assert extent(occupied, chart, (x, 4.3), (0.3, 9.0))[2:] == pytest.approx((-3.95, 12.55), abs=cell + 1e-6)
        feet = extent(occupied, chart, (x, -3.8), (0.75, 0.1))[:2]
        assert feet[0] == pytest.approx(x - 0.7, abs=cell + 1e-6)
        assert feet[1] == pytest.approx(x + 0.7, abs=cell + 1e-6) or x == 8.75  # which stands at the wall
    for y in (-9, -3, 3, 9, 15):
        row, _ = chart.cell(0.0, y)
        for x, inner in ((-10.30, -10.20), (9.40, 9.30)):
            assert occupied[row, chart.cell((x + inner) / 2, y)[1]], (x, y)
    for x in (-6.1, 4.5):
        west, east, south, north = extent(occupied, chart, (x, 13.7), (1.2, 1.0))
        assert (east - west, north - south) == pytest.approx((1.5, 1.35), abs=2 * cell)
        assert ((east + west) / 2, (south + north) / 2) == pytest.approx((x, 13.7), abs=cell)


# Mistakes


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--from", "-0.95", "0"], "the nearest free point is (-0.875, 0.025)"),
        (["--from", "7", "0"], "the free point (7, 0) lies outside of the map"),
        (["--z", "0.62", "0.2"], "z: the lower bound 0.62 is not below the upper bound 0.2"),
        (["--z", "0.62", "0.2", "--convention", "isaac"], "z: the lower bound 0.62 is not below the upper bound 0.2"),
        (["--cell", "0"], "cell: 0 m is less than 0.0001 m"),
        (["--cell", "0", "--convention", "isaac"], "cell: 0 m is less than 0.0001 m"),
        (["--cell", "nan", "--convention", "isaac"], "argument --cell: 'nan': write a number"),
        (["--z", "0.2", "inf", "--convention", "isaac"], "argument --z: 'inf': write a number"),
        (["--cell", "0.0002"], "10000 x 15000 cells are more than the 25000000"),
        (["--bounds", "0", "0", "-1", "1"], "bounds: the smallest x, 0, is not below the largest, -1"),
        (["--select", "/World/wals"], "/World has no child 'wals'\n  did you mean 'walls'?\n"),
        (["--include", "world"], "'world' is not a prim path"),
        (["--convention", "isaac", "--format", "pgm"], "Isaac Sim's convention needs a PNG"),
        (["--allow", "nowhere"], "--allow nowhere: no such folder"),
        (["-o", "maps/"], "-o maps/: this is a folder; write a file name such as maps/room"),
        (["-o", "."], "-o .: this is a folder; write a file name such as room"),
        (["-o", ".png"], "-o .png: this is a folder; write a file name such as room"),
    ],
)
def test_invalid_options_are_reported_and_nothing_is_written(
    graphrun: Graphrun, room: Path, arguments: list[str], message: str
) -> None:
    before = sorted(path.name for path in room.iterdir())
    result = graphrun("map", "room.yaml", *arguments, code=2, out="")
    assert result.err.startswith("graphrun map: ")
    assert message in result.err
    assert sorted(path.name for path in room.iterdir()) == before


def test_a_scene_with_mistakes_is_explained(graphrun: Graphrun, room: Path) -> None:
    (room / "room.yaml").write_text("scene: room\nworld: word.xml\n", encoding="utf-8")
    result = graphrun("map", "room.yaml", code=1, out="")
    assert "error S101" in result.err
    assert not (room / "room.png").exists()


def test_a_map_is_made_of_a_scene_whose_graphs_have_mistakes(graphrun: Graphrun, room: Path) -> None:
    (room / "broken.yaml").write_text("graph: broken\nnodes: {A: NoSuchType}\n", encoding="utf-8")
    graphs = "graphs: {broken: {use: broken.yaml}, lost: {use: lost.yaml}}\n"
    (room / "room.yaml").write_text(f"scene: room\nworld: world.xml\n{graphs}", encoding="utf-8")
    assert graphrun("check", "room.yaml").code == 1
    graphrun("map", "room.yaml", code=0, err="")


@pytest.mark.parametrize("text", ["- room\n", "room\n", "1\n"])
def test_a_file_of_another_kind_is_explained(graphrun: Graphrun, room: Path, text: str) -> None:
    (room / "room.yaml").write_text(text, encoding="utf-8")
    result = graphrun("map", "room.yaml", code=1, out="")
    assert result.err.startswith("room.yaml:1:1: error G108: file: expected a mapping, got ")


def test_a_graph_has_no_map(graphrun: Graphrun) -> None:
    result = graphrun("map", str(find_file("dd100/cmd_vel")), code=2, out="")
    assert "this is a graph file; give a scene file" in result.err


@pytest.mark.parametrize("ending", ["png", "yaml"])
def test_both_files_are_written_or_none(graphrun: Graphrun, room: Path, ending: str) -> None:
    (room / f"map.{ending}").mkdir()
    graphrun("map", "room.yaml", "-o", "map", code=1, err=f"error: map.{ending}: Is a directory\n")
    assert sorted(path.name for path in room.iterdir()) == sorted([f"map.{ending}", "room.yaml", "world.xml"])


def test_neither_the_scene_nor_another_file_of_ours_is_overwritten(graphrun: Graphrun, room: Path) -> None:
    text = (room / "room.yaml").read_bytes()
    result = graphrun("map", "room.yaml", "-o", "room", code=2, out="")
    assert result.err == "graphrun map: room.yaml exists and is not a map; choose another name\n"
    assert (room / "room.yaml").read_bytes() == text
    assert not (room / "room.png").exists()
    assert [graphrun("map", "room.yaml", "-o", "again").code for _ in range(2)] == [0, 0]


def test_a_folder_that_cannot_be_created_is_reported(graphrun: Graphrun, room: Path) -> None:
    result = graphrun("map", "room.yaml", "-o", "world.xml/maps/map", code=1)
    assert result.err.startswith("error: ")
    assert "world.xml/maps" in result.err
