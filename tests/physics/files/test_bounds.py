"""Worlds of a few words that ask for more memory than there is."""

from __future__ import annotations

import struct
import zlib

import pytest

from tests.physics.harness import Project

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
        (world(more='<size nuser_geom="1000000000"/>'), "size"),
        (world(more='<sensor><user dim="1000000000"/></sensor>'), "user"),
        (world(bodies=JOINT, more='<actuator><general joint="j" actdim="1000000000"/></actuator>'), "general"),
    ],
)
def test_a_world_that_unfolds_without_end_is_refused_where_it_becomes_too_much(
    project: Project, text: str, tag: str
) -> None:
    error = project.write("world.xml", text).error()
    assert f"error S102: at this <{tag}> the world exceeds the limit of 200 million cells" in error
    assert "a texel or sample is one cell; an element, or a copy of one, counts as 2000 cells" in error


def test_models_that_attach_models_that_attach_models_are_counted_whole(project: Project) -> None:
    """Thirty of thirty of thirty of thirty bodies."""
    project.write("m0.xml", world(bodies='<body name="b"><geom size="1"/></body>'))
    for level in range(1, 5):
        below = f'<model name="m" file="m{level - 1}.xml"/>'
        copies = "".join(f'<attach model="m" body="b" prefix="p{number}_"/>' for number in range(30))
        project.write(f"m{level}.xml", world(below, f'<body name="b">{copies}</body>'))
    project.write("world.xml", (project.folder / "m4.xml").read_text(encoding="utf-8"))
    assert "at this <attach> the world exceeds" in "\n".join(project.errors())


def picture(width: int, height: int) -> bytes:
    """The beginning of a PNG file."""
    head = b"IHDR" + struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
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
def test_a_file_that_says_it_is_huge_is_refused_before_it_is_unfolded(
    project: Project, name: str, data: bytes, asset: str
) -> None:
    """Sizes whose product is more than 32 bits hold end MuJoCo's process."""
    (project.folder / name).write_bytes(data)
    error = project.write("world.xml", world(asset)).error()
    assert f"error S102: with {name!r} the files of the world exceed the limit of 200 million cells" in error
