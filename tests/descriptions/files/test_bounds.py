"""Worlds of a few words that ask for more memory than there is."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable

import pytest

from graphengine.descriptions.files import bounds, references
from graphengine.descriptions.files.bounds import MAX_MEMORY
from graphengine.descriptions.files.references import Library
from graphengine.format.diagnostics import CheckError, Findings
from graphengine.format.files import Files
from graphengine.format.spec import RobotUse
from graphengine.physics.model import scenery
from tests.physics.harness import ROBOT, Project

GEOM = '<geom size="1"/>'
JOINT = '<body name="b"><joint name="j"/><geom size="1"/></body>'


def world(assets: str = "", bodies: str = "", more: str = "") -> str:
    return f"<mujoco>\n<asset>{assets}</asset><worldbody>{bodies}</worldbody>{more}</mujoco>"


@pytest.mark.parametrize(
    ("text", "tag"),
    [
        (world('<texture name="t" type="2d" builtin="flat" width="90000" height="90000"/>'), "texture"),
        (world('<texture name="t" builtin="flat" width="9000" height="1"/>'), "texture"),
        (world('<texture name="t" type="2d" builtin="flat" width="9000" height="9000"/>' * 3), "texture"),
        (world('<hfield name="h" size="1 1 1 1" nrow="100000" ncol="100000"/>'), "hfield"),
        (world('<mesh name="m" builtin="supersphere" params="20000 1 1"/>'), "mesh"),
        (world(bodies='<flexcomp name="f" type="grid" count="100 100 100" spacing="1 1 1"/>'), "flexcomp"),
        (world(bodies='<replicate count="2000"><replicate count="2000"/></replicate>'), "replicate"),
        (world(bodies=f'<replicate count="500">{500 * GEOM}</replicate>'), "geom"),
        (world(bodies=f'<replicate count="-9e9">{GEOM}</replicate>'), "replicate"),
        (world(more='<size nkey="40000000"/>'), "size"),
        (
            world(bodies=1000 * "<body><freejoint/><geom/></body>", more=f"<keyframe>{6000 * '<key/>'}</keyframe>"),
            "key",
        ),
        (world(bodies=1000 * "<body><freejoint/><geom/></body>", more='<size nkey="6000"/>'), "size"),
        (world(bodies=GEOM, more='<sensor><contact geom1="g" num="1000000000"/></sensor>'), "contact"),
        (world(more='<size nuser_geom="1000000000"/>'), "size"),
        (world(bodies=f'<geom size="1" user="{100_000 * "1 "}"/>{1000 * GEOM}'), "geom"),
        (world(more='<sensor><user dim="1000000000"/></sensor>'), "user"),
        (world(bodies=JOINT, more='<actuator><general joint="j" actdim="1000000000"/></actuator>'), "general"),
    ],
)
def test_a_world_with_too_many_copies_is_refused_at_the_element_that_exceeds_the_limit(
    project: Project, text: str, tag: str
) -> None:
    error = project.write("world.xml", text).error()
    assert f"error S102: at this <{tag}> the world and its robots exceed the limit of 1.5 GB of memory" in error
    assert "use fewer copies, smaller textures or coarser meshes" in error
    assert (
        "estimated: 15 kB an element or copy of one, 75 kB a robot's link, joint or shape, 1000 bytes a triangle or vertex"
        in error
    )


def test_attached_models_count_with_all_models_that_they_attach(project: Project) -> None:
    """Thirty of thirty of thirty of thirty bodies."""
    project.write("m0.xml", world(bodies='<body name="b"><geom size="1"/></body>'))
    for level in range(1, 5):
        below = f'<model name="m" file="m{level - 1}.xml"/>'
        copies = "".join(f'<attach model="m" body="b" prefix="p{number}_"/>' for number in range(30))
        project.write(f"m{level}.xml", world(below, f'<body name="b">{copies}</body>'))
    project.write("world.xml", (project.folder / "m4.xml").read_text(encoding="utf-8"))
    assert "at this <attach> the world and its robots exceed" in "\n".join(project.errors())


def picture(width: int, height: int, depth: int = 8) -> bytes:
    """The beginning of a PNG file."""
    head = b"IHDR" + struct.pack(">2I5B", width, height, depth, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + head + struct.pack(">I", zlib.crc32(head))


@pytest.mark.parametrize(
    ("name", "data", "asset"),
    [
        ("a.png", picture(60_000, 60_000), '<texture name="t" type="2d" file="a.png"/>'),
        ("a.png", picture(60_000, 60_000), '<hfield name="h" size="1 1 1 1" file="a.png"/>'),
        ("a.hf", struct.pack("<2i", 65536, 65537) + bytes(4 * 65536), '<hfield name="h" size="1 1 1 1" file="a.hf"/>'),
        ("a.tex", struct.pack("<2i", 65536, 65537), '<texture name="t" type="2d" file="a.tex"/>'),
    ],
)
def test_a_file_whose_header_states_a_huge_size_is_refused_before_it_is_decoded(
    project: Project, name: str, data: bytes, asset: str
) -> None:
    """Sizes whose product is more than 32 bits hold end MuJoCo's process."""
    (project.folder / name).write_bytes(data)
    error = project.write("world.xml", world(asset)).error()
    tag = asset.partition(" ")[0]
    assert f"error S102: at this {tag}> the world and its robots exceed the limit of 1.5 GB of memory" in error


TEN = range(10)
MSH = struct.pack("<4i", 100_000, 0, 0, 50_000) + bytes(12 * 150_000)


def stl(triangles: int) -> bytes:
    """A binary STL file whose triangles are all points at the origin."""
    return bytes(80) + struct.pack("<I", triangles) + bytes(50 * triangles)


def obj(faces: str) -> bytes:
    return b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + faces.encode()


@pytest.mark.parametrize(
    ("name", "data", "asset", "uses"),
    [
        ("a.png", picture(9000, 9000), '<texture name="t{}" type="2d" file="a.png"/>', 3),
        ("a.png", picture(6500, 6500, depth=16), '<texture name="t{}" type="2d" file="a.png"/>', 4),
        ("a.png", picture(6000, 6000), '<texture name="t{}" type="2d" nchannel="4" file="a.png"/>', 5),
        ("a.png", picture(5000, 5000), '<texture name="t{}" fileup="a.png"/>', 2),
        ("a.png", picture(5000, 5000), '<texture name="t{}" fileup="a.png" filedown="a.png"/>', 2),
        ("a.png", picture(8000, 8000), '<texture name="t{}" gridsize="1 2" gridlayout=".R" file="a.png"/>', 2),
        ("a.png", picture(8000, 8000), '<hfield name="h{}" size="1 1 1 1" file="a.png"/>', 2),
        ("a.png", picture(7000, 7000, depth=16), '<hfield name="h{}" size="1 1 1 1" file="a.png"/>', 2),
        ("a.stl", stl(190_000), '<mesh name="m{}" file="a.stl"/>', 8),
        ("a.msh", MSH, '<mesh name="m{}" file="a.msh"/>', 15),
        ("a.obj", obj("f 1 2 3\n" * 200_000), '<mesh name="m{}" file="a.obj"/>', 8),
        ("a.obj", obj("f" + " 1 2 3 4" * 50_000), '<mesh name="m{}" file="a.obj"/>', 8),
        ("a.bin", stl(190_000), '<mesh name="m{}" content_type="model/stl" file="a.bin"/>', 8),
    ],
)
def test_a_file_counts_with_its_decoded_size_for_each_element_that_uses_it(
    project: Project, name: str, data: bytes, asset: str, uses: int
) -> None:
    """One use fewer is within the limit; it is read, but not decoded here, because that takes a gigabyte."""
    (project.folder / name).write_bytes(data)
    refused = project.write("world.xml", world("".join(map(asset.format, range(uses))))).error()
    assert "the world and its robots exceed the limit of 1.5 GB of memory" in refused
    assert "a file counts for each element that uses it" in refused
    path, findings = project.folder / "world.xml", Findings()
    library = Library(Files.of(path), findings)
    root = library.world(path, world("".join(map(asset.format, range(uses - 1)))))
    assert root is not None
    assert MAX_MEMORY * (uses - 2) / uses < library.memory <= MAX_MEMORY


def test_files_in_included_and_attached_models_count_for_each_use(project: Project) -> None:
    (project.folder / "a.png").write_bytes(picture(9000, 9000))
    textures = "".join(f'<texture name="t{number}" type="2d" file="a.png"/>' for number in range(2))
    project.write("part.xml", f"<mujoco><asset>{textures}</asset></mujoco>")
    (project.folder / "again.png").write_bytes(picture(9000, 9000))
    own = '<asset><texture name="u" type="2d" file="again.png"/></asset>'
    error = project.write("world.xml", f'<mujoco><include file="part.xml"/>{own}</mujoco>').error()
    assert "at this <texture> the world and its robots exceed" in error
    project.write("part.xml", world(textures, '<body name="b"><geom size="1"/></body>'))
    twice = "".join(f'<attach model="m" body="b" prefix="p{number}_"/>' for number in range(2))
    project.write("world.xml", world('<model name="m" file="part.xml"/>', twice))
    assert "at this <attach> the world and its robots exceed" in project.error()


def test_meshes_of_a_robot_count_once_for_each_file_and_scale(project: Project) -> None:
    """MuJoCo reads a file once for all visuals of a URDF description that scale it alike."""
    (project.folder / "a.stl").write_bytes(stl(190_000))
    geometry = '<geometry><mesh filename="a.stl" scale="{} 1 1"/></geometry>'
    old = '<collision><origin xyz="0 0 .2"/>'

    def with_visuals(scales: Iterable[int]) -> Project:
        return project.cart(old, "".join(f"<visual>{geometry.format(scale)}</visual>" for scale in scales) + old)

    refused = with_visuals(range(1, 9)).error()
    assert refused.startswith("bot.urdf:")
    assert "error S103: at this <mesh> the world and its robots exceed" in refused
    assert "at least 4 vertices required" in with_visuals([1] * 20).error()  # within the limit, and given to MuJoCo


def test_robots_and_the_world_count_together(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "MAX_MEMORY", 20_000_000)
    project.write("one.xml", world(bodies=f'<body>{800 * "<site/>"}<geom size="1"/></body>'))
    project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots:\n  a: {use: one.xml}\n")
    assert project.errors() == []
    project.world(*800 * ["<site/>"])
    error = project.error()
    assert error.startswith("one.xml:2:")
    assert "error S102: at this <site> the world and its robots exceed the limit of" in error


def test_a_robot_that_was_removed_counts_no_longer(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each robot takes 9 MB while it is read, and once more in the scene."""
    monkeypatch.setattr(bounds, "MAX_MEMORY", 20_000_000)
    monkeypatch.setattr(scenery, "MAX_MEMORY", 20_000_000)
    loaded = project.write("scene.yaml", "scene: test\nworld: world.xml\n").load()
    for number in range(4):
        bodies = f'<body name="b{number}">{600 * "<site/>"}<geom size="1"/></body>'
        loaded.add("added", RobotUse(use=world(bodies=bodies)))
        loaded.remove("added")
    loaded.add("added", RobotUse(use=world(bodies=f'<body name="b">{600 * "<site/>"}<geom size="1"/></body>')))
    with pytest.raises(CheckError, match="the world and its robots exceed the limit of"):
        loaded.add("other", RobotUse(use=world(bodies=f'<body name="c">{900 * "<site/>"}<geom size="1"/></body>')))


def test_excluded_contacts_and_copies_of_a_robot_count(project: Project) -> None:
    """Each two of 800 links of a robot may not collide: 319 600 pairs."""
    links = "".join(
        f'<link name="l{number}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        f'</inertial><collision><geometry><sphere radius="1"/></geometry></collision></link>'
        + (
            f'<joint name="j{number}" type="fixed"><parent link="l0"/><child link="l{number}"/></joint>'
            if number
            else ""
        )
        for number in range(800)
    )
    project.write("bot.urdf", f'<robot name="bot">{links}</robot>').write("bot.yaml", ROBOT + "base_link: l0\n")
    assert "bot.urdf:1:1: error S103: at this <robot> the world and its robots exceed" in project.error()
    few = links[: links.index('<link name="l100">')]
    project.write("bot.urdf", f'<robot name="bot">{few}</robot>')
    project.write(
        "scene.yaml",
        "scene: test\nworld: world.xml\nrobots:\n  bot: {use: bot.yaml, count: 100, spacing: [9, 9], per_row: 10}\n",
    )
    error = project.error()
    assert "scene.yaml:3:1: error S106: the world and its robots (100) exceed the limit of 1.5 GB of memory" in error


def test_all_files_of_a_scene_together_have_a_limit(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(references, "MAX_FILES_BYTES", 100_000)
    meshes = ""
    for number in TEN:
        (project.folder / f"a{number}.obj").write_bytes(obj("f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n") + b"#" * 20_000)
        meshes += f'<mesh name="m{number}" file="a{number}.obj"/>'
    first = project.write("world.xml", world(meshes)).errors()[0]
    assert "error S102: 'a4.obj': with this file, the files of the scene are larger than 0 MB" in first
