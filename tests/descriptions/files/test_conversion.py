"""Meshes converted in a process of their own: what a file cannot ask for, and which file is blamed."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from graphengine.descriptions.files import conversion
from graphengine.descriptions.files.conversion import Converted, Foreign, convert_all
from graphengine.descriptions.files.meshes import MeshError
from graphengine.sandbox.confinement import ProcessError, ask
from tests.descriptions.files.test_meshes import TWO, collada, exported, gltf, instance

GOOD = collada(f"<node>{instance()}</node>")
WITHOUT_ITS_MATERIAL = collada(f"<node>{instance('red')}</node>")


def glb(count: int) -> bytes:
    """A mesh of so many points, none of which is in the file."""
    accessors = [{"componentType": 5126, "count": count, "type": "VEC3"}]
    return gltf(accessors=accessors, bufferViews=[], meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])


def why(answer: list[Converted] | MeshError) -> str:
    assert isinstance(answer, MeshError)
    return str(answer)


def test_a_visual_becomes_one_mesh_per_colour_and_a_collider_a_single_mesh() -> None:
    files = [Foreign(TWO, ".dae", visual=True), Foreign(TWO, ".dae", visual=False), Foreign(b"", ".dae", visual=True)]
    seen, collided, empty = convert_all([*files])
    assert isinstance(seen, list)
    assert isinstance(collided, list)
    assert [file.colour for file in seen] == [(1, 0, 0, 1), (0, 0, 1, 1)]
    # 3 corners are padded to MuJoCo's 4; counts of vertices, normals, texture coordinates and faces come first
    assert [struct.unpack_from("<4i", file.data) for file in seen] == [(4, 0, 0, 1)] * 2
    assert [(struct.unpack_from("<4i", file.data), file.colour) for file in collided] == [((6, 0, 0, 2), None)]
    assert "no element found" in why(empty)


@pytest.mark.parametrize("encoding", ["ascii", "utf-8", "utf-16", "iso-8859-1", "windows-1252"])
def test_encodings_that_exporters_declare_are_known_without_further_imports(encoding: str) -> None:
    declared = f'<?xml version="1.0" encoding="{encoding}"?>\n' + GOOD.decode().partition("?>")[2]
    (found,) = convert_all([Foreign(declared.encode(encoding), ".dae", visual=True)])
    assert isinstance(found, list)


def test_a_file_cannot_ask_for_more_memory_than_there_is() -> None:
    huge, box = convert_all(
        [Foreign(glb(300_000_000), ".glb", visual=True), Foreign(exported("ply"), ".ply", visual=True)]
    )
    assert "Unable to allocate" in why(huge)
    assert isinstance(box, list)


def test_a_file_that_takes_too_long_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conversion, "MAX_SECONDS", 0.1)
    slow, after = convert_all([Foreign(exported("glb"), ".glb", visual=True), Foreign(GOOD, ".dae", visual=True)])
    assert why(slow) == "reading the file takes more than 0.1 s"
    assert why(after) == "reading an earlier file takes more than 0.1 s"


@pytest.mark.parametrize("lost", [1, 20])
def test_meshes_converted_before_the_process_ended_are_used(monkeypatch: pytest.MonkeyPatch, lost: int) -> None:
    def end_early(module: str, request: bytes, seconds: float) -> bytes:
        raise ProcessError("breaks off", ask(module, request, seconds)[:-lost])

    monkeypatch.setattr(conversion, "ask", end_early)
    first, second, third = convert_all([Foreign(GOOD, ".dae", visual=True)] * 2 + [Foreign(b"", ".dae", visual=True)])
    assert isinstance(first, list)
    assert isinstance(second, list)
    assert why(third) == "reading the file breaks off"


def test_without_files_there_is_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(conversion, "ask")
    assert convert_all([]) == []


SPOILT = [
    b"",
    b"[",
    b"{}",
    b"3",
    b'null, "failure": 3',
    b"[[1, [1, 2, 3, true]]]",
    b"[[1%b, null]]" % (b"0" * 4000),
    b'[["a", null]]',
    b"[[1]]",
    b'[[1, "red"]]',
    b"[[1, [1, 2]]]",
    b"[" * 100_000,
    b"[[1e999, null]]",
]


@pytest.mark.parametrize("line", SPOILT, ids=[line[:12].decode() for line in SPOILT])
def test_a_forged_answer_of_the_process_is_refused(monkeypatch: pytest.MonkeyPatch, line: bytes) -> None:
    told = b'{"failure": "", "files": %b}\n' % line
    frames = (len(told).to_bytes(8, "little") + told) * 9
    monkeypatch.setattr(conversion, "ask", lambda *_: frames)
    (answer,) = convert_all([Foreign(GOOD, ".dae", visual=True)])
    assert why(answer) == "the process that reads the file sends a malformed answer"


CONFINED = """
import sys
sys.argv[:] = ["conversion"]
from graphengine.descriptions.files import conversion, meshes
real = meshes.convert
def convert(data, suffix):
    try:
        open("/etc/passwd")
    except PermissionError:
        return real(data, suffix)
    raise ValueError("a file was read")
meshes.convert = convert
import graphengine.sandbox.confinement as confinement
confinement.check_readable = lambda *_: None
conversion.main()
"""


def test_each_format_is_read_while_no_file_can_be_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "confined.py").write_text(CONFINED, encoding="utf-8")
    monkeypatch.setattr(conversion, "_MODULE", "confined")
    names = {".glb": "glb", ".ply": "ply", ".off": "off", ".stl": "stl_ascii"}
    files = [Foreign(exported(name), suffix, visual=True) for suffix, name in names.items()]
    found = convert_all([*files, *(Foreign(data, ".dae", visual=True) for data in (GOOD, WITHOUT_ITS_MATERIAL))])
    assert [answer for answer in found if not isinstance(answer, list)] == []
