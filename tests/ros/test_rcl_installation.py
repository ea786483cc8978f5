"""Whether rclpy can be used, from files and variables: these installations end the process that imports one of their modules."""

from __future__ import annotations

import importlib.machinery
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from graphengine.format.errors import TransportError
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.rcl import installation
from graphengine.ros.transports.select import open_transport
from tests.jobs.harness import ROOT

LOADED = importlib.machinery.EXTENSION_SUFFIXES[0]
OF_ANOTHER_PYTHON = ".cpython-39-sparc64-linux-gnu.so"
FAST, CYCLONE = "rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"

Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Lays an installation of ROS 2 on the path of modules and on that of libraries, in place of any other."""
    for name in [name for name in sys.modules if name.partition(".")[0] in ("rclpy", "rcl_interfaces", "std_msgs")]:
        monkeypatch.delitem(sys.modules, name)
    others = [folder for folder in sys.path if not (Path(folder) / "rclpy").is_dir()]
    for name in ("RMW_IMPLEMENTATION", "RCL_ASSERT_RMW_ID_MATCHES", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    modules, libraries = tmp_path / "site-packages", tmp_path / "lib"

    def install(
        *packages: str, suffix: str = LOADED, rmws: tuple[str, ...] = (FAST,), program: str = "os._exit(102)"
    ) -> None:
        for package in packages:
            (modules / package).mkdir(parents=True)
            (modules / package / "__init__.py").write_text(f"import os\n{program}\n", encoding="utf-8")
        if suffix:
            (modules / "rclpy" / f"_rclpy_pybind11{suffix}").touch()
        libraries.mkdir()
        for library in ("rcl", *rmws):
            (libraries / f"lib{library}.so").touch()
        monkeypatch.setattr(sys, "path", [str(modules), *others])
        monkeypatch.setattr(sys, "prefix", str(tmp_path / "conda"))
        monkeypatch.setenv("LD_LIBRARY_PATH", f"/nowhere{os.pathsep}{libraries}")

    return install


SOURCED = ("rclpy", "rcl_interfaces", "std_msgs")
WHEELS = (*SOURCED, "ros_wheels_bootstrapper")


@pytest.mark.parametrize("packages", [SOURCED, WHEELS], ids=["sourced", "wheels"])
def test_a_complete_installation_has_no_obstacle(install: Install, packages: tuple[str, ...]) -> None:
    install(*packages)
    assert installation.missing() is None


def test_without_a_name_any_rmw_is_accepted_but_a_named_rmw_must_exist(
    install: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(*SOURCED, rmws=(CYCLONE,))
    assert installation.missing() is None
    monkeypatch.setenv("RMW_IMPLEMENTATION", CYCLONE)
    assert installation.missing() is None
    monkeypatch.setenv("RMW_IMPLEMENTATION", FAST)
    assert installation.missing() == (
        f"RMW_IMPLEMENTATION is {FAST}, whose library lib{FAST}.so is not on LD_LIBRARY_PATH\n"
        "install it, or source the ROS 2 that has it"
    )


@pytest.mark.parametrize(
    ("packages", "variables", "reason"),
    [
        (WHEELS, {"RMW_IMPLEMENTATION": CYCLONE}, f"RMW_IMPLEMENTATION is {CYCLONE}, and rclpy from PyPI has no other"),
        (
            WHEELS,
            {"RCL_ASSERT_RMW_ID_MATCHES": CYCLONE},
            f"RCL_ASSERT_RMW_ID_MATCHES is {CYCLONE}, and rclpy from PyPI",
        ),
        (
            SOURCED,
            {"RMW_IMPLEMENTATION": FAST, "RCL_ASSERT_RMW_ID_MATCHES": CYCLONE},
            f"RCL_ASSERT_RMW_ID_MATCHES is {CYCLONE}, and rclpy would load {FAST}\nunset RCL_ASSERT_RMW_ID_MATCHES",
        ),
        (
            WHEELS,
            {"AMENT_PREFIX_PATH": "/opt/ros/jazzy"},
            "ROS 2 is sourced (AMENT_PREFIX_PATH) in an environment with",
        ),
        (WHEELS, {"LD_LIBRARY_PATH": "/nowhere"}, "its library librcl.so is not on LD_LIBRARY_PATH"),
        (SOURCED, {"LD_LIBRARY_PATH": "/nowhere"}, "its library librcl.so is not on LD_LIBRARY_PATH"),
        (SOURCED[:2], {}, "the package std_msgs is not installed\ninstall common_interfaces beside rclpy"),
        (SOURCED[:1], {}, "the package rcl_interfaces is not installed"),
    ],
)
def test_each_obstacle_is_reported_with_a_remedy(
    install: Install,
    monkeypatch: pytest.MonkeyPatch,
    packages: tuple[str, ...],
    variables: dict[str, str],
    reason: str,
) -> None:
    install(*packages)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    said = installation.missing()
    assert said is not None
    assert said.startswith(reason)
    assert len(said.splitlines()) == 2


def test_wheels_without_their_extra_have_no_rmw(install: Install) -> None:
    install(*WHEELS, rmws=())
    assert str(installation.missing()).startswith(f"its library lib{FAST}.so is not on LD_LIBRARY_PATH")


def test_an_installation_for_another_python_reports_both_versions(install: Install) -> None:
    install(*SOURCED, suffix=OF_ANOTHER_PYTHON)
    built, loads = OF_ANOTHER_PYTHON[1:], LOADED[1:]
    assert f"is built as {built}, and this Python 3.{sys.version_info.minor} loads {loads}\n" in str(
        installation.missing()
    )


def test_libraries_of_conda_are_found_without_a_variable(
    install: Install, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    install(*SOURCED)
    monkeypatch.delenv("LD_LIBRARY_PATH")
    assert installation.missing() is not None
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert installation.missing() is None


def test_a_folder_named_rclpy_without_its_module_is_reported(install: Install) -> None:
    install(*SOURCED, suffix="")
    assert "is not the rclpy of ROS 2: it has no _rclpy_pybind11\n" in str(installation.missing())


def test_auto_does_not_choose_rclpy_from_wheels(install: Install, domain_id: int) -> None:
    install(*WHEELS)
    with closing(open_transport("auto", JoinOptions(Domain(domain_id, "OFF"), "alice"))) as transport:
        assert transport.description.startswith("dds (")
        assert "chosen because rclpy is left out (it is from PyPI: --transport rclpy uses it)" in transport.description


def test_auto_skips_a_transport_that_cannot_be_imported(install: Install, domain_id: int) -> None:
    install(*SOURCED, program="raise ImportError('librcl.so: wrong ELF class')")
    options = JoinOptions(Domain(domain_id, "OFF"), "alice")
    with closing(open_transport("auto", options)) as transport:
        assert "because rclpy cannot be imported (ImportError: librcl.so: wrong ELF class)" in transport.description
    with pytest.raises(TransportError, match=r"cannot join domain .*: ImportError: librcl\.so: wrong ELF class"):
        open_transport("rclpy", options)


@pytest.mark.ros
@pytest.mark.parametrize("rmw", ["rmw_of_nobody_cpp"])
def test_a_missing_rmw_is_reported_before_rclpy_can_end_the_process(rmw: str) -> None:
    command = [sys.executable, "-m", "graphengine.cli", "topic", "list", "--transport", "rclpy"]
    environment = {**os.environ, "RMW_IMPLEMENTATION": rmw}
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"error: rclpy cannot be used: RMW_IMPLEMENTATION is {rmw}, ")
