"""Nav2's parameters of real scenes: what they say of the robot, and whether Nav2 knows them."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import graphengine as ge
from graphengine.bringup.nav2.choices import CONTROLLERS, Choices
from graphengine.bringup.nav2.nav2_files import nav2_files
from graphengine.format.errors import UsageError
from graphengine.format.files import find_file
from graphengine.messages.distros import DISTROS
from tests.bringup.nav2 import mobile_bases
from tests.bringup.nav2.known_parameters import known
from tests.other_process import in_another_process

USERS_OF_ODOMETRY = ("bt_navigator", "controller_server", "velocity_smoother")


def files_of(scene: str | Path, **options: Any) -> dict[str, str]:
    """The files for a scene as text, without those of the map."""
    choices = {
        name: options.pop(name) for name in ("distribution", "busy", "controller", "yaw_tolerance") if name in options
    }
    made = nav2_files(ge.load(scene), **{"calibrated": False, "choices": Choices(**choices), **options})
    return {str(path): content.decode() for path, content in made.contents.items() if path.suffix != ".pgm"}


def parameters_of(text: str, namespace: str = "") -> dict[str, Any]:
    """The parameters by node, those of costmaps by the name of the costmap."""
    tree = yaml.safe_load(text)
    for part in filter(None, namespace.split("/")):
        (inner,) = tree.items()
        assert inner[0] == part
        tree = inner[1]
    return {name: node.get(name, node)["ros__parameters"] for name, node in tree.items()}


@pytest.fixture(scope="module")
def dd100() -> dict[str, Any]:
    return parameters_of(files_of("dd100_warehouse")["nav2_params.yaml"], "dd100_0000")


def test_topics_and_frames_come_from_the_scene(dd100: dict[str, Any]) -> None:
    scan = "/dd100_0000/sim_lidar/scan"
    assert dd100["amcl"]["scan_topic"] == scan
    assert dd100["local_costmap"]["obstacle_layer"]["scan"]["topic"] == scan
    assert dd100["collision_monitor"]["scan"]["topic"] == scan
    assert dd100["collision_monitor"]["cmd_vel_out_topic"] == "/dd100_0000/cmd_vel"
    assert {dd100[node]["odom_topic"] for node in USERS_OF_ODOMETRY} == {"/dd100_0000/odom"}
    assert {dd100[node]["robot_base_frame"] for node in ("global_costmap", "local_costmap", "bt_navigator")} == {
        "base_link"
    }
    assert dd100["amcl"]["odom_frame_id"] == dd100["local_costmap"]["global_frame"] == "odom"


def test_the_robot_starts_where_the_scene_puts_it(dd100: dict[str, Any]) -> None:
    pose = dd100["amcl"]["initial_pose"]
    assert (pose["x"], pose["y"]) == pytest.approx((-3.0, 6.0), abs=0.01)
    assert pose["yaw"] == pytest.approx(math.pi / 2, abs=0.01)


def test_limits_come_from_the_controller_in_the_graph(dd100: dict[str, Any]) -> None:
    planner = dd100["controller_server"]["FollowPath"]
    assert (planner["acc_lim_x"], planner["decel_lim_x"], planner["acc_lim_theta"]) == (1.0, -1.0, 2.0)
    assert planner["max_vel_x"] <= 1.3
    assert dd100["velocity_smoother"]["max_velocity"] == [planner["max_vel_x"], 0.0, planner["max_vel_theta"]]


def test_a_robot_that_can_turn_on_the_spot_does_so_before_it_follows_a_new_path(dd100: dict[str, Any]) -> None:
    planner = dd100["controller_server"]["FollowPath"]
    assert planner["plugin"] == "nav2_rotation_shim_controller::RotationShimController"
    assert planner["rotate_to_goal_heading"] is True
    assert planner["primary_controller"] == "dwb_core::DWBLocalPlanner"
    turn = dd100["velocity_smoother"]["max_velocity"][2], dd100["velocity_smoother"]["max_accel"][2]
    assert (planner["rotate_to_heading_angular_vel"], planner["max_angular_accel"]) == turn


def test_a_lower_limit_in_the_graph_lowers_the_speed() -> None:
    scene = ge.load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.4})
    text = nav2_files(scene, calibrated=False).contents[Path("nav2_params.yaml")].decode()
    line = next(line for line in text.splitlines() if "max_vel_x" in line)
    assert line.strip() == "max_vel_x: 0.4  # dd100/cmd_vel/DiffController.maxLinearSpeed"


def test_the_footprint_is_the_outline_of_the_colliders(dd100: dict[str, Any]) -> None:
    corners = yaml.safe_load(dd100["local_costmap"]["footprint"])
    xs, ys = zip(*corners, strict=True)
    assert (max(xs) - min(xs), max(ys) - min(ys)) == pytest.approx((0.552, 0.518), abs=0.01)
    outer = max(math.hypot(x, y) for x, y in corners)
    assert dd100["global_costmap"]["inflation_layer"]["inflation_radius"] > outer


def test_the_footprint_of_a_round_robot_is_a_circle(tmp_path: Path) -> None:
    base = mobile_bases.mecanum(tmp_path)
    base.urdf = base.urdf.replace('<box size="0.2 0.2 0.06"/>', '<cylinder radius="0.35" length="0.06"/>')
    nodes = parameters_of(files_of(base.write().scene)["nav2_params.yaml"])
    for costmap in (nodes["local_costmap"], nodes["global_costmap"]):
        assert costmap["robot_radius"] == pytest.approx(0.35, abs=1e-3)
        assert "footprint" not in costmap
        assert costmap["inflation_layer"]["inflation_radius"] > 0.35


def test_each_value_has_a_comment_with_its_source() -> None:
    for line in files_of("dd100_warehouse")["nav2_params.yaml"].splitlines():
        assert line.endswith(":") or re.search(r"(^|  )# \S", line), line


def test_numbers_with_a_fraction_are_doubles_for_ros(dd100: dict[str, Any]) -> None:
    assert isinstance(dd100["controller_server"]["controller_frequency"], float)
    assert isinstance(dd100["amcl"]["laser_max_range"], float)
    assert dd100["smoother_server"]["simple_smoother"]["tolerance"] == 1e-10


def test_all_nodes_take_the_time_of_the_simulation(dd100: dict[str, Any]) -> None:
    assert all(node["use_sim_time"] is True for node in dd100.values())


def test_lifecycle_managers_start_nodes_that_have_parameters(dd100: dict[str, Any]) -> None:
    for manager in ("lifecycle_manager_localization", "lifecycle_manager_navigation"):
        assert set(dd100[manager]["node_names"]) <= dd100.keys()


MakeBase = Callable[[Path], Any]


@pytest.mark.parametrize("distribution", DISTROS)
@pytest.mark.parametrize("make", [mobile_bases.mecanum, mobile_bases.car])
def test_nav2_of_each_distribution_knows_all_parameters(distribution: str, make: MakeBase, tmp_path: Path) -> None:
    scene = make(tmp_path).write().scene
    for controller in (None, "mppi", "rpp"):
        text = files_of(scene, distribution=distribution, controller=controller)["nav2_params.yaml"]
        for node, parameters in parameters_of(text).items():
            unknown = set(_names(parameters)) - known(distribution, node)
            assert not unknown, f"{node}, {controller}: {unknown}"


def _names(tree: dict[str, Any]) -> Iterator[str]:
    """The names of all parameters, without those of plugins' instances."""
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _names(value)
        else:
            yield name


def test_a_mecanum_base_drives_sideways(tmp_path: Path) -> None:
    nodes = parameters_of(files_of(mobile_bases.mecanum(tmp_path).write().scene)["nav2_params.yaml"])
    planner = nodes["controller_server"]["FollowPath"]
    assert nodes["amcl"]["robot_model_type"] == "nav2_amcl::OmniMotionModel"
    assert (planner["max_vel_x"], planner["max_vel_y"], planner["min_vel_y"]) == (0.6, 0.6, -0.6)
    assert planner["vy_samples"] > 1


def test_paths_for_a_car_respect_its_turning_radius(tmp_path: Path) -> None:
    nodes = parameters_of(files_of(mobile_bases.car(tmp_path).write().scene)["nav2_params.yaml"])
    planner, controller = nodes["planner_server"]["GridBased"], nodes["controller_server"]["FollowPath"]
    assert planner["plugin"] == "nav2_smac_planner::SmacPlannerHybrid"
    assert planner["minimum_turning_radius"] == pytest.approx(1.1 * (0.5 / math.tan(0.5) + 0.2), rel=1e-4)
    assert controller["plugin"].endswith("RegulatedPurePursuitController")
    assert controller["use_rotate_to_heading"] is False


SAFETY = {
    ("collision_monitor", "source_timeout"): (1.0, 5.0),
    ("controller_server", "failure_tolerance"): (0.3, 2.0),
    ("controller_server", "costmap_update_timeout"): (0.3, 2.0),
    ("planner_server", "costmap_update_timeout"): (1.0, 5.0),
    ("lifecycle_manager_navigation", "bond_timeout"): (4.0, 20.0),
}
"""Values of Nav2's own parameter file and node defaults, and the values for a busy machine."""


@pytest.mark.parametrize("busy", [False, True])
def test_safety_values_are_nav2s_defaults_unless_the_machine_is_busy(busy: bool) -> None:
    text = files_of("dd100_flat", busy=busy)["nav2_params.yaml"]
    nodes = parameters_of(text, "dd100_0000")
    assert {key: nodes[key[0]][key[1]] for key in SAFETY} == {key: values[busy] for key, values in SAFETY.items()}
    assert ("--busy" in text) == busy


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_each_controller_respects_the_limits_of_the_robot(controller: str, dd100: dict[str, Any]) -> None:
    text = files_of("dd100_flat", controller=controller)["nav2_params.yaml"]
    nodes = parameters_of(text, "dd100_0000")
    follow = nodes["controller_server"]["FollowPath"]
    speed, _, turn = nodes["velocity_smoother"]["max_velocity"]
    names = {"dwb": ("max_vel_x", "max_vel_theta"), "mppi": ("vx_max", "wz_max")}
    fastest, quickest = names.get(controller, ("desired_linear_vel", "rotate_to_heading_angular_vel"))
    assert (follow[fastest], follow[quickest]) == (speed, turn)
    if controller == "mppi":
        ahead = follow["time_steps"] * follow["model_dt"] * speed
        assert follow["model_dt"] == 1.0 / nodes["controller_server"]["controller_frequency"]
        assert ahead <= follow["prune_distance"] <= nodes["local_costmap"]["width"] / 2


def test_dwb_cannot_drive_a_car(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="which a car cannot do; choose mppi or rpp"):
        files_of(mobile_bases.car(tmp_path).write().scene, controller="dwb")


def test_the_goal_tolerance_of_yaw_is_tight_with_dwb_and_can_be_chosen() -> None:
    def tolerance(**options: Any) -> float:
        nodes = parameters_of(files_of("dd100_flat", **options)["nav2_params.yaml"], "dd100_0000")
        found: float = nodes["controller_server"]["general_goal_checker"]["yaw_goal_tolerance"]
        return found

    assert (tolerance(), tolerance(controller="mppi"), tolerance(yaw_tolerance=0.05)) == (0.1, 0.2, 0.05)


def test_the_speeds_of_a_slow_robot_are_the_speeds_that_it_reaches() -> None:
    scene = ge.load("tutorial/navigation", robot_state=True)
    told, made = (nav2_files(scene, calibrated=calibrated) for calibrated in (False, True))
    limits = [files.robots[0].limits for files in (told, made)]
    assert limits[1].speed.value / limits[0].speed.value == pytest.approx(0.049 / 0.1, abs=0.01)
    assert limits[1].turn.value / limits[0].turn.value == pytest.approx(0.049 / 0.1, abs=0.01)
    assert any("reaches 49 % of a commanded speed" in note for note in made.notes)
    text = made.contents[Path("nav2_params.yaml")].decode()
    assert f"max_vel_x: {limits[1].speed.value:.6g}  # calibration: 49 % of" in text


def test_covariances_that_are_all_zero_are_reported_with_the_remedy(tmp_path: Path) -> None:
    ground_truth = nav2_files(ge.load("dd100_flat"), calibrated=False)
    assert any("/dd100_0000/odom are all zero" in note and "wheel_odometry.yaml" in note for note in ground_truth.notes)
    wheels = nav2_files(ge.load(mobile_bases.mecanum(tmp_path).write().scene), calibrated=False)
    assert not any("all zero" in note for note in wheels.notes)


def test_nav2_uses_the_odometry_of_the_wheels_and_not_the_true_motion(tmp_path: Path) -> None:
    base = mobile_bases.mecanum(tmp_path)
    base.graphs["base"] = "{use: graphs/base/mecanum.yaml, parameters: {odom: odom/unfiltered}}"
    nodes = parameters_of(files_of(base.write().scene)["nav2_params.yaml"])
    assert {nodes[node]["odom_topic"] for node in USERS_OF_ODOMETRY} == {"/odom/unfiltered"}


def test_the_distributions_differ_in_error_codes() -> None:
    for name in DISTROS:
        nodes = parameters_of(files_of("dd100_flat", distribution=name)["nav2_params.yaml"], "dd100_0000")
        assert ("error_code_names" in nodes["bt_navigator"]) == (name == "jazzy")
        assert nodes["controller_server"]["enable_stamped_cmd_vel"] is False


def test_slam_has_neither_a_map_nor_amcl() -> None:
    files = files_of("dd100_flat", slam=True)
    nodes = parameters_of(files["nav2_params.yaml"], "dd100_0000")
    assert "map.yaml" not in files
    assert not {"map_server", "amcl"} & nodes.keys()
    assert nodes["slam_toolbox"]["scan_topic"] == "/dd100_0000/sim_lidar/scan"
    assert "map_saver_cli -t /dd100_0000/map -f map" in files["README.md"]
    assert nodes["planner_server"]["GridBased"]["allow_unknown"] is True


def test_the_same_scene_gives_the_same_bytes_in_another_process() -> None:
    assert in_another_process(files_of, "dd100_flat", calibrated=True) == files_of("dd100_flat", calibrated=True)


@pytest.mark.parametrize("robots", [["dd100"], []])
def test_the_name_of_a_scene_file_is_no_code_of_the_launch_file(tmp_path: Path, robots: list[str]) -> None:
    scene = yaml.safe_load(find_file("dd100_flat").read_text(encoding="utf-8"))
    if not robots:
        scene["robots"]["other"] = {**scene["robots"]["dd100"], "namespace": "other", "position": [0, 3, 0.025]}
    path = tmp_path / 'hall"""; raise SystemExit; """\\x.yaml'
    path.write_text(yaml.safe_dump(scene), encoding="utf-8")
    for name, text in files_of(path, robots=robots).items():
        if name.endswith(".py"):
            docstring, *rest = ast.parse(text).body
            assert isinstance(docstring, ast.Expr)
            assert not any(isinstance(part, ast.Raise | ast.Expr) for part in rest)
