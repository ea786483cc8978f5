"""Meshes of all formats: where their points are, what colour they have, and what cannot be read."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files import meshes, references
from graphengine.descriptions.files.meshes import MeshError, convert
from tests.physics.harness import CART, Project

BOX = trimesh.creation.box((0.2, 0.4, 0.6))
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MESH = '<mesh filename="{}"/>'


def material(name: str, diffuse: str) -> tuple[str, str]:
    """An effect and the material of it."""
    effect = f'<effect id="{name}-effect"><profile_COMMON><technique sid="common"><phong><diffuse>{diffuse}</diffuse>'
    effect += "</phong></technique></profile_COMMON></effect>"
    return effect, f'<material id="{name}"><instance_effect url="#{name}-effect"/></material>'


def collada(nodes: str, unit: str = "", up: str = "Z_UP", materials: tuple[tuple[str, str], ...] = ()) -> bytes:
    """A COLLADA file with a triangle (0,0,0) (1,0,0) (0,1,0) called `red`, and the same 2 higher called `blue`."""
    triangles = "".join(
        f'<triangles count="1" material="{name}"><input semantic="VERTEX" source="#v" offset="0"/><p>{points}</p></triangles>'
        for name, points in (("red", "0 1 2"), ("blue", "3 4 5"))
    )
    effects, defined = "".join(effect for effect, _ in materials), "".join(text for _, text in materials)
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>{up}</up_axis></asset>
<library_effects>{effects}</library_effects><library_materials>{defined}</library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="18">0 0 0 1 0 0 0 1 0 0 0 2 1 0 2 0 1 2</float_array>
<technique_common><accessor source="#a" count="6" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{triangles}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


def instance(*bound: str) -> str:
    """The geometry, with materials of the names of its parts."""
    binds = "".join(f'<instance_material symbol="{name}" target="#{name}"/>' for name in bound)
    bound_materials = f"<bind_material><technique_common>{binds}</technique_common></bind_material>"
    return f'<instance_geometry url="#g">{bound_materials}</instance_geometry>'


RED, BLUE = material("red", "<color>1 0 0 1</color>"), material("blue", "<color>0 0 1 1</color>")
BOTH = f"<node>{instance('red', 'blue')}</node>"
TWO = collada(BOTH, materials=(RED, BLUE))


def gltf(binary: bytes = b"", **parts: list[dict[str, Any]]) -> bytes:
    """A binary glTF file of one node with the first mesh."""
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], **parts}
    text = json.dumps({"buffers": [{"byteLength": len(binary)}], **document}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary if binary else b""
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def zipped(data: bytes) -> bytes:
    """A ZIP archive, in which pycollada looks for a file called so."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("a.dae", data)
    return archive.getvalue()


def bounds(data: bytes, suffix: str = ".dae") -> list[list[float]]:
    vertices = meshes.merged(convert(data, suffix)).vertices
    return [vertices.min(axis=0).round(9).tolist(), vertices.max(axis=0).round(9).tolist()]


def exported(kind: str) -> bytes:
    """The box as a file."""
    written: Any = BOX.export(file_type=kind)
    return written.encode() if isinstance(written, str) else bytes(written)


def test_nodes_and_units_of_a_collada_file_place_its_points() -> None:
    turned = "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><node><scale>1 3 1</scale>{}</node></node>"
    data = collada(turned.format(instance()), '<unit name="inch" meter="0.0254"/>')
    # (x, y, z) is scaled to (x, 3y, z), turned to (-3y, x, z), moved to (10 - 3y, x, z).
    low, high = bounds(data)
    assert low == pytest.approx([7 * 0.0254, 0, 0], abs=1e-6)
    assert high == pytest.approx([10 * 0.0254, 0.0254, 2 * 0.0254])


@pytest.mark.parametrize(("scale", "corners"), [("1 3 1", [0, 1, 2]), ("-1 3 1", [2, 1, 0]), ("-1 -3 1", [0, 1, 2])])
def test_a_node_that_mirrors_does_not_turn_its_triangles_inside_out(scale: str, corners: list[int]) -> None:
    for part in convert(collada(f"<node><scale>{scale}</scale>{instance()}</node>"), ".dae"):
        assert part.faces.reshape(-1, 3).tolist() == [corners, [3 + corner for corner in corners]]


def test_the_up_axis_of_a_collada_file_does_not_count() -> None:
    """As in RViz, Gazebo and MoveIt."""
    node = f"<node>{instance()}</node>"
    assert bounds(collada(node, up="Y_UP")) == bounds(collada(node, up="Z_UP")) == [[0, 0, 0], [1, 1, 2]]


def test_a_geometry_stands_wherever_it_is_instanced() -> None:
    data = collada(f"<node>{instance()}</node><node><translate>0 0 5</translate>{instance()}</node>")
    assert bounds(data) == [[0, 0, 0], [1, 1, 7]]
    assert sum(len(part.faces) for part in convert(data, ".dae")) == 4


def test_parts_have_the_colours_of_their_materials() -> None:
    pale = material("red", "<color>1 0 0 0.2</color>")
    parts = convert(collada(BOTH, materials=(pale, BLUE)), ".dae")
    assert [(part.colour, part.vertices[:, 2].tolist()) for part in parts] == [
        ((1, 0, 0, 1), [0, 0, 0]),
        ((0, 0, 1, 1), [2, 2, 2]),
    ]
    same = material("blue", "<color>1 0 0 1</color>")
    assert len(convert(collada(BOTH, materials=(RED, same)), ".dae")) == 1


def test_a_geometry_with_a_missing_material_is_read() -> None:
    assert bounds(collada(BOTH, materials=(RED,))) == [[0, 0, 0], [1, 1, 2]]


@pytest.mark.parametrize("suffix", [".ply", ".glb", ".off", ".stl"])
def test_other_formats_are_read_with_their_points(suffix: str) -> None:
    kind = "stl_ascii" if suffix == ".stl" else suffix[1:]
    data = exported(kind)
    assert meshes.needs_conversion(data, suffix)
    assert np.allclose(bounds(data, suffix), BOX.bounds, atol=1e-6)


def test_a_binary_stl_file_of_more_triangles_than_mujoco_reads_is_converted() -> None:
    ball = trimesh.creation.icosphere(7)
    data = ball.export(file_type="stl")
    assert len(ball.faces) > meshes.MAX_STL_TRIANGLES
    assert meshes.needs_conversion(data, ".stl")
    (part,) = convert(data, ".stl")
    assert len(part.vertices) == len(ball.vertices)
    assert np.allclose(part.vertices[part.faces], ball.triangles, atol=1e-6)


def test_mujoco_reads_converted_meshes(project: Project) -> None:
    """A box of water: 0.2 x 0.4 x 0.6 m weigh 48 kg, and I = m / 12 (a2 + b2)."""
    (project.folder / "box.ply").write_bytes(exported("ply"))
    arm = CART.index('<link name="arm">')
    start, end = CART.index("<inertial>", arm), CART.index("</inertial>", arm) + len("</inertial>")
    mesh = (CART[:start] + CART[end:]).replace('<sphere radius=".05"/>', MESH.format("box.ply"))
    model = project.write("bot.urdf", mesh).load().simulation.model
    body = model.body("bot/arm")
    assert body.mass[0] == pytest.approx(48)
    assert sorted(body.inertia) == pytest.approx([4 * (0.04 + 0.16), 4 * (0.04 + 0.36), 4 * (0.16 + 0.36)])


@pytest.mark.parametrize(
    ("data", "suffix", "why"),
    [
        (b"<COLLADA/>", ".dae", "no scene"),
        (b"not XML", ".dae", "the file cannot be read: syntax error: line 1"),
        (b'<!DOCTYPE x [<!ENTITY a SYSTEM "/etc/passwd">]><COLLADA>&a;</COLLADA>', ".dae", "document type"),
        (b"PK\x03\x04" + bytes(50), ".dae", "not well-formed"),
        (
            collada("<node/>") + b"<!--" + zipped(collada(f"<node>{instance()}</node>")),
            ".dae",
            "the file contains a ZIP archive",
        ),
        (collada("<node/>"), ".dae", "no triangles"),
        (b"solid nothing", ".stl", "neither ASCII STL nor binary STL"),
        (b"version https://git-lfs.github.com/spec/v1\nsize 9\n", ".dae", "a pointer of Git LFS"),
        (b"ply\nformat ascii 1.0\nelement vertex 9\nend_header\n", ".ply", "the file cannot be read: ."),
        (b"glTF", ".glb", "the file cannot be read: ."),
    ],
)
def test_an_unreadable_mesh_is_an_error_with_the_reason(data: bytes, suffix: str, why: str) -> None:
    with pytest.raises(MeshError, match=why):
        convert(data, suffix)


def test_a_mesh_names_no_other_file(tmp_path: Path) -> None:
    (tmp_path / "points.bin").write_bytes(bytes(36))
    for name in (str(tmp_path / "points.bin"), "points.bin", (tmp_path / "points.bin").as_uri()):
        data = gltf(
            buffers=[{"byteLength": 36, "uri": name}],
            bufferViews=[{"buffer": 0, "byteLength": 36}],
            accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
        )
        with pytest.raises(MeshError, match="the file cannot be read"):
            convert(data, ".glb")


def test_images_in_a_mesh_file_are_not_read(caplog: pytest.LogCaptureFixture) -> None:
    """They may unfold to more than there is memory; here none can be read, which trimesh would log."""
    caplog.set_level("DEBUG")
    points = struct.pack("<15f", *range(15))
    data = gltf(
        points,
        accessors=[
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        bufferViews=[{"buffer": 0, "byteLength": 60}],
        images=[{"bufferView": 0, "mimeType": "image/png"}],
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    )
    assert bounds(data, ".glb") == [[0, 1, 2], [6, 7, 8]]
    textured = exported("ply").replace(b"comment https", b"comment TextureFile secret.png\ncomment https", 1)
    assert np.allclose(bounds(textured, ".ply"), BOX.bounds)
    assert b"TextureFile" in textured
    assert [text for text in caplog.messages if "image" in text] == []


def test_the_number_of_uses_of_nodes_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "MAX_NODES", 1000)
    doubled = "".join(
        f'<node id="n{level}"><instance_node url="#n{level - 1}"/><instance_node url="#n{level - 1}"/></node>'
        for level in range(1, 30)
    )
    data = collada('<node><instance_node url="#n29"/></node>')
    nodes = f'<library_nodes><node id="n0">{instance()}</node>{doubled}</library_nodes><library_visual_scenes>'
    with pytest.raises(MeshError, match="more than 1000 nodes"):
        convert(data.replace(b"<library_visual_scenes>", nodes.encode()), ".dae")


def draw(project: Project, visual: str) -> tuple[list[list[float]], list[str]]:
    """Colours of the arm's visuals, and what was told."""
    world, findings = project.cart('<link name="plate"/>', f'<link name="plate">{visual}</link>').load_with_findings()
    model = world.simulation.model
    drawn = [i for i in range(model.ngeom) if model.body(int(model.geom_bodyid[i])).name == "bot/plate"]
    return model.geom_rgba[drawn].round(3).tolist(), [finding.message for finding in findings.items]


def test_visuals_have_the_colours_of_their_file_unless_the_description_gives_a_colour(project: Project) -> None:
    (project.folder / "two.dae").write_bytes(TWO)
    visual = f"<visual><geometry>{MESH.format('two.dae')}</geometry>{{}}</visual>"
    assert draw(project, visual.format("")) == ([[1, 0, 0, 1], [0, 0, 1, 1]], [])
    green = '<material name="paint"><color rgba="0 1 0 0.5"/></material>'
    assert draw(project, visual.format(green))[0] == [[0, 1, 0, 0.5]] * 2


def test_textures_lost_in_conversion_are_reported_once(project: Project) -> None:
    textured = material("red", '<texture texture="picture" texcoord="UV0"/>')
    for name, materials in (("a.dae", (textured, BLUE)), ("b.dae", (textured, BLUE)), ("plain.dae", (RED, BLUE))):
        (project.folder / name).write_bytes(collada(BOTH, materials=materials))
    visuals = "".join(
        f"<visual><geometry>{MESH.format(name)}</geometry></visual>" for name in ("a.dae", "b.dae", "plain.dae")
    )
    _, findings = project.cart("<collision><geometry><box", f"{visuals}<collision><geometry><box").load_with_findings()
    (told,) = [finding for finding in findings.items if "textures" in finding.message]
    assert (told.code, told.help) == ("N103", ("meshes: a.dae, b.dae",))


def test_a_colour_is_known_by_its_name_wherever_it_is_given(project: Project) -> None:
    box = '<visual><geometry><box size="1 1 1"/></geometry>{}</visual>'
    named = '<material name="paint"/>'
    given = '<material name="paint"><color rgba="0 1 0 1"/></material>'
    other = '<material name="paint"><color rgba="1 0 0 1"/></material>'
    colours, _ = draw(project, box.format(named) + box.format(given) + box.format(other) + box.format(named))
    assert colours == [[0, 1, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1], [0, 1, 0, 1]]


def test_an_unreadable_visual_is_left_out_and_reported(project: Project) -> None:
    project.write("odd.dae", "<COLLADA/>").write("odd.fbx", "")
    visual = f"<visual><geometry>{MESH}</geometry></visual>"
    assert draw(project, visual.format("odd.dae")) == (
        [],
        ["the visual 'odd.dae' is not drawn: the COLLADA file has no scene"],
    )
    (told,) = draw(project, visual.format("odd.fbx"))[1]
    assert "meshes of the format '.fbx' are not supported; legal: .stl, .obj, .msh, .dae" in told


def test_a_collider_that_cannot_be_read_is_an_error(project: Project) -> None:
    project.write("odd.dae", "<COLLADA/>").cart('<box size=".4 .3 .1"/>', MESH.format("odd.dae"))
    assert "bot.urdf:4:42: error S103: 'odd.dae': the COLLADA file has no scene" in project.error()


def test_a_mesh_that_is_too_large_is_reported(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(references, "MAX_FILE_BYTES", 1_000_000)
    (project.folder / "big.obj").write_bytes(bytes(1_000_001))
    project.cart('<box size=".4 .3 .1"/>', MESH.format("big.obj"))
    assert "bot.urdf:4:42: error S103: 'big.obj': the file is larger than 1 MB" in project.error()


def test_a_flat_mesh_can_be_seen(project: Project) -> None:
    project.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    colours, told = draw(project, f"<visual><geometry>{MESH.format('flat.obj')}</geometry></visual>")
    assert (len(colours), told) == (1, [])


def test_an_obj_file_whose_corners_differ_is_read(project: Project) -> None:
    """Some with normals, some without, which MuJoCo mixes up."""
    normals = TETRAHEDRON.replace("f 1 3 2", "vn 0 0 -1\nf 1//1 3//1 2//1")
    assert meshes.needs_conversion(normals.encode(), ".obj")
    assert not meshes.needs_conversion(TETRAHEDRON.encode(), ".obj")
    project.write("odd.obj", normals)
    assert len(draw(project, f"<visual><geometry>{MESH.format('odd.obj')}</geometry></visual>")[0]) == 1


def test_a_shape_without_size_is_left_out_and_reported(project: Project) -> None:
    assert draw(project, '<visual><geometry><sphere radius="0.0"/></geometry></visual>') == (
        [],
        ["a shape with a size of 0 is left out"],
    )


@pytest.mark.parametrize("scale", ["1 1 1", "-1 1 1", "1 -1 1", "1 1 -1", "-1 -1 -1", "-2 1 3"])
def test_a_negative_scale_mirrors_a_mesh_with_its_mass_and_its_outside(scale: str) -> None:
    """The tetrahedron has volume 1; its centre of mass is the mean of its corners; rays from outside meet its outside."""
    factors = np.array([float(part) for part in scale.split()])
    description = f"""<robot name="r"><mujoco><compiler fusestatic="false"/></mujoco><link name="root"/>
      <link name="b"><collision><geometry><mesh filename="t.obj" scale="{scale}"/></geometry></collision></link>
      <joint name="j" type="fixed"><parent link="root"/><child link="b"/></joint></robot>"""
    model = mujoco.MjSpec.from_string(description, assets={"t.obj": TETRAHEDRON.encode()}).compile()
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]) * factors
    volume = abs(np.linalg.det(corners[1:])) / 6
    assert model.body("b").mass[0] == pytest.approx(1000 * volume)
    assert model.body("b").ipos == pytest.approx(corners.mean(axis=0))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    inside = np.array([0.2, 0.3, 0.4]) * factors
    for axis in range(3):
        for side in (-1.0, 1.0):
            direction = np.eye(3)[axis] * side
            geom, normal = np.zeros(1, np.int32), np.zeros(3)
            distance = mujoco.mj_ray(model, data, inside - 20 * direction, direction, None, 1, -1, geom, normal)
            assert 0 < distance < 20
            assert normal @ direction < 0


def test_the_conversion_of_each_mesh_is_listed(project: Project) -> None:
    (project.folder / "box.ply").write_bytes(exported("ply"))
    visual = f"<visual><geometry>{MESH.format('box.ply')}</geometry></visual></link>"
    description = CART.replace('<box size=".4 .3 .1"/>', MESH.format("t.obj")).replace("</link>", visual, 1)
    project.write("bot.urdf", description).write("t.obj", TETRAHEDRON)
    assert project.load().scenery.library.outcomes == {"t.obj": "unchanged", "box.ply": "converted"}
