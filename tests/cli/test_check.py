"""`graphrun check`: every mistake of every file, for people and for machines."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tests.cli.harness import GRAPHS, SCENES, Graphrun

SPEEDY = "graph: speedy\nnodes:\n  Tick: OnPlaybackTick\n  Idle: PublishClock\n"  # a warning: nothing reaches Idle


@pytest.fixture
def warned(project: Path) -> str:
    (project / "warned.yaml").write_text(SPEEDY, encoding="utf-8")
    return "warned.yaml"


@pytest.fixture
def broken(project: Path) -> str:
    text = (project / "mine.yaml").read_text(encoding="utf-8")
    text = text.replace("topicName", "topicname").replace("Tick.tick ->", "Tick.tack ->")
    (project / "broken.yaml").write_text(text, encoding="utf-8")
    return "broken.yaml"


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_that_ships_checks_without_an_error(graphrun: Graphrun, name: str) -> None:
    result = graphrun("check", name, code=0, err="")
    assert " error " not in result.out
    assert result.lines[-1].startswith("1 file, ")
    if not name.startswith("tutorial"):
        assert result.lines[-1].endswith(": 0 errors, 0 warnings")


@pytest.mark.parametrize("name", GRAPHS)
def test_an_included_graph_has_no_errors_alone_or_in_a_scene(graphrun: Graphrun, name: str) -> None:
    alone = graphrun("check", name)
    assert (alone.code, alone.lines[-1]) == (0, "1 file, 1 graph: 0 errors, 0 warnings")
    if not name.startswith(
        ("arm/", "base/", "joint_", "legs/", "publishers/")
    ):  # whose parameters name no robot of ours
        assert graphrun("check", name, "--scene", "tutorial/navigation").code == 0


def test_all_shipped_files_pass_one_check(graphrun: Graphrun) -> None:
    result = graphrun("check", *SCENES, *GRAPHS, code=0)
    assert result.lines[-1].startswith(f"{len(SCENES) + len(GRAPHS)} files, ")
    assert result.lines[-1].endswith(": 0 errors, 3 warnings")  # each once: W201, and W203 with and without a namespace


def test_warnings_are_errors_when_strict(graphrun: Graphrun, warned: str) -> None:
    lenient, strict = graphrun("check", warned), graphrun("check", warned, "--strict")
    assert (lenient.code, strict.code) == (0, 1)
    assert lenient.out == strict.out
    assert lenient.lines[-1] == "1 file, 1 graph: 0 errors, 1 warning"


def test_notes_are_no_errors_when_strict(graphrun: Graphrun) -> None:
    result = graphrun("check", "dd100/joint_states", "--strict", code=0)
    assert " note N" in result.out


def test_every_error_is_printed_with_its_span_on_standard_output(graphrun: Graphrun, broken: str) -> None:
    result = graphrun("check", broken, code=1, err="")
    assert [line for line in result.lines if " error " in line] == [
        "broken.yaml:8:14: error G204: ROS2PublishClock has no input 'topicname'",
        "broken.yaml:10:5: error G204: OnPlaybackTick has no output 'tack'",
    ]
    assert result.out.count("did you mean 'topicName'?") == 1
    assert result.lines[-1].startswith("1 file, 1 graph: 2 errors, ")


def test_json_names_each_finding_with_file_line_and_remedy(graphrun: Graphrun, broken: str) -> None:
    result = graphrun("check", broken, "--format", "json", code=1, err="")
    findings = [finding for finding in json.loads(result.out) if finding["severity"] == "error"]
    assert [(f["code"], f["path"], f["line"], f["column"]) for f in findings] == [
        ("G204", "broken.yaml", 8, 14),
        ("G204", "broken.yaml", 10, 5),
    ]
    assert findings[0]["message"] == "ROS2PublishClock has no input 'topicname'"
    assert findings[0]["help"] == ["did you mean 'topicName'?"]
    assert findings[0]["length"] == len("topicname")


def test_json_of_files_without_a_finding_is_an_empty_list(graphrun: Graphrun, project: Path) -> None:
    assert json.loads(graphrun("check", "mine.yaml", "--format", "json").out) == []


def test_findings_of_several_files_are_merged_without_repetition(
    graphrun: Graphrun, project: Path, warned: str, broken: str
) -> None:
    result = graphrun("check", "mine.yaml", warned, broken, broken, "--format", "json", code=1)
    paths = [finding["path"] for finding in json.loads(result.out) if finding["severity"] != "note"]
    assert paths[:3] == [warned, broken, broken]
    assert len(paths) == len({(f["path"], f["line"], f["code"], f["message"]) for f in json.loads(result.out)})


def test_a_missing_file_is_a_usage_error(graphrun: Graphrun, broken: str) -> None:
    result = graphrun("check", broken, "dd100_warehose", code=2, out="")
    assert result.err == "graphrun check: no file 'dd100_warehose'\n  did you mean 'dd100_warehouse'?\n"


@pytest.mark.parametrize(("name", "near"), [("mine.yml", "mine.yaml"), ("./mien.yaml", "./mine.yaml")])
def test_a_misspelt_file_name_gets_a_suggestion_from_the_same_folder(
    graphrun: Graphrun, project: Path, name: str, near: str
) -> None:
    assert graphrun("check", name).err == f"graphrun check: no file {name!r}\n  did you mean {near!r}?\n"


def test_a_name_without_similar_names_gets_a_list_of_shipped_files(graphrun: Graphrun) -> None:
    first, scenes, graphs = graphrun("check", "xyzzy").err.splitlines()
    assert first == "graphrun check: no file 'xyzzy'"
    assert scenes.startswith("  scenes that ship: ")
    assert set(SCENES) <= set(scenes.removeprefix("  scenes that ship: ").split(", "))
    assert graphs == f"  graphs that ship: {', '.join(GRAPHS)}"


def test_a_file_may_name_only_what_lies_beside_it_unless_allowed(graphrun: Graphrun, project: Path) -> None:
    (project / "far").mkdir()
    (project / "near").mkdir()
    (project / "mine.yaml").rename(project / "far/mine.yaml")
    scene = "scene: s\nworld: worlds/flat_grid.xml\ngraphs:\n  clock: {use: ../far/mine.yaml}\n"
    (project / "near/scene.yaml").write_text(scene, encoding="utf-8")
    refused = graphrun("check", "near/scene.yaml", code=1)
    assert f"allow it with --allow {project / 'far'}" in refused.out
    assert graphrun("check", "near/scene.yaml", "--allow", "far").code == 0


def test_the_option_that_allows_a_folder_can_be_copied_to_a_shell(graphrun: Graphrun, project: Path) -> None:
    (project / "far away; ls").mkdir()
    (project / "near").mkdir()
    (project / "mine.yaml").rename(project / "far away; ls/mine.yaml")
    scene = "scene: s\nworld: worlds/flat_grid.xml\ngraphs:\n  clock: {use: '../far away; ls/mine.yaml'}\n"
    (project / "near/scene.yaml").write_text(scene, encoding="utf-8")
    remedy = next(line for line in graphrun("check", "near/scene.yaml").lines if "allow it with " in line)
    assert graphrun("check", "near/scene.yaml", *shlex.split(remedy.partition("with ")[2])).code == 0


@pytest.fixture
def robots(project: Path) -> Path:
    """A folder with one file of each kind, of which the scene uses all but `alone`."""
    folder = project / "mine"
    (folder / "robots").mkdir(parents=True)
    scene = (
        "scene: s\nworld: worlds/flat_grid.xml\nrobots: {r: {use: robots/used.yaml}}\ngraphs: {g: {use: used.yaml}}\n"
    )
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    (folder / "used.yaml").write_text("graph: g\nnodes:\n  T: OnPlaybackTick\n", encoding="utf-8")
    (folder / "alone.yml").write_text("graph: g\nnodes:\n  T: OnPlaybackTik\n", encoding="utf-8")
    urdf = '<robot name="r"><link name="base"><inertial><mass value="1"/>{}</inertial></link></robot>'
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    (folder / "robots/r.urdf").write_text(urdf.format(inertia), encoding="utf-8")
    (folder / "robots/used.yaml").write_text("robot: r\nurdf: r.urdf\nbase_link: base\n", encoding="utf-8")
    wrong = "robot: r\nurdf: r.urdf\nbase_link: base\njoints: {wheel: {}}\n"
    (folder / "robots/alone.yaml").write_text(wrong, encoding="utf-8")
    (folder / "map.yaml").write_text("image: map.png\nresolution: 0.05\n", encoding="utf-8")
    (folder / ".hidden").mkdir()
    (folder / ".hidden/bad.yaml").write_text("graph: [\n", encoding="utf-8")
    return folder


def test_of_a_folder_every_scene_robot_and_graph_is_checked(graphrun: Graphrun, robots: Path) -> None:
    result = graphrun("check", "mine", code=1)
    found = [line.partition(": error ") for line in result.lines if ": error " in line]
    assert [(place, what[:4]) for place, _, what in found] == [
        ("mine/robots/alone.yaml:4:10", "S104"),
        ("mine/alone.yml:3:6", "G201"),
    ]
    assert result.lines[-1] == "5 files, 2 graphs: 2 errors, 0 warnings"
    for alone in ("alone.yml", "robots/alone.yaml"):
        (robots / alone).unlink()
    assert graphrun("check", "mine").lines[-1] == "3 files, 1 graph: 0 errors, 0 warnings"


def test_yaml_of_a_folder_that_cannot_be_read_is_an_error_and_a_folder_without_files_a_mistake(
    graphrun: Graphrun, robots: Path
) -> None:
    (robots / "broken.yaml").write_text("graph: [\n", encoding="utf-8")
    assert "mine/broken.yaml:2:1: error G102" in graphrun("check", "mine").out
    (robots / "empty").mkdir()
    result = graphrun("check", "mine/empty", code=2, out="")
    assert "mine/empty: no scene, robot or graph file in this folder" in result.err
