"""Files by names that say nothing of the machine, and laid out anew."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from graphengine.format.errors import RecordingError
from graphengine.format.files import Files, shipped
from graphengine.recording import sources
from graphengine.recording.sources import SourceNames, Workspace, media_type


def put(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("x", encoding="utf-8")
    return path


def test_a_file_beside_the_given_file_is_named_after_their_folder(tmp_path: Path) -> None:
    given = put(tmp_path / "alice/hall/scene.yaml")
    names = SourceNames(Files.of(given))
    assert names.name(given) == "project/hall/scene.yaml"
    assert names.name(tmp_path / "alice/hall/robots/a.yaml") == "project/hall/robots/a.yaml"


def test_names_keep_the_positions_of_allowed_folders(tmp_path: Path) -> None:
    given, robot = put(tmp_path / "alice/hall/scene.yaml"), put(tmp_path / "alice/shared/a.yaml")
    names = SourceNames(Files.of(given, [robot.parent]))
    assert names.name(given) == "project/alice/hall/scene.yaml"
    assert names.name(robot) == "project/alice/shared/a.yaml"


def test_included_files_are_named_from_the_package(tmp_path: Path) -> None:
    names = SourceNames(Files.of(put(tmp_path / "scene.yaml")))
    assert names.name(shipped() / "graphs/clock.yaml") == "shipped/graphs/clock.yaml"


def test_an_included_scene_has_no_project_files() -> None:
    given = shipped() / "scenes/dd100_flat.yaml"
    assert SourceNames(Files.of(given)).name(given) == "shipped/scenes/dd100_flat.yaml"


def test_the_recorded_name_of_an_installed_file_is_relative_to_the_share_folder(tmp_path: Path) -> None:
    mesh = put(tmp_path / "ws/install/share/arm/meshes/link.stl")
    names = SourceNames(Files.of(put(tmp_path / "scene.yaml"), installed=[tmp_path / "ws/install/share"]))
    assert names.name(mesh) == "installed/arm/meshes/link.stl"


def test_a_folder_behind_a_link_has_the_name_of_its_target(tmp_path: Path) -> None:
    given = put(tmp_path / "real/scene.yaml")
    (tmp_path / "link").symlink_to(given.parent)
    assert SourceNames(Files.of(given)).name(tmp_path / "link/scene.yaml") == "project/real/scene.yaml"


def test_the_name_of_a_file_outside_all_folders_has_no_path(tmp_path: Path) -> None:
    names = SourceNames(Files.of(put(tmp_path / "hall/scene.yaml")))
    assert names.name(put(tmp_path / "other/secret/b.yaml")) == "project/b.yaml"


def test_undecodable_bytes_in_a_folders_name_are_replaced(tmp_path: Path) -> None:
    given = put(tmp_path / os.fsdecode(b"h\xe4ll") / "scene.yaml")
    assert SourceNames(Files.of(given)).name(given) == "project/h?ll/scene.yaml"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("a/scene.yaml", "application/yaml"),
        ("a/robot.URDF", "application/xml"),
        ("a/mesh.stl", "application/octet-stream"),
    ],
)
def test_files_have_media_types_by_suffix(name: str, expected: str) -> None:
    assert media_type(name) == expected


def test_files_are_extracted_under_their_names(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/hall/scene.yaml", b"scene: a")
    assert workspace.path("project/hall/scene.yaml").read_bytes() == b"scene: a"
    assert workspace.folder / "project/hall/scene.yaml" == workspace.path("project/hall/scene.yaml")


@pytest.mark.parametrize(
    "name",
    [
        "",
        "project",
        "project/../../a",
        "/etc/passwd",
        "../a",
        "elsewhere/a",
        "project/a\0b",
        "project/a\ud800b",
        "project/..",
        "./project/../a",
        "project/" + "d/" * 1500 + "a",
    ],
)
def test_a_name_outside_of_the_workspace_is_refused(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    workspace = Workspace(folder)
    with pytest.raises(RecordingError, match="not a legal name for a file of a recording"):
        workspace.add(name, b"x")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_an_illegal_file_name_is_reported(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/a", b"x")
    with pytest.raises(RecordingError, match="'project/a/b' cannot be extracted"):
        workspace.add("project/a/b", b"x")
    with pytest.raises(RecordingError, match="cannot be extracted: File name too long"):
        workspace.add("project/" + "a" * 300, b"x")


def test_the_number_and_size_of_files_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "MAX_FILES", 2)
    workspace = Workspace(tmp_path)
    for name in ("project/a", "project/b"):
        workspace.add(name, b"")
    with pytest.raises(RecordingError, match="more than 2"):
        workspace.add("project/c", b"")
    monkeypatch.setattr(sources, "MAX_FILES", 10)
    monkeypatch.setattr(sources, "MAX_BYTES", 3)
    with pytest.raises(RecordingError, match="or they are larger than"):
        workspace.add("project/c", b"1234")


def test_files_are_exchanged_within_a_workspace(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/a/x.yaml", b"old")
    workspace.add("project/a/y.yaml", b"gone")
    workspace.add("reloaded/1/project/a/x.yaml", b"new")
    inode = workspace.path("project/a/x.yaml").stat().st_ino
    first = {"project/a/x.yaml": "reloaded/1/project/a/x.yaml", "project/a/y.yaml": None, "project/z": None}
    workspace.exchange(first)
    assert workspace.path("project/a/x.yaml").read_bytes() == b"new"
    assert workspace.path("project/a/x.yaml").stat().st_ino != inode
    assert not workspace.path("project/a/y.yaml").exists()
    workspace.exchange({"project/z": "reloaded/1/project/a/x.yaml"})
    contents = {name: workspace.path(f"project/{name}").read_bytes() for name in ("a/x.yaml", "a/y.yaml", "z")}
    assert contents == {"a/x.yaml": b"old", "a/y.yaml": b"gone", "z": b"new"}
    workspace.exchange(first)
    assert workspace.path("project/a/x.yaml").read_bytes() == b"new"
    assert not workspace.path("project/z").exists()
    with pytest.raises(RecordingError, match="is not a legal name"):
        workspace.exchange({"project/../../a": None})


def test_an_exchange_that_replaces_a_folder_with_a_file_is_an_error(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/x", b"x")
    with pytest.raises(RecordingError, match="'a' cannot be removed"):
        workspace.exchange({"project/a/b": "project/x", "project/a": None})


def test_the_number_and_size_of_copies_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "MAX_FILES", 3)
    monkeypatch.setattr(sources, "MAX_BYTES", 250)
    workspace = Workspace(tmp_path)
    workspace.add("project/x", b"x" * 100)
    for _ in range(5):
        workspace.exchange({"project/a": "project/x", "project/b": "project/x"})
        workspace.exchange({})
    with pytest.raises(RecordingError, match="more than 3 files, or they are larger than"):
        workspace.exchange({f"project/{letter}": "project/x" for letter in "abc"})
