"""Limits of the room physics on descriptions, SDF, their files, and imports."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from graphengine.bringup.robots import arm_gains, controllers_file
from graphengine.bringup.robots.gazebo_profiles import NO_LIKE
from graphengine.descriptions import link_tree
from graphengine.descriptions.files import bounds, conversion, meshes, references, xml
from graphengine.descriptions.files.meshes import MeshError
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.mjcf import mjcf_trial
from graphengine.descriptions.robot_description import Link
from graphengine.descriptions.robot_files import default_drives
from graphengine.descriptions.robot_files.robot_file import read_robot
from graphengine.descriptions.sdf import sdf_files, sdf_values
from graphengine.descriptions.sdf.sdf_values import SdfError
from graphengine.descriptions.shapes import Mesh
from graphengine.descriptions.urdf import urdf_reader
from graphengine.descriptions.worlds.mesh_pieces import MeshPieces
from graphengine.descriptions.xacro import absent_packages, dom, xacro
from graphengine.descriptions.xacro.xacro_macros import robot_macros
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.document import Value
from graphengine.format.files import Files
from graphengine.sandbox.confinement import ProcessError
from graphengine.sandbox.untrusted import encoded
from tests.bringup.robots.descriptions import sensor
from tests.bringup.robots.imported_bases import description, imported
from tests.bringup.robots.test_gazebo_sensors import remarks
from tests.descriptions.files.test_meshes import collada, instance
from tests.descriptions.sdf.harness import document, frame, link, model, packages, scope
from tests.limits.table import accepts, limit
from tests.physics.bases import Base, Wheel

SPAN = Span(Source("a", ()), 1, 1)

# Descriptions of robots


@limit("descriptions.robot_files.robot_file.MAX_CHAIN")
def _(robot_files: int, folder: Path) -> bool:
    for number in range(robot_files):
        extends = f"extends: {number + 1}.yaml\n" if number + 1 < robot_files else "urdf: a.urdf\n"
        (folder / f"{number}.yaml").write_text(f"robot: bot\n{extends}", encoding="utf-8")
    return read_robot(folder / "0.yaml", Files.of(folder / "0.yaml"), Findings()) is not None


def parsed(text: str) -> tuple[Any, Findings]:
    findings = Findings()
    return xml.parse(text.encode(), "a.xml", findings, "S103"), findings


@limit("descriptions.link_tree.MAX_LINKS", at=3)
def _(links: int) -> bool:
    elements = "".join(f'<link name="l{number}"/>' for number in range(links))
    root, findings = parsed(f"<robot>{elements}</robot>")
    made = [Link(element.get("name"), element, None, ()) for element in root.children]
    return len(link_tree._by_name(made, "link", findings)) == links and not findings.items


@limit("descriptions.shapes.MAX_COLOUR", step=1e30)
def _(red: float) -> bool:
    root, findings = parsed(f'<robot><material name="m"><color rgba="{red!r} 0 0 1"/></material></robot>')
    urdf_reader.check_numbers(root.children[0], findings)
    return not findings.items


@limit("descriptions.xacro.absent_packages.MAX_NAMED", at=3)
def _(number: int) -> bool:
    findings = Findings()
    absent = [absent_packages.AbsentPackage(f"p{item}", SPAN, []) for item in range(number)]
    absent_packages.report(absent, [], [], findings, failed=True)
    return len(findings.items) == number


@limit("descriptions.xacro.xacro_macros.MAX_PARAMETERS", at=50)
def _(characters: int) -> bool:
    parameters = "a:=1".rjust(characters)
    root, _ = parsed(
        f'<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro name="m" params="{parameters}">'
        '<link name="l"/></xacro:macro></robot>'
    )
    return robot_macros(root)[0].parameters == {"a": "1"}


@limit("descriptions.files.xml.MAX_DEPTH", at=20)
def _(levels: int) -> bool:
    """Levels after expansion by xacro."""
    from xml.dom import minidom

    root = minidom.parseString("<a>" * levels + "</a>" * levels).documentElement
    assert root is not None
    return accepts(lambda: list(dom.elements(root, SPAN)), dom.UnwritableError)


@limit("descriptions.xacro.xacro.MAX_ANSWER", at=1000)
def _(size: int, folder: Path) -> bool:
    answer = encoded(xacro.Expanded([], {}, [], None, [], [], [])).encode().ljust(size)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(xacro, "ask", lambda *_: answer)
        return accepts(lambda: xacro._ask(folder / "a", {}, packages(folder), "", ()), ProcessError)


# Files


@limit("descriptions.files.xml.MAX_BYTES", at=50)
def _(size: int, folder: Path) -> bool:
    (folder / "a.xml").write_text("<a/>".ljust(size), encoding="utf-8")
    return xml.read(folder / "a.xml", Findings(), "S103") is not None


@limit("descriptions.files.xml.MAX_DEPTH", at=20)
def _(levels: int) -> bool:
    return parsed("<a>" * levels + "</a>" * levels)[0] is not None


@limit("descriptions.files.xml.MAX_ELEMENTS", at=20)
def _(elements: int) -> bool:
    return parsed(f"<a>{'<b/>' * (elements - 1)}</a>")[0] is not None


@limit("descriptions.files.bounds.MAX_MEMORY", at=20_000)
def _(size: int) -> bool:
    root, _ = parsed("<mujoco/>")
    return bounds.weigh(root, 0.0, {}, size - bounds.ELEMENT)[1] is None


@limit("descriptions.mjcf.mjcf_trial.MAX_PLAIN_MEMORY", at=20_000)
def _(size: int) -> bool:
    return mjcf_trial.is_plain(parsed("<mujoco/>")[0], size)


@limit("descriptions.files.conversion.MAX_REASON", at=20)
def _(letters: int) -> bool:
    head = json.dumps({"failure": "x" * letters, "files": []}).encode()
    (answer,) = conversion._answers(len(head).to_bytes(8, "little") + head)
    return isinstance(answer, MeshError) and str(answer) == "x" * letters


@limit("descriptions.files.conversion.MAX_HEAD_BYTES", at=100)
def _(size: int) -> bool:
    head = json.dumps({"failure": "", "files": []}).encode().ljust(size)
    return list(conversion._answers(len(head).to_bytes(8, "little") + head)) == [[]]


@limit("descriptions.files.meshes.MAX_STL_TRIANGLES", at=3)
def _(triangles: int) -> bool:
    return not meshes.needs_conversion(bytes(80) + triangles.to_bytes(4, "little") + bytes(50 * triangles), ".stl")


TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@limit("descriptions.files.meshes.MAX_CONVERTED_BYTES", at=100)
def _(size: int) -> bool:
    return accepts(lambda: meshes.convert(TETRAHEDRON.ljust(size, "\n").encode(), ".obj"), MeshError)


@limit("descriptions.files.meshes.MAX_TRIANGLES", at=6)
def _(triangles: int) -> bool:
    """Each use of the geometry has two triangles, as one set of one triangle each."""
    more = "<node>" + instance() + "</node>"
    data = collada(more * (triangles // 2) + more.replace("#g", "#one") * (triangles % 2))
    single = data[data.index(b'<geometry id="g">') : data.index(b"</library_geometries>")]
    single = single.replace(b'"g"', b'"one"').replace(b'"p"', b'"p1"').replace(b'"a"', b'"a1"').replace(b"#a", b"#a1")
    single = single.replace(b"#p", b"#p1").replace(b'"v"', b'"v1"').replace(b"#v", b"#v1")
    single = single[: single.index(b"</triangles>") + 12] + b"</mesh></geometry>"
    data = data.replace(b"</library_geometries>", single + b"</library_geometries>")
    return accepts(lambda: meshes.convert(data, ".dae"), MeshError)


@limit("descriptions.files.meshes.MAX_NODES", at=6)
def _(nodes: int) -> bool:
    """A geometry counts as a node, in the node that has it."""
    data = collada(f"<node>{instance()}</node>" + "<node></node>" * (nodes - 2))
    return accepts(lambda: meshes.convert(data, ".dae"), MeshError)


@limit("descriptions.files.packages.MAX_DEPTH")
def _(levels: int, folder: Path) -> bool:
    place = folder.joinpath("paths", *map(str, range(levels)))
    place.mkdir(parents=True)
    (place / "package.xml").write_text("<package><name>deep</name></package>", encoding="utf-8")
    return Packages(folder, (folder / "paths",), Files((folder,))).find("deep") is not None


@limit("descriptions.files.references.MAX_FILE_BYTES", at=10)
def _(size: int, folder: Path) -> bool:
    (folder / "a").write_bytes(bytes(size))
    return accepts(lambda: Library(Files((folder,)), Findings())._content(folder / "a"), references._UnreadableError)


# SDF


def is_in_scope(folder: Path, content: str) -> bool:
    with contextlib.suppress(SdfError):
        return not scope(folder, document(content))[1].errors
    return False


@limit("descriptions.sdf.sdf_files.MAX_DEPTH")
def _(levels: int, folder: Path) -> bool:
    content = link("l")
    for number in range(levels):
        content = model(content, f"m{number}")
    return is_in_scope(folder, model(content))


@limit("descriptions.sdf.sdf_files.MAX_MODELS", at=4)
def _(models: int, folder: Path) -> bool:
    return is_in_scope(folder, model("".join(model(link("l"), f"m{number}") for number in range(models - 1))))


@limit("descriptions.sdf.sdf_files.MAX_URI", at=20)
def _(letters: int, folder: Path) -> bool:
    text = document(model(link("l"), "other"))
    name = f"{'a' * (letters - 4)}.sdf"
    (folder / name).write_text(text, encoding="utf-8")
    return is_in_scope(folder, model(f"{link('l')}<include><uri>{name}</uri></include>"))


@limit("descriptions.sdf.sdf_files._MAX_MISSING", at=3)
def _(missing: int, folder: Path) -> bool:
    """A model that exists is not found after too many that do not."""
    (folder / "a.sdf").write_text(document(model(link("l"), "other")), encoding="utf-8")
    absent = "".join(f"<include><uri>model://absent{number}</uri></include>" for number in range(missing))
    made, _ = scope(folder, document(model(link("l") + absent + "<include><uri>a.sdf</uri></include>")))
    return "other" in made.models


@limit("descriptions.sdf.sdf_files._MAX_NEIGHBOURS", at=3)
def _(models: int, folder: Path) -> bool:
    for number in range(models):
        (folder / str(number)).mkdir()
        (folder / str(number) / "model.config").touch()
    return len(sdf_files.model_folders(folder / "0" / "model.sdf")) == models


@limit("descriptions.sdf.sdf_frames._MAX_ATTACHED", at=4)
def _(frames: int, folder: Path) -> bool:
    chain = "".join(f'<frame name="f{number}" attached_to="f{number + 1}"/>' for number in range(frames - 1))
    made, _ = scope(folder, document(model(link("l") + f'{chain}<frame name="f{frames - 1}" attached_to="l"/>')))
    return accepts(lambda: frame(made, "f0").link(), SdfError)


@limit("descriptions.sdf.sdf_frames._LONGEST", at=20)
def _(letters: int, folder: Path) -> bool:
    inner = "l" * (letters - 7)
    made, _ = scope(folder, document(model(model(link(inner), "inner"))))
    return made.find(f"inner::{inner}") is not None


@limit("descriptions.sdf.sdf_frames._MAX_COMPARED", at=3)
def _(names: int, folder: Path) -> bool:
    made, _ = scope(folder, document(model("".join(link(f"l{number}") for number in range(names - 1)) + link("wheel"))))
    with contextlib.suppress(SdfError):
        made.require("wheell", made.element)
    try:
        made.require("wheell", made.element)
    except SdfError as error:
        return "did you mean 'wheel'" in repr(vars(error))
    return False


@limit("descriptions.sdf.sdf_values._FARTHEST")
def _(metres: float) -> bool:
    root, _ = parsed(f"<pose>{metres!r} 0 0 0 0 0</pose>")
    return accepts(lambda: sdf_values.pose_of(root), SdfError)


# Importing


@limit("bringup.robots.controllers_file._MOST")
def _(number: float) -> bool:
    controller = controllers_file.Controller("a", "b", SPAN, {"x": Value(SPAN, number)})
    return controller.number("x") == number


@limit("bringup.robots.gazebo_sensors.MAX_SENSORS", at=2)
def _(sensors: int, folder: Path) -> bool:
    many = [sensor("imu_link", min(NO_LIKE), "", name=f"s{number}") for number in range(sensors)]
    return "sensors after the first" not in str(remarks(folder, "lost", *many))


@limit("bringup.robots.gazebo_sensors.MAX_DISTANCE")
def _(metres: float, folder: Path) -> bool:
    inside = f"<pose>{metres!r} 0 0 0 0 0</pose>"
    return "six valid numbers" not in str(remarks(folder, "lost", sensor("imu_link", "imu", inside)))


@limit("bringup.robots.resting.MOST_JOINTS", at=2)
def _(joints: int, folder: Path) -> bool:
    wheels = tuple(Wheel(f"w{number}", 0.3 * number, 0.2) for number in range(joints))
    draft = imported(folder, description(Base("train", wheels, 0.05, 0.03, 5.0))).draft
    return "not simulated on a floor" not in str(draft.noticed)


@limit("descriptions.robot_files.default_drives._MOST", step=1e8)
def _(gain: float) -> bool:
    return default_drives.gain(gain) == gain


@limit("bringup.robots.arm_gains._MOST", step=1e8)
def _(stiffness: float) -> bool:
    joint = SimpleNamespace(effort=stiffness * arm_gains.DEVIATION, losses=(0.0, 0.0), velocity=None)
    return arm_gains._gains(joint, arm_gains.Load(1.0, 1.0, 1.0))[0] == stiffness  # type: ignore[arg-type]


@limit("descriptions.worlds.mesh_pieces.MAX_PLATES", at=8)
def _(triangles: int) -> bool:
    """Two tetrahedra, which together are not convex, and triangles beside them."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    solid = corners[[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]]
    loose = [corners[[0, 1, 2]] + (0, 0, 5 + number) for number in range(triangles - 8)]
    faces = np.concatenate([solid, solid + 5, *[[one] for one in loose]]).astype("<f4")
    rows = b"".join(bytes(12) + face.tobytes() + bytes(2) for face in faces)
    writer, mesh = MeshPieces.__new__(MeshPieces), Mesh("a.stl", (1.0, 1.0, 1.0), parsed("<mesh/>")[0])
    data = bytes(80) + len(faces).to_bytes(4, "little") + rows
    writer.library, writer.findings = SimpleNamespace(assets={"a.stl": data}), Findings()  # type: ignore[assignment]
    return len(writer._plates(SimpleNamespace(key="a.stl"), mesh)) == triangles  # type: ignore[arg-type]
