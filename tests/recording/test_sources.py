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


def test_a_file_beside_the_given_one_has_the_name_of_their_folder(tmp_path: Path) -> None:
    given = put(tmp_path / "alice/hall/scene.yaml")
    names = SourceNames(Files.of(given))
    assert names.name(given) == "project/hall/scene.yaml"
    assert names.name(tmp_path / "alice/hall/robots/a.yaml") == "project/hall/robots/a.yaml"


def test_folders_that_were_allowed_keep_their_place_beside_the_given_file(tmp_path: Path) -> None:
    given, robot = put(tmp_path / "alice/hall/scene.yaml"), put(tmp_path / "alice/shared/a.yaml")
    names = SourceNames(Files.of(given, [robot.parent]))
    assert names.name(given) == "project/alice/hall/scene.yaml"
    assert names.name(robot) == "project/alice/shared/a.yaml"


def test_what_ships_is_named_from_where_it_ships(tmp_path: Path) -> None:
    names = SourceNames(Files.of(put(tmp_path / "scene.yaml")))
    assert names.name(shipped() / "graphs/clock.yaml") == "shipped/graphs/clock.yaml"


def test_a_scene_that_ships_has_no_project() -> None:
    given = shipped() / "scenes/dd100_flat.yaml"
    assert SourceNames(Files.of(given)).name(given) == "shipped/scenes/dd100_flat.yaml"


def test_an_installed_package_is_named_from_its_share(tmp_path: Path) -> None:
    mesh = put(tmp_path / "ws/install/share/arm/meshes/link.stl")
    names = SourceNames(Files.of(put(tmp_path / "scene.yaml"), installed=[tmp_path / "ws/install/share"]))
    assert names.name(mesh) == "installed/arm/meshes/link.stl"


def test_a_folder_behind_a_link_is_named_by_what_it_is(tmp_path: Path) -> None:
    given = put(tmp_path / "real/scene.yaml")
    (tmp_path / "link").symlink_to(given.parent)
    assert SourceNames(Files.of(given)).name(tmp_path / "link/scene.yaml") == "project/real/scene.yaml"


def test_a_file_apart_from_all_roots_says_nothing_of_its_place(tmp_path: Path) -> None:
    names = SourceNames(Files.of(put(tmp_path / "hall/scene.yaml")))
    assert names.name(put(tmp_path / "other/secret/b.yaml")) == "project/b.yaml"


def test_a_folder_whose_name_is_no_text_has_one_that_is(tmp_path: Path) -> None:
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
def test_kinds_of_files_are_told_apart(name: str, expected: str) -> None:
    assert media_type(name) == expected


def test_files_are_laid_out_by_their_names(tmp_path: Path) -> None:
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
def test_a_name_that_leads_elsewhere_is_refused(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "inner"
    folder.mkdir()
    workspace = Workspace(folder)
    with pytest.raises(RecordingError, match="not a legal name for a file of a recording"):
        workspace.add(name, b"x")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_name_that_no_file_can_have_is_told(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/a", b"x")
    with pytest.raises(RecordingError, match="'project/a/b' cannot be extracted"):
        workspace.add("project/a/b", b"x")
    with pytest.raises(RecordingError, match="cannot be extracted: File name too long"):
        workspace.add("project/" + "a" * 300, b"x")


def test_the_number_of_files_and_their_size_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_an_exchange_that_makes_a_folder_of_a_file_is_told(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.add("project/x", b"x")
    with pytest.raises(RecordingError, match="'a' cannot be removed"):
        workspace.exchange({"project/a/b": "project/x", "project/a": None})


def test_the_copies_of_exchanged_files_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "MAX_FILES", 3)
    monkeypatch.setattr(sources, "MAX_BYTES", 250)
    workspace = Workspace(tmp_path)
    workspace.add("project/x", b"x" * 100)
    for _ in range(5):
        workspace.exchange({"project/a": "project/x", "project/b": "project/x"})
        workspace.exchange({})
    with pytest.raises(RecordingError, match="more than 3 files, or they are larger than"):
        workspace.exchange({f"project/{letter}": "project/x" for letter in "abc"})
