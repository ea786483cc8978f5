"""`graphrun nav2 files`: the folder that it writes, and what it says of robots that Nav2 cannot drive."""

from __future__ import annotations

import importlib.util
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.bringup.maps.map_server import read_map
from tests.bringup.nav2 import mobile_bases
from tests.cli.harness import Graphrun

NAMES = {"README.md", "map.pgm", "map.yaml", "nav2.launch.py", "nav2_params.yaml", "view.rviz"}


def test_one_robot_has_all_files_in_the_folder(graphrun: Graphrun, tmp_path: Path) -> None:
    result = graphrun("nav2", "files", "dd100_warehouse", "-o", str(tmp_path / "nav"), "--no-calibrate", code=0)
    assert {path.name for path in (tmp_path / "nav").iterdir()} == NAMES
    assert result.lines[0].startswith("dd100: differential, turns on the spot, 1.00 m/s")
    assert len((tmp_path / "nav/README.md").read_text(encoding="utf-8").splitlines()) <= 12


def test_the_map_has_the_robot_in_free_space_and_walls_at_the_height_of_the_scan(
    graphrun: Graphrun, tmp_path: Path
) -> None:
    graphrun("nav2", "files", "dd100_warehouse", "-o", str(tmp_path), "--no-calibrate", code=0)
    found = read_map(tmp_path / "map.yaml")
    assert found.data[found.cell(-3.0, 6.0)] == 0
    assert (found.data == 100).any()


def test_a_fleet_has_a_folder_for_each_robot_and_one_map(graphrun: Graphrun, tmp_path: Path) -> None:
    graphrun("nav2", "files", "dd100_fleet", "-o", str(tmp_path), "--no-calibrate", code=0)
    folders = sorted(path.name for path in tmp_path.iterdir() if path.is_dir())
    assert folders == [f"dd100_{number:04}" for number in range(10)]
    assert {path.name for path in tmp_path.iterdir() if path.is_file()} == NAMES - {"nav2_params.yaml", "view.rviz"}
    for name in folders:
        text = (tmp_path / name / "nav2_params.yaml").read_text(encoding="utf-8")
        assert list(yaml.safe_load(text)) == [name]
        assert f"/{name}/cmd_vel " in text
        assert 'HERE.parent / "map.yaml"' in (tmp_path / name / "nav2.launch.py").read_text(encoding="utf-8")


def test_the_next_commands_are_quoted_for_a_shell(graphrun: Graphrun, tmp_path: Path) -> None:
    result = graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path / "my nav"), "--no-calibrate", code=0)
    launch = shlex.split(result.lines[-1].removeprefix("with ROS 2: "))
    assert launch == ["ros2", "launch", str(tmp_path / "my nav/nav2.launch.py"), "rviz:=true"]


def test_launch_files_are_python(graphrun: Graphrun, tmp_path: Path) -> None:
    for options in ((), ("--slam",)):
        graphrun("nav2", "files", "dd100_fleet", "-o", str(tmp_path), "--no-calibrate", "--force", *options, code=0)
        for path in tmp_path.rglob("*.launch.py"):
            compile(path.read_bytes(), str(path), "exec")


def launched(folder: Path) -> Any:
    """The launch file of a folder as a Python module."""
    spec = importlib.util.spec_from_file_location("launched", folder / "nav2.launch.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("given", "shown"), [("true", "dd100_0000"), ("false", ""), ("dd100_0003", "dd100_0003")])
def test_a_fleet_has_one_rviz(given: str, shown: str, graphrun: Graphrun, tmp_path: Path) -> None:
    launch = pytest.importorskip("launch.launch_context")
    graphrun("nav2", "files", "dd100_fleet", "-o", str(tmp_path), "--no-calibrate", code=0)
    module = launched(tmp_path)
    context = launch.LaunchContext()
    context.launch_configurations["rviz"] = given
    values = {robot: module.shown(robot).perform(context) for robot in module.ROBOTS}
    assert values == {robot: "true" if robot == shown else "false" for robot in module.ROBOTS}


@pytest.mark.parametrize("options", [(), ("--slam",)])
def test_ros_loads_the_launch_file(options: tuple[str, ...], graphrun: Graphrun, tmp_path: Path) -> None:
    pytest.importorskip("launch_ros")
    graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path), "--no-calibrate", *options, code=0)
    module = launched(tmp_path)
    names = {argument.name for argument in module.generate_launch_description().get_launch_arguments()}
    own = {"namespace", "params_file", "use_sim_time", "autostart", "use_respawn", "log_level", "rviz"}
    assert names == own | (set() if options else {"map", "localization"})


@pytest.mark.parametrize("own", ["dd100_0000", ""])
def test_another_namespace_moves_nodes_topics_and_parameters(
    own: str, graphrun: Graphrun, base: Any, tmp_path: Path
) -> None:
    launch = pytest.importorskip("launch")
    pytest.importorskip("launch_ros")
    scene = "dd100_flat" if own else str(base.write().scene)
    graphrun("nav2", "files", scene, "-o", str(tmp_path), "--no-calibrate", code=0)
    module = launched(tmp_path)
    assert own == module.NAMESPACE
    context = launch.LaunchContext()
    for argument in module.generate_launch_description().get_launch_arguments():
        argument.execute(context)
    file = str(tmp_path / "nav2_params.yaml")
    assert module.parameters_in(own, file) == file
    context.launch_configurations["namespace"] = "a/b"
    nodes = [node for node in module.nodes(context) if "nav2" in str(node.node_package)]
    assert len(nodes) == 13
    tree = yaml.safe_load(Path(module.parameters_in("a/b", file)).read_text(encoding="utf-8"))["a"]["b"]
    before = yaml.safe_load(Path(file).read_text(encoding="utf-8"))
    before = before[own] if own else before
    scan = before["amcl"]["ros__parameters"]["scan_topic"]
    assert tree["amcl"]["ros__parameters"]["scan_topic"] == "/a/b" + scan.removeprefix(f"/{own}" if own else "")
    assert tree.keys() == before.keys()


def test_rviz_shows_topics_of_the_robot(graphrun: Graphrun, tmp_path: Path) -> None:
    graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path), "--no-calibrate", code=0)
    content = yaml.safe_load((tmp_path / "view.rviz").read_text(encoding="utf-8"))["Visualization Manager"]
    topics = {one["Topic"]["Value"] for one in [*content["Displays"], *content["Tools"]] if "Topic" in one}
    assert "/dd100_0000/sim_lidar/scan" in topics
    assert "/dd100_0000/goal_pose" in topics
    (model,) = [one for one in content["Displays"] if one["Name"] == "Robot"]
    assert model["Description Topic"]["Value"] == "/dd100_0000/robot_description"
    assert content["Global Options"]["Fixed Frame"] == "map"


def test_existing_files_are_kept_without_force(graphrun: Graphrun, tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("mine\n", encoding="utf-8")
    refused = graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path), "--no-calibrate", code=2)
    assert "map.yaml: existing files are overwritten only with --force" in refused.err
    assert [path.name for path in tmp_path.iterdir()] == ["map.yaml"]
    graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path), "--no-calibrate", "--force", code=0)


def test_a_world_without_obstacles_has_an_empty_map_and_a_note(graphrun: Graphrun, tmp_path: Path) -> None:
    result = graphrun("nav2", "files", "dd100_flat", "-o", str(tmp_path), "--no-calibrate", code=0)
    assert "note: the map is empty, 10 m around the robots" in result.err


@pytest.fixture
def base(tmp_path: Path) -> Any:
    return mobile_bases.mecanum(tmp_path / "base")


def refusal(graphrun: Graphrun, base: Any, code: int = 2) -> str:
    out = base.folder / "out"
    result = graphrun("nav2", "files", str(base.write().scene), "-o", str(out), "--no-calibrate", code=code)
    assert not out.exists()
    return result.err


def test_the_error_for_a_robot_without_a_lidar_has_yaml_lines_to_add(graphrun: Graphrun, base: Any) -> None:
    base.keys = ""
    base.graphs = {"base": base.graphs["base"]}
    told = refusal(graphrun, base)
    assert "bot: Nav2 cannot drive this robot\n  no sensor_msgs/LaserScan: add a lidar to bot.yaml, such as\n" in told
    lines = told.splitlines()
    added = yaml.safe_load("\n".join(line[4:] for line in lines[lines.index("    sensors:") :]))
    base.keys = yaml.safe_dump({"sensors": added["sensors"]})
    base.graphs["scan"] = str(added["graphs"]["scan"])
    graphrun("nav2", "files", str(base.write().scene), "-o", str(base.folder / "out"), "--no-calibrate", code=0)


def test_a_robot_with_points_only_gets_advice_on_how_to_get_a_scan(graphrun: Graphrun, base: Any) -> None:
    base.keys = base.keys.replace("lidar_360", "lidar_3d_16")
    base.graphs["scan"] = base.graphs["scan"].replace("scan.yaml", "points.yaml")
    told = refusal(graphrun, base)
    assert "is a PointCloud2; publish a scan with ROS2RtxLidarHelper" in told
    assert "pointcloud_to_laserscan" in told


def test_a_robot_without_drive_and_odometry_is_refused_with_both_reasons(graphrun: Graphrun, base: Any) -> None:
    del base.graphs["base"]
    told = refusal(graphrun, base)
    assert "no topic takes velocities: subscribe to cmd_vel with ROS2SubscribeTwist" in told
    assert "no nav_msgs/Odometry: publish it with ROS2PublishOdometry" in told


def test_a_scan_whose_frame_hangs_in_the_air_is_refused(graphrun: Graphrun, base: Any) -> None:
    base.graphs["scan"] = base.graphs["scan"].replace("frame: lidar", "frame: laser")
    assert "no transform from 'base_link' to 'laser', the frame of /scan" in refusal(graphrun, base)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("dd100_flat", "--robot", "dd10"), "no robot 'dd10'"),
        (("dd100/cmd_vel",), "there is no robot to navigate"),
        (("dd100_flat", "--distro", "humble"), "invalid choice: 'humble'"),
        (("dd100_flat", "--controller", "teb"), "invalid choice: 'teb'"),
        (("dd100_flat", "--yaw-tolerance", "0deg"), "--yaw-tolerance: expected a number above 0, got 0"),
    ],
)
def test_mistakes_are_explained(arguments: tuple[str, ...], told: str, graphrun: Graphrun, tmp_path: Path) -> None:
    assert told in graphrun("nav2", "files", *arguments, "-o", str(tmp_path / "out"), code=2).err


def test_help_imports_nothing_heavy(graphrun: Graphrun) -> None:
    graphrun("nav2", "files", "--help", code=0)
    assert "graphengine.cli.nav2.files" in sys.modules
