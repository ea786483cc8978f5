"""`graphrun doctor` finds what is missing or wrong, says what it means and what to do."""

from __future__ import annotations

import contextlib
import ctypes.util
import importlib.util
import json
import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.cli import doctor
from graphengine.cli.doctor import CHECKS, Diagnosis
from graphengine.ros.transports.rcl import installation
from graphengine.sandbox import borders
from tests.cli.harness import Graphrun, process
from tests.physics.pictures.harness import needs_opengl

KEYS = ["name", "title", "state", "found", "meaning", "remedy"]


def look(name: str) -> Diagnosis:
    return doctor._diagnose(CHECKS[name][1])


@pytest.fixture
def embedded(monkeypatch: pytest.MonkeyPatch) -> None:
    """No rclpy on this machine, and no variable that chooses an RMW."""
    monkeypatch.setattr(installation, "folders_of", lambda package: [])
    for name in ("RMW_IMPLEMENTATION", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)


# The whole


def test_every_check_is_in_the_json_output_and_problems_set_the_exit_code(tmp_path: Path) -> None:
    wrong = {"ROS_DOMAIN_ID": "233", "NUMBA_DISABLE_JIT": "1", "__EGL_VENDOR_LIBRARY_DIRS": str(tmp_path)}
    told = json.loads(process("doctor", "--format", "json", env=wrong, code=1, err="").out)
    assert [list(check) for check in told["checks"]] == [KEYS] * len(CHECKS)
    checks = {check["name"]: check for check in told["checks"]}
    assert list(checks) == list(CHECKS)
    problems = {name for name, check in checks.items() if check["state"] == "problem"}
    assert told["problems"] == len(problems)
    assert {"domain", "numba"} <= problems
    assert all(check["remedy"] and check["meaning"] for name, check in checks.items() if name in problems)
    assert checks["numba"]["remedy"] == ["unset NUMBA_DISABLE_JIT"]
    assert checks["domain"]["found"] == "ROS_DOMAIN_ID is '233'"
    if ctypes.util.find_library("OSMesa") is None:
        assert checks["opengl"]["state"] == "problem"
        assert "EGL: " in checks["opengl"]["found"]
        assert any("apt-get install libegl1" in line for line in checks["opengl"]["remedy"])


def test_doctor_prints_lines_of_at_most_80_characters(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHECKS", {name: CHECKS[name] for name in ("versions", "sandbox", "domain", "ports")})
    monkeypatch.setattr(borders, "BORDERS", {"Landlock": (lambda: False, "")})
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNETS")
    result = graphrun("doctor", code=1, err="")
    assert max(map(len, result.lines)) <= 80
    assert result.lines[0].startswith("ok       versions: graphrun ")
    assert "note     sandbox: Landlock: no" in result.lines
    at = result.lines.index("problem  domain: ROS_AUTOMATIC_DISCOVERY_RANGE is 'SUBNETS'")
    assert result.lines[at + 1 : at + 3] == ["         Runs end with this error.", "      -> did you mean 'SUBNET'?"]
    assert "note     ports: not checked" in result.lines


def test_notes_are_no_problems(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHECKS", {"buffers": CHECKS["buffers"]})
    monkeypatch.setattr(doctor, "_BUFFER", 1 << 60)
    assert graphrun("doctor", code=0).out.startswith(("note     socket buffers: net.core.rmem_max is ", "ok "))


def test_the_help_has_the_keys_and_names_of_the_output(graphrun: Graphrun) -> None:
    text = " ".join(graphrun("doctor", "--help", code=0).out.split())
    assert all(re.search(rf"\b{word}\b", text) for word in (*KEYS, *CHECKS, "version", "problems", "checks"))


def test_an_exception_in_a_check_is_a_problem_and_the_next_checks_run(
    graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "numpy", None)
    monkeypatch.setattr(doctor, "CHECKS", {name: CHECKS[name] for name in ("versions", "domain")})
    lines = graphrun("doctor", code=1).lines
    assert lines[0].startswith("problem  versions: ModuleNotFoundError: import of numpy halted")
    assert any(line.startswith("note     domain: ") for line in lines)


# The machine


@needs_opengl
def test_a_driver_that_works_is_named() -> None:
    assert look("opengl").state == "ok"


def test_numba_that_is_not_installed_is_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert look("numba") == Diagnosis(
        "note",
        "it is not installed",
        "MuJoCo casts the rays of lidars, which takes about ten times as long.",
        ("pip install '.[fast]'    # in a checkout of graphengine",),
    )


def test_numba_that_cannot_be_imported_is_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("graphengine.physics.ray_casting.fast")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    monkeypatch.setitem(sys.modules, "numba", None)
    found = look("numba")
    assert (found.state, found.found) == ("problem", "ModuleNotFoundError: import of numba halted; None in sys.modules")


def test_a_small_receive_buffer_is_a_note_with_the_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    parameter = "net.core.rmem_max"
    if not Path("/proc/sys/net/core/rmem_max").is_file():
        pytest.skip("no kernel parameters of the network")
    monkeypatch.setattr(doctor, "_READERS", {parameter: "Cyclone DDS"})
    size = int(Path("/proc/sys/net/core/rmem_max").read_text())
    monkeypatch.setattr(doctor, "_BUFFER", size)
    assert look("buffers") == Diagnosis("ok", f"{parameter} is {size}")
    monkeypatch.setattr(doctor, "_BUFFER", size + 1)
    found = look("buffers")
    assert (found.state, found.remedy) == ("note", (f"sudo sysctl -w {parameter}={size + 1}",))


def test_the_recommended_buffer_is_the_one_in_the_reference() -> None:
    text = (Path(__file__).parents[2] / "docs/reference/large_messages.md").read_text(encoding="utf-8")
    for name in doctor._READERS:
        assert f"sudo sysctl -w {name}={doctor._BUFFER} " in text


# The network


@pytest.mark.usefixtures("embedded")
def test_without_ros_2_a_run_uses_installed_embedded_dds(monkeypatch: pytest.MonkeyPatch) -> None:
    assert look("ros") == Diagnosis(
        "ok", "no ROS 2 is sourced, so runs use embedded DDS; RMW_IMPLEMENTATION is not set"
    )
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    found = look("ros")
    assert (found.state, found.meaning) == (
        "problem",
        "Runs reach no other programs; they work with --transport memory.",
    )
    assert found.remedy[0].startswith("source a ROS 2 installation")


@pytest.mark.usefixtures("embedded")
@pytest.mark.parametrize(
    ("rmw", "lost"), [("rmw_fastrtps_cpp", "its services"), ("rmw_zenoh_cpp", "its topics, services")]
)
def test_peers_on_another_rmw_are_a_note(rmw: str, lost: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", rmw)
    found = look("ros")
    assert found.state == "note"
    assert lost in found.meaning
    assert found.remedy[0] == "start the peers with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"


@pytest.mark.usefixtures("embedded")
def test_a_ros_2_that_is_sourced_only_in_part_is_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", "/opt/ros/jazzy")
    found = look("ros")
    assert found.state == "note"
    assert found.found == "AMENT_PREFIX_PATH is set, but Python finds no rclpy; RMW_IMPLEMENTATION is not set"


@pytest.mark.parametrize(("without_dds", "state"), [(False, "ok"), (True, "note")])
def test_rclpy_of_pypi_is_needed_without_embedded_dds(
    without_dds: bool, state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installation, "missing", lambda: None)
    monkeypatch.setattr(installation, "is_from_wheels", lambda: True)
    if without_dds:
        monkeypatch.setitem(sys.modules, "cyclonedds", None)
    found = look("ros")
    assert found.state == state
    assert found.found.startswith("rclpy is that of PyPI; ")
    assert "--transport rclpy" in (found.meaning or found.found)


def test_an_rclpy_that_cannot_be_loaded_is_a_problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rclpy").mkdir()
    (tmp_path / "rclpy/_rclpy_pybind11.cpython-27.so").write_bytes(b"")
    monkeypatch.setattr(installation, "folders_of", lambda package: [tmp_path / package] * (package == "rclpy"))
    found = look("ros")
    assert found.state == "problem"
    assert found.found.startswith(f"rclpy cannot be used: rclpy in {tmp_path} is built as cpython-27.so")
    assert found.remedy == ("install graphengine for the Python of that ROS 2",)


@pytest.mark.parametrize(
    ("name", "value", "remedy"),
    [
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF", "unset ROS_AUTOMATIC_DISCOVERY_RANGE"),
        ("ROS_LOCALHOST_ONLY", "1", "use ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"),
    ],
)
def test_settings_that_hide_a_run_from_others_are_a_note(
    name: str, value: str, remedy: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for other in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(other, raising=False)
    assert look("domain").state == "ok"
    monkeypatch.setenv(name, value)
    assert (look("domain").state, look("domain").remedy) == ("note", (remedy,))


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> int:
    """A domain whose ports are all free, and are not given to programs by the kernel; the environment names it."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    for number in range(100, 50, -1):
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        found = look("ports")
        if (found.state, "for 33 more processes" in found.found) == ("ok", True):
            return number
    pytest.skip("processes are in all domains")


@contextlib.contextmanager
def taken(*ports: int) -> Iterator[None]:
    with contextlib.ExitStack() as stack:
        for port in ports:
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)).bind(("", port))
        yield


def test_a_discovery_port_taken_by_another_program_is_a_problem(domain: int) -> None:
    port = 7400 + 250 * domain
    with taken(port):
        found = look("ports")
    assert found.state == "problem"
    assert found.found == f"UDP port {port} of domain {domain} is taken by a program that does not share it"
    assert look("ports").state == "ok"


def test_a_domain_with_as_many_processes_as_it_can_have_is_a_problem(domain: int) -> None:
    first = 7410 + 250 * domain
    with taken(*range(first, first + 66, 2)):
        found = look("ports")
    assert (found.state, found.remedy[0]) == ("problem", "end other programs")
    with taken(*range(first, first + 64, 2)):
        assert f"has UDP ports for 1 more processes of at most 33, from {first} on" in look("ports").found


@pytest.mark.parametrize(("domain", "state"), [(101, "ok"), (102, "note"), (214, "note"), (215, "ok")])
def test_domains_whose_ports_linux_gives_to_any_program_are_a_note(
    domain: int, state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = Path("/proc/sys/net/ipv4/ip_local_port_range")
    if not path.is_file() or path.read_text().split() != ["32768", "60999"]:
        pytest.skip("this machine has other ephemeral ports than Linux by default")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    assert look("ports").state == state


@pytest.mark.skipif(shutil.which("unshare") is None, reason="no unshare")
def test_a_machine_whose_interfaces_have_no_multicast_is_a_note() -> None:
    program = "from graphengine.cli import doctor; print(*doctor.CHECKS['ports'][1]().remedy)"
    command = ["unshare", "--map-root-user", "--net", sys.executable, "-c", program]
    environ = {**os.environ, "ROS_DOMAIN_ID": "0", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    done = subprocess.run(command, capture_output=True, text=True, env=environ, check=False, timeout=100)
    if "unshare" in done.stderr:
        pytest.skip(done.stderr)
    assert done.stdout.startswith("bring up a network interface with multicast")


# The sandbox


def test_borders_that_the_kernel_lacks_are_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(borders, "BORDERS", {**borders.BORDERS, "Landlock": (lambda: False, "its code may read files")})
    found = look("sandbox")
    assert (found.state, found.found) == (
        "note",
        f"Landlock: no, seccomp: {'yes' if borders.BORDERS['seccomp'][0]() else 'no'}",
    )
    assert "landlock" in found.remedy[0]
