"""Where references between files may lead, and what is told when they lead nowhere."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.format import files
from graphengine.format.errors import UsageError
from graphengine.format.files import Files, NotFoundError, find_file, shipped
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

GRAPH = "graph: inner\nnodes: {Tick: omni.graph.action.OnPlaybackTick}\n"
Refer = Callable[..., list[str]]


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """The folder of the given file, with a neighbour outside of it."""
    folder = tmp_path / "home"
    (folder / "below").mkdir(parents=True)
    (folder / "below" / "inner.yaml").write_text(GRAPH)
    (folder / "inner.yaml").write_text(GRAPH)
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "secret.yaml").write_text(GRAPH)
    return folder


@pytest.fixture
def refer(home: Path) -> Refer:
    """What is told about a graph that refers to a file."""

    def told(reference: str, *allowed: Path) -> list[str]:
        path = home / "given.yaml"
        path.write_text(f"graph: given\nnodes:\n  Inner: {{subgraph: {reference!r}}}\n")
        findings = build.load(path, Options(allowed=allowed)).findings
        return [f"{finding.code} {finding.message}" for finding in findings.errors]

    return told


@pytest.mark.parametrize("reference", ["inner.yaml", "below/inner.yaml", "./inner.yaml", "below/../inner.yaml"])
def test_files_in_the_given_folder_and_below_are_read(reference: str, refer: Refer) -> None:
    assert refer(reference) == []


@pytest.mark.parametrize("reference", ["clock.yaml", "graphs/clock.yaml", "tutorial/clock.yaml"])
def test_included_graphs_are_read(reference: str, refer: Refer) -> None:
    assert refer(reference) == []


def test_a_file_in_the_folder_takes_precedence_over_an_included_file(home: Path) -> None:
    (home / "clock.yaml").write_text(GRAPH)
    assert Files.of(home / "given.yaml").find("clock.yaml", home) == home / "clock.yaml"


def test_files_outside_are_refused(home: Path, refer: Refer) -> None:
    secret = home.parent / "outside" / "secret.yaml"
    (home / "link.yaml").symlink_to(secret)
    (home / "door").symlink_to(secret.parent)
    outside = "../outside/secret.yaml"
    for reference in (outside, str(secret), "link.yaml", "door/secret.yaml", f"below/../{outside}"):
        assert refer(reference) == [f"G214 subgraph: {reference!r} lies outside the folder of the file you gave"]
        assert refer(reference, secret.parent) == []


def test_references_in_a_given_link_start_at_the_link(home: Path) -> None:
    link = home.parent / "outside" / "given.yaml"
    (home / "given.yaml").write_text("graph: given\nnodes:\n  Inner: {subgraph: inner.yaml}\n")
    link.symlink_to(home / "given.yaml")
    told = [finding.message for finding in build.load(link).findings.errors]
    assert told == ["subgraph: no file 'inner.yaml'"]  # it is looked for beside the name that was given


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="other system files")
@pytest.mark.parametrize(
    "reference", ["/etc/passwd", "/dev/zero", "/proc/self/environ", "~/.ssh/id_rsa", "file:///etc/passwd"]
)
def test_system_files_are_not_read(reference: str, refer: Refer) -> None:
    (message,) = refer(reference)
    refusals = f"G214 subgraph: {reference!r} lies outside", f"G214 subgraph: no file {reference!r}"
    assert message.startswith(refusals)


def test_files_of_the_checkout_outside_graphs_and_scenes_are_refused(home: Path) -> None:
    with pytest.raises(NotFoundError, match="lies outside"):
        Files.of(home / "given.yaml").find(str(Path(files.__file__)), home)


@pytest.mark.parametrize("reference", ["", ".", "..", "/", "below", "x" * 300, "y/" * 3000, "a\0b", "inner.yaml/x"])
def test_illegal_file_names_are_not_found(reference: str, home: Path) -> None:
    with pytest.raises(NotFoundError, match="no file"):
        Files.of(home / "given.yaml").find(reference, home)


def help_for(reference: str, home: Path) -> tuple[str, ...]:
    """The advice of the error for a missing file."""
    with pytest.raises(NotFoundError) as missing:
        Files.of(home / "given.yaml").find(reference, home)
    return missing.value.help


def test_similar_names_are_suggested(home: Path) -> None:
    assert help_for("iner.yaml", home)[0] == "did you mean 'inner.yaml'?"
    near, looked = help_for("below/inner.yml", home)
    assert near == "did you mean 'below/inner.yaml'?"
    assert looked == f"looked in {str(home / 'below')!r}, and among the included graphs and scenes"


def test_suggestions_contain_no_names_from_folders_outside(home: Path) -> None:
    assert help_for("../outside/secrets.yaml", home)[0] == ""


def test_a_folder_that_cannot_be_listed_gives_no_suggestion(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert help_for("iner.yaml", home)[0] == ""


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
def test_a_reference_to_a_pipe_is_refused_without_waiting(home: Path, refer: Refer) -> None:
    os.mkfifo(home / "pipe.yaml")
    assert refer("pipe.yaml") == ["G214 subgraph: no file 'pipe.yaml'"]


def test_find_file_finds_files_and_included_names(home: Path) -> None:
    assert find_file(str(home / "inner.yaml")) == home / "inner.yaml"
    assert find_file("dd100/cmd_vel").samefile(shipped() / "graphs" / "dd100" / "cmd_vel.yaml")
    assert find_file("clock.yaml").samefile(shipped() / "graphs" / "clock.yaml")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("dd100/cmdvel", "did you mean 'dd100/cmd_vel'?"),  # not dd100_fleet, a scene
        ("nope.yaml", "YAML files in this folder: demo.yaml, other.yaml"),  # demo.yaml is alike in its ending only
        ("parts/nope.yml", "YAML files in parts: none"),
        ("dmo.yaml", "did you mean 'demo.yaml'?"),
    ],
)
def test_only_files_with_a_similar_name_are_suggested(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, hint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for there in ("demo.yaml", "other.yaml"):
        (tmp_path / there).touch()
    with pytest.raises(UsageError) as missing:
        find_file(name)
    assert str(missing.value) == f"no file {name!r}\n  {hint}"


def test_read_files_are_recorded_in_order(home: Path) -> None:
    found = Files.of(home / "scene.yaml")
    found.find("graphs/clock.yaml", home)
    found.find("graphs/clock.yaml", home)
    other = found.beside(home / "other.yaml")
    with pytest.raises(NotFoundError):
        other.find("nowhere.yaml", home)
    assert list(found.used) == [home / "scene.yaml", shipped() / "graphs/clock.yaml", home / "other.yaml"]
    assert other.used is found.used


def test_included_files_may_be_in_another_folder(home: Path, tmp_path: Path) -> None:
    base = tmp_path / "recorded"
    (base / "graphs").mkdir(parents=True)
    (base / "graphs/clock.yaml").write_text("graph: other\n", encoding="utf-8")
    found = Files.of(home / "scene.yaml", base=base)
    assert found.find("graphs/clock.yaml", home) == base / "graphs/clock.yaml"
    with pytest.raises(NotFoundError, match="no file"):
        found.find("graphs/imu.yaml", home)
    assert not found.may_read(shipped() / "graphs/imu.yaml")


def test_changed_new_and_deleted_files_are_detected(home: Path) -> None:
    given = Files.of(home / "inner.yaml")
    given.find("below/inner.yaml", home)
    with pytest.raises(NotFoundError):
        given.find("later.yaml", home)
    assert given.changed() == set()
    assert set(given.noted()) >= {home / "inner.yaml", home / "below" / "inner.yaml", home / "later.yaml"}
    (home / "inner.yaml").write_text(f"{GRAPH}# longer\n", encoding="utf-8")
    (home / "below" / "inner.yaml").unlink()
    (home / "later.yaml").write_text(GRAPH, encoding="utf-8")
    assert given.changed() == {home / "inner.yaml", home / "below" / "inner.yaml", home / "later.yaml"}


def test_a_reference_that_may_not_be_read_is_not_watched(home: Path) -> None:
    given = Files.of(home / "inner.yaml")
    with pytest.raises(NotFoundError):
        given.find("../outside/none.yaml", home)
    assert home.parent / "outside" / "none.yaml" not in given.noted()
