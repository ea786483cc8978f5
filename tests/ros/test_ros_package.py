"""The package `graphengine_ros` of a ROS workspace: what colcon builds, what the launch file starts, and what its end leaves."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.format.version import __version__
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine_ros.engine import EngineNotFoundError, graphrun_command
from tests.jobs.harness import ROOT
from tests.ros import needs
from tests.waiting import PATIENCE, eventually

PACKAGE = ROOT / "ros" / "graphengine_ros"
RUN_BY = [sys.executable, "-P", "-m", "graphengine.cli"]


def test_the_package_has_the_version_and_the_license_of_the_project() -> None:
    manifest, setup = (PACKAGE / "package.xml").read_text("utf-8"), (PACKAGE / "setup.py").read_text("utf-8")
    assert f"<version>{__version__}</version>" in manifest
    assert f'version="{__version__}"' in setup
    assert "Apache-2.0</license>" in manifest
    assert (PACKAGE / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()


@pytest.fixture
def other(tmp_path: Path) -> str:
    """A Python without graphengine."""
    path = tmp_path / "other" / "bin" / "python"
    path.parent.mkdir(parents=True)
    path.write_text("#!/bin/sh\nexit 1\n", "utf-8")
    path.chmod(0o755)
    return str(path)


def test_the_argument_then_the_variable_selects_the_engine(other: str) -> None:
    assert graphrun_command(sys.executable, {"GRAPHENGINE_PYTHON": other}) == RUN_BY
    assert graphrun_command("", {"GRAPHENGINE_PYTHON": sys.executable, "VIRTUAL_ENV": "/nowhere"}) == RUN_BY


def test_a_given_python_must_have_the_engine(other: str) -> None:
    with pytest.raises(
        EngineNotFoundError, match=f"^python:={re.escape(other)} is not a Python that has graphengine\n"
    ):
        graphrun_command(other, {"GRAPHENGINE_PYTHON": sys.executable})
    with pytest.raises(EngineNotFoundError, match=r"^GRAPHENGINE_PYTHON=/nowhere is not a Python"):
        graphrun_command("", {"GRAPHENGINE_PYTHON": "/nowhere"})


def test_without_both_the_virtual_environment_then_the_path_selects_the_engine(other: str, tmp_path: Path) -> None:
    active, scripts = tmp_path / "active" / "bin", tmp_path / "scripts"
    for folder in (active, scripts):
        folder.mkdir(parents=True)
    (active / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', "utf-8")
    (scripts / "graphrun").write_text("#!/bin/sh\n", "utf-8")
    for script in (active / "python", scripts / "graphrun"):
        script.chmod(0o755)
    environ = {"VIRTUAL_ENV": str(active.parent), "PATH": str(scripts)}
    assert graphrun_command("", environ) == [str(active / "python"), *RUN_BY[1:]]
    environ["VIRTUAL_ENV"] = str(Path(other).parents[1])
    assert graphrun_command("", environ) == [str(scripts / "graphrun")]
    environ["PATH"] = ""
    assert graphrun_command("", environ) == RUN_BY


def test_without_the_engine_the_error_has_a_remedy(other: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", other)
    with pytest.raises(EngineNotFoundError) as raised:
        graphrun_command("", {"PATH": ""})
    assert "graphengine is not found; looked in GRAPHENGINE_PYTHON, VIRTUAL_ENV, graphrun on the PATH" in str(
        raised.value
    )
    assert "~/graphengine/bin/pip install .    # in a checkout" in str(raised.value)
    assert "break-system-packages" not in str(raised.value)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with this package alone, built by colcon."""
    folder = tmp_path_factory.mktemp("workspace")
    shutil.copytree(PACKAGE, folder / "src" / PACKAGE.name)
    subprocess.run(["colcon", "build"], cwd=folder, check=True, capture_output=True)
    return folder


class Workspace:
    """Starts commands in a built workspace and in a domain."""

    def __init__(self, folder: Path, domain_id: int) -> None:
        self.folder = folder
        search = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH", ""))))
        self.environment = {
            **os.environ,
            "PYTHONPATH": search,
            "GRAPHENGINE_PYTHON": sys.executable,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder / "ros_log"),
        }

    def start(self, *command: str) -> subprocess.Popen[str]:
        """Start a command with the workspace sourced, in a session of its own, as a terminal would."""
        return subprocess.Popen(
            ["bash", "-c", '. install/setup.bash && exec "$@"', "bash", *command],
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )


@pytest.fixture
def workspace(built: Path, domain_id: int) -> Workspace:
    return Workspace(built, domain_id)


@contextlib.contextmanager
def launched(workspace: Workspace, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    process = workspace.start("ros2", "launch", "graphengine_ros", "sim.launch.py", "args:=--rays mujoco", *arguments)
    try:
        yield process
    finally:
        for pid in members(process.pid):
            os.kill(pid, signal.SIGKILL)
        process.communicate()


def members(session: int) -> list[int]:
    """The processes of a session that have not ended."""
    found = []
    for folder in Path("/proc").iterdir():
        with contextlib.suppress(OSError, ValueError):
            state, *numbers = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(numbers[2]) == session and state != "Z":
                found.append(int(folder.name))
    return found


@pytest.mark.ros(needs.ros2cli(), needs.program("colcon", "colcon"))
@pytest.mark.parametrize("transport", ["dds", "rclpy"])
class TestLaunch:
    def test_the_launch_file_starts_run_and_robot_state_and_ctrl_c_ends_both(
        self, workspace: Workspace, domain_id: int, transport: str
    ) -> None:
        domain = Domain(domain_id, "LOCALHOST")
        with (
            contextlib.closing(DdsTransport(JoinOptions(domain, "peer"))) as peer,
            launched(workspace, "scene:=dd100_flat", f"transport:={transport}") as process,
        ):
            wanted = {"/clock", "/dd100_0000/odom", "/dd100_0000/robot_description", "/dd100_0000/tf_static"}
            assert eventually(lambda: wanted <= peer.graph().types().keys() or process.poll() is not None)
            assert process.poll() is None, process.communicate()[0]
            described = "/dd100_0000/robot_description"
            assert eventually(lambda: all(publisher.node for publisher in peer.graph().publishers(described)))
            (describing,) = peer.graph().publishers(described)
            assert describing.node in ("robot_state_publisher", "dd100_flat")
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=PATIENCE)[0]
            assert eventually(lambda: not members(process.pid)), said
        assert "Traceback" not in said

    def test_the_launch_file_ends_with_the_run(self, workspace: Workspace, transport: str) -> None:
        with launched(workspace, "scene:=no_such_scene", f"transport:={transport}") as process:
            said = process.communicate(timeout=PATIENCE)[0]
            assert eventually(lambda: not members(process.pid)), said
        assert "no file 'no_such_scene'" in said

    def test_the_launch_file_ends_if_the_scene_lacks_the_robot(self, workspace: Workspace, transport: str) -> None:
        with launched(workspace, "scene:=dd100_flat", "robot:=dd10", f"transport:={transport}") as process:
            said = process.communicate(timeout=PATIENCE)[0]
            assert eventually(lambda: not members(process.pid)), said
        assert "no robot 'dd10' in the scene; robots: dd100" in said


@pytest.mark.ros(needs.ros2cli(), needs.program("colcon", "colcon"))
class TestRun:
    def test_ros2_run_passes_arguments_and_finds_files_of_packages(self, workspace: Workspace) -> None:
        scenes = workspace.folder / "install" / "graphengine_ros" / "share" / "graphengine_ros" / "scenes"
        scenes.mkdir()
        shutil.copy(ROOT / "scenes" / "dd100_flat.yaml", scenes / "mine.yaml")
        for name in ("package://graphengine_ros/scenes/mine.yaml", "graphengine_ros/scenes/mine.yaml"):
            process = workspace.start("ros2", "run", "graphengine_ros", "graphrun", "robots", name)
            said = process.communicate(timeout=PATIENCE)[0]
            assert (process.returncode, "/dd100_0000" in said) == (0, True), said
