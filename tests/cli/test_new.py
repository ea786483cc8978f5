"""`graphrun new` writes a project that needs no file outside of its folder, and runs as it is."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

import graphengine as ge
from graphengine.format import distribution
from tests.bringup.robots.imported_arms import PLATE, arm, bolted
from tests.bringup.robots.imported_bases import DIFFERENTIAL, description
from tests.cli.harness import Graphrun
from tests.cli.test_import_urdf import TETRAHEDRON, URDF
from tests.instructions import by_name
from tests.physics.bases import SKID
from tests.physics.mjcf_models import ARM

OTHER = '<visual><geometry><mesh filename="package://lid/meshes/body.obj"/></geometry></visual>'


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Packages with a description of a robot, whose meshes have the same name in two packages."""
    for package in ("cart", "lid"):
        meshes = tmp_path / "ws" / package / "meshes"
        meshes.mkdir(parents=True)
        (meshes / "body.obj").write_text(TETRAHEDRON)
        (meshes.parent / "package.xml").write_text(f"<package><name>{package}</name></package>")
    (tmp_path / "ws/cart/urdf").mkdir()
    (tmp_path / "ws/cart/urdf/cart.urdf").write_text(URDF.replace("  </link>\n", f"    {OTHER}\n  </link>\n", 1))
    monkeypatch.chdir(tmp_path)
    return tmp_path


FROM = ("--from", "ws/cart/urdf/cart.urdf", "--package-path", "ws")


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_a_first_project_drives_the_dingo_with_a_graph_of_its_own(graphrun: Graphrun, workspace: Path) -> None:
    result = graphrun("new", "first", code=0, err="")
    assert result.lines == ["first: a project of 6 files", "next: cd first && graphrun run first.yaml"]
    graph = Path("first/graphs/cmd_vel.yaml")
    graph.write_text(graph.read_text().replace("maxLinearSpeed: 1.3", "maxLinearSpeed: 0.25"))
    with ge.load("first/first.yaml").session() as sim:
        sim.robots["first"].publish("cmd_vel", {"linear": {"x": 1.0}}, every=0.1)
        sim.run(3.0)
        assert sim.robots["first"].velocity.linear[0] == pytest.approx(0.25, rel=0.02)


def test_the_next_command_runs_in_a_shell_for_any_name_of_the_folder(graphrun: Graphrun, workspace: Path) -> None:
    line = graphrun("new", "mein röbot 1", code=0, err="").lines[-1]
    assert line == "next: cd 'mein röbot 1' && graphrun run mein_r_bot_1.yaml"
    command = line.removeprefix("next: ").replace("graphrun run", "ls")
    assert (
        subprocess.run(["sh", "-c", command], check=True, capture_output=True, text=True).stdout
        == "mein_r_bot_1.yaml\n"
    )


def test_a_project_from_a_description_holds_all_its_files(graphrun: Graphrun, workspace: Path) -> None:
    graphrun("new", "cart", *FROM, code=0)
    assert files(workspace / "cart") == [
        "README.md",
        "cart.yaml",
        "graphs/base/differential.yaml",
        "graphs/base/state.yaml",
        "graphs/joint_commands.yaml",
        "graphs/publishers/camera.yaml",
        "graphs/publishers/frame.yaml",
        "requirements.txt",
        "robots/cart.urdf",
        "robots/cart.yaml",
        "robots/cart/meshes/body.obj",
        "robots/lid/meshes/body.obj",
        "robots/meshes/body.obj",
        "ros2_control.xacro",
        "test_robot.py",
    ]
    shutil.rmtree("ws")
    (workspace / "elsewhere").mkdir()
    (workspace / "cart").rename(workspace / "elsewhere/cart")
    assert not graphrun("check", "elsewhere/cart/cart.yaml", code=0).out.startswith("error")
    with ge.load("elsewhere/cart/cart.yaml").session() as sim:
        assert sim.robots["cart"].pose.position[2] > -1.0


@pytest.mark.parametrize("ours", [False, True])
def test_a_project_pins_the_distribution_by_name_only_if_the_name_is_ours(
    graphrun: Graphrun, workspace: Path, monkeypatch: pytest.MonkeyPatch, ours: bool
) -> None:
    monkeypatch.setattr(distribution, "ON_PYPI", ours)
    graphrun("new", "cart", code=0)
    pinned = f"graphrun[view]=={ge.__version__}"
    texts = {path: Path("cart", path).read_text() for path in files(workspace / "cart")}
    assert {path for path, text in texts.items() if by_name(text)} == ({"requirements.txt"} if ours else set())
    first, second = texts["requirements.txt"].splitlines()
    assert (first == pinned, second) == (ours, "pytest")
    by_hand = "    pip install '/path/to/graphengine[view]'    # a checkout of version"
    assert (by_hand in texts["README.md"]) == (not ours)
    assert "\n    pip install -r requirements.txt\n" in texts["README.md"]


def test_the_robot_stands_where_the_world_has_room(graphrun: Graphrun, workspace: Path) -> None:
    graphrun("new", "cart", *FROM, "--world", "warehouse", code=0)
    scene = yaml.safe_load(Path("cart/cart.yaml").read_text())
    assert (scene["world"], scene["robots"]["cart"]["position"]) == ("worlds/warehouse_features.xml", [-3, 6, 0.2])


def test_an_illegal_robot_name_is_corrected_or_refused(graphrun: Graphrun, workspace: Path) -> None:
    graphrun("new", "my-cart", *FROM, code=0)
    assert Path("my-cart/robots/my_cart.yaml").is_file()
    assert "must begin with a letter" in graphrun("new", "2nd", code=2).err


def test_existing_files_are_kept(graphrun: Graphrun, workspace: Path) -> None:
    Path("full").mkdir()
    Path("full/mine.txt").write_text("mine")
    assert "full: this is not an empty folder" in graphrun("new", "full", *FROM, code=2, out="").err
    Path("file").write_text("mine")
    assert "file: this is not an empty folder" in graphrun("new", "file", code=2, out="").err
    assert files(workspace / "full") == ["mine.txt"]


def test_a_description_with_errors_leaves_no_folder(graphrun: Graphrun, workspace: Path) -> None:
    Path("ws/cart/meshes/body.obj").unlink()
    result = graphrun("new", "cart", *FROM, code=1, out="")
    assert "S101" in result.err
    assert result.err.endswith("cart is not written\n")
    assert not Path("cart").exists()


def test_arguments_need_a_description(graphrun: Graphrun, workspace: Path) -> None:
    assert "give one with --from FILE" in graphrun("new", "first", "prefix:=a_", code=2).err


@pytest.mark.parametrize("name", ["null", "true"])
def test_a_yaml_word_is_a_legal_project_name(graphrun: Graphrun, workspace: Path, name: str) -> None:
    for folder, source in ((name, FROM), (f"more/{name}", ())):
        Path(folder).parent.mkdir(exist_ok=True)
        graphrun("new", folder, *source, code=0)
        graphrun("check", f"{folder}/{name}.yaml", code=0)


@pytest.mark.parametrize(
    "reference",
    ["../../../secret.obj", "file://{folder}/secret.obj", "package://cart/meshes/link.obj", "package://../secret.obj"],
)
def test_no_mesh_from_elsewhere_comes_into_a_project(graphrun: Graphrun, workspace: Path, reference: str) -> None:
    (workspace / "secret.obj").write_text(TETRAHEDRON)
    (workspace / "ws/cart/meshes/link.obj").symlink_to(workspace / "secret.obj")
    path = workspace / "ws/cart/urdf/cart.urdf"
    path.write_text(path.read_text().replace("package://lid/meshes/body.obj", reference.format(folder=workspace)))
    result = graphrun("new", "cart", *FROM, code=1)
    assert "secret" in result.err or "link.obj" in result.err
    assert not Path("cart").exists()


def test_a_mesh_in_a_package_of_an_odd_name_stays_in_the_folder_of_meshes(graphrun: Graphrun, workspace: Path) -> None:
    (workspace / "ws/cart/urdf/body.obj").write_text(TETRAHEDRON)
    path = workspace / "ws/cart/urdf/cart.urdf"
    path.write_text(path.read_text().replace("package://lid/meshes/body.obj", "package://../body.obj"))
    graphrun("new", "cart", *FROM, code=0)
    assert "robots/meshes/body.obj" in files(workspace / "cart")
    assert not Path("cart/robots/body.obj").exists()


def pytest_in(folder: str) -> subprocess.CompletedProcess[str]:
    """Run a project's own tests."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def lighter(text: str) -> str:
    """Links that a drive with the default gains holds nearly straight."""
    return text.replace('mass value="0.2"', 'mass value="0.002"')


def test_an_arm_stands_on_a_table_and_reaches_a_pose(graphrun: Graphrun, workspace: Path) -> None:
    Path("arm.urdf").write_text(lighter(bolted(arm(3, "plate", gripper=True))))
    graphrun("new", "arm", "--from", "arm.urdf", code=0, err="")
    scene = yaml.safe_load(Path("arm/arm.yaml").read_text())
    assert (scene["world"], scene["robots"]["arm"]["position"]) == ("worlds/table.xml", [0, 0, 0.75])
    assert (
        "graphrun action send_goal /joint_trajectory_controller/follow_joint_trajectory "
        in Path("arm/README.md").read_text()
    )
    done = pytest_in("arm")
    assert "2 passed" in done.stdout, done.stdout
    robot = Path("arm/robots/arm.yaml")
    robot.write_text(
        robot.read_text().replace("max_velocity: 1.0", "max_velocity: 0.05")
    )  # too slow to be there in time
    assert "1 failed, 1 passed" in pytest_in("arm").stdout


def test_an_arm_of_a_mujoco_model_reaches_a_pose_with_its_own_servos(graphrun: Graphrun, workspace: Path) -> None:
    Path("arm.xml").write_text(ARM)
    graphrun("new", "arm", "--from", "arm.xml", code=0, err="")
    done = pytest_in("arm")
    assert "2 passed" in done.stdout, done.stdout


def test_a_mobile_manipulator_is_driven_and_reaches_a_pose(graphrun: Graphrun, workspace: Path) -> None:
    Path("fetcher.urdf").write_text(lighter(description(DIFFERENTIAL, arm(3, "base_link"))))
    graphrun("new", "fetcher", "--from", "fetcher.urdf", code=0, err="")
    assert yaml.safe_load(Path("fetcher/fetcher.yaml").read_text())["world"] == "worlds/flat_grid.xml"
    done = pytest_in("fetcher")
    assert "3 passed" in done.stdout, done.stdout


def test_legs_hold_their_joints_in_a_flat_hall(graphrun: Graphrun, workspace: Path) -> None:
    legs = "".join(arm(3, "plate", prefix) for prefix in ("fl_", "fr_", "rl_", "rr_"))
    Path("legs.urdf").write_text(f'<robot name="bot">{PLATE}{legs}</robot>')
    graphrun("new", "legs", "--from", "legs.urdf", code=0, err="")
    assert yaml.safe_load(Path("legs/legs.yaml").read_text())["world"] == "worlds/flat_grid.xml"
    done = pytest_in("legs")
    assert "2 passed" in done.stdout, done.stdout


def test_a_project_has_the_joints_of_its_arm_for_ros2_control(graphrun: Graphrun, workspace: Path) -> None:
    Path("arm.urdf").write_text(bolted(arm(2, "plate", gripper=True)))
    graphrun("new", "arm", "--from", "arm.urdf", code=0)
    text = Path("arm/ros2_control.xacro").read_text()
    names = [joint.get("name") for joint in ElementTree.fromstring(text).iter("joint")]
    assert names == ["joint_1", "joint_2", "finger"]  # `other_finger` follows


@pytest.mark.parametrize(("world", "position"), [("table", [-0.9, 0]), ("warehouse", [-3, 6])])
def test_a_mobile_robot_is_placed_beside_the_table(
    graphrun: Graphrun, workspace: Path, world: str, position: list[float]
) -> None:
    graphrun("new", "cart", *FROM, "--world", world, code=0)
    assert yaml.safe_load(Path("cart/cart.yaml").read_text())["robots"]["cart"]["position"][:2] == position


def test_a_skid_steered_robot_has_the_track_with_which_it_turns_as_commanded(
    graphrun: Graphrun, workspace: Path
) -> None:
    (workspace / "rover.urdf").write_text(SKID.urdf(), encoding="utf-8")
    made = graphrun("new", "rover", "--from", "rover.urdf", code=0)
    (line,) = [line for line in made.lines if line.startswith("track: ")]
    track = yaml.safe_load((workspace / "rover/robots/rover.yaml").read_text(encoding="utf-8"))["graphs"]["base"][
        "parameters"
    ]["track"]
    assert line.startswith(f"track: {track:.4g} m, with which the robot turns as commanded on arcs of 0.15 m/s")
    assert graphrun("check", "rover").code == 0
