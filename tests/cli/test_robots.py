"""`graphrun robots`: what robot_state_publisher needs for the robots of a scene."""

from __future__ import annotations

import json
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from tests.cli.harness import ROOT, Graphrun

URDF = ROOT / "scenes" / "robots" / "dd100" / "dd100.urdf"


def links(text: str) -> set[str | None]:
    return {link.get("name") for link in ElementTree.fromstring(text).findall("link")}


def test_each_robot_has_its_namespace_and_topics(graphrun: Graphrun) -> None:
    lines = graphrun("robots", "dd100_warehouse", code=0, err="").lines
    assert [line.split() for line in lines[1:]] == [
        ["dd100", "/dd100_0000", "/dd100_0000/platform/joint_states", "/dd100_0000/tf"]
    ]
    assert len(graphrun("robots", "dd100_fleet", code=0).lines) == 11


def test_json_has_the_parameters_of_robot_state_publisher(graphrun: Graphrun) -> None:
    (robot,) = json.loads(graphrun("robots", "dd100_flat", "--format", "json", code=0, err="").out)
    assert links(robot.pop("urdf")) == links(URDF.read_text("utf-8"))
    assert robot == {
        "name": "dd100",
        "namespace": "/dd100_0000",
        "joint_states": "/dd100_0000/platform/joint_states",
        "robot_description": "/dd100_0000/robot_description",
        "tf": "/dd100_0000/tf",
        "tf_static": "/dd100_0000/tf_static",
        "frame_prefix": "",
        "published": False,
    }


def test_json_tells_whether_a_scene_publishes_the_description(graphrun: Graphrun, tmp_path: Path) -> None:
    text = (ROOT / "scenes" / "dd100_flat.yaml").read_text("utf-8")
    assert "    use: " in text
    path = tmp_path / "scene.yaml"
    path.write_text(text.replace("    use: ", "    robot_state: true\n    use: ", 1), "utf-8")
    (robot,) = json.loads(graphrun("robots", str(path), "--format", "json", code=0).out)
    assert robot["published"] is True


def test_the_urdf_of_a_robot_is_printed_alone(graphrun: Graphrun) -> None:
    assert links(graphrun("robots", "dd100_flat", "--urdf", "dd100", code=0, err="").out) == links(
        URDF.read_text("utf-8")
    )
    assert "did you mean 'dd100'?" in graphrun("robots", "dd100_flat", "--urdf", "dd10", code=2, out="").err


@pytest.fixture
def sourced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a sourced workspace, with a scene."""
    package = tmp_path / "install" / "share" / "my_robot"
    (package / "scenes").mkdir(parents=True)
    shutil.copy(ROOT / "scenes" / "dd100_flat.yaml", package / "scenes" / "mine.yaml")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path / 'install'}")
    return package


@pytest.mark.usefixtures("sourced")
@pytest.mark.parametrize("name", ["package://my_robot/scenes/mine.yaml", "my_robot/scenes/mine.yaml"])
def test_a_file_of_a_sourced_package_is_found(graphrun: Graphrun, name: str) -> None:
    assert "/dd100_0000" in graphrun("robots", name, code=0).out


@pytest.mark.usefixtures("sourced")
def test_a_missing_package_or_file_of_a_workspace_gets_a_suggestion(
    graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = graphrun("robots", "package://my_robt/scenes/mine.yaml", code=2, out="").err
    assert "no package 'my_robt'\n  did you mean 'my_robot'?" in package
    file = graphrun("robots", "package://my_robot/scenes/min.yaml", code=2, out="").err
    assert "no file 'scenes/min.yaml' in the package 'my_robot'\n  did you mean" in file
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    unsourced = graphrun("robots", "package://my_robot/scenes/mine.yaml", code=2, out="").err
    assert "no package 'my_robot'\n  no ROS workspace is sourced: source install/setup.bash" in unsourced
