"""`graphrun doctor`: check this installation, this machine and its network for problems, and print a remedy for each."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import platform
import textwrap
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from graphengine.format.distribution import NAME, install_command, reinstall_command
from graphengine.format.errors import GraphError, RenderError, TransportError
from graphengine.format.version import __version__

_WIDTH = 80
"""Maximum length of printed lines."""
_INDENT, _ARROW = " " * 9, "      -> "
_BUFFER = 4_194_304
"""Recommended receive buffer of sockets, bytes: docs/reference/large_messages.md."""
_READERS = {"net.core.rmem_max": "Cyclone DDS", "net.core.rmem_default": "Fast DDS without a profile"}
"""A dict from kernel parameters to the subscribers whose receive buffer they limit."""


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Result of a check.

    Attributes:
        state: `ok`; `note` for a limitation, or a fact that users should know; `problem` if a function does not work.
        found: result of the check, such as a version.
        meaning: consequence for runs; empty if the state is `ok`.
        remedy: commands and instructions; empty if there is nothing to do.
    """

    state: str
    found: str
    meaning: str = ""
    remedy: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun doctor` to its parser."""
    formats = "text for people, or json: an object with `version`, `problems` (their number) and `checks`"
    parser.add_argument("--format", choices=("text", "json"), default="text", help=f"{formats} (default text)")
    parser.epilog = f"In the JSON output, each item of `checks` has `name` ({', '.join(CHECKS)}), `title`, `state` "
    parser.epilog += "(ok, note or problem), `found`, `meaning` and `remedy` (a list). "
    parser.epilog += "The exit code is 1 if there is a problem, else 0."


def execute(arguments: argparse.Namespace) -> int:
    """Run all checks and print the results; return 1 if there is a problem, else 0."""
    from graphengine.cli.common import clean

    reports, problems = list[dict[str, object]](), 0
    for name, (title, check) in CHECKS.items():
        diagnosis = _diagnose(check)
        problems += diagnosis.state == "problem"
        reports.append({"name": name, "title": title, **asdict(diagnosis)})
        if arguments.format == "text":
            print(clean(_text(title, diagnosis)), flush=True)
    if arguments.format == "json":
        print(json.dumps({"version": __version__, "problems": problems, "checks": reports}, indent=2))
    return int(problems > 0)


def _text(title: str, diagnosis: Diagnosis) -> str:
    """Return a diagnosis as lines: state, title and result of the check, then the meaning, then the remedy after arrows."""
    lines = _wrapped(f"{diagnosis.state:<9}{title}: {diagnosis.found}", "")
    lines += _wrapped(diagnosis.meaning, _INDENT)
    for each in diagnosis.remedy:
        lines += _wrapped(each, _ARROW)
    return "\n".join(lines)


def _wrapped(text: str, first: str) -> list[str]:
    lines = textwrap.TextWrapper(_WIDTH, first, _INDENT, break_long_words=False, break_on_hyphens=False)
    return lines.wrap(text)


def _diagnose(check: Callable[[], Diagnosis]) -> Diagnosis:
    """Return the result of a check; if the check raises, a problem, with the further lines of the message as its remedy."""
    try:
        return check()
    except GraphError as error:
        found, *remedy = (line.strip() for line in str(error).splitlines())
        return Diagnosis("problem", found, "Runs end with this error.", tuple(remedy))
    except (Exception, SystemExit) as error:  # a package that is installed incompletely may fail in any way
        meaning = "The check was not completed; a package may be missing or damaged."
        return Diagnosis("problem", f"{type(error).__name__}: {error}", meaning, (reinstall_command(),))


def _versions() -> Diagnosis:
    import numpy as np

    from graphengine.descriptions.engine import mujoco

    system = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
    return Diagnosis("ok", f"{NAME} {__version__}, {system}, MuJoCo {mujoco.__version__}, numpy {np.__version__}")


def _installation() -> Diagnosis:
    from graphengine.format.installed_files import conflicts

    found, remedy = conflicts()
    if not found:
        return Diagnosis("ok", f"graphengine is imported from {Path(__file__).parents[1]}")
    meaning = "Python may import files of another project, or of another version, instead of those of this one."
    return Diagnosis("problem", "; ".join(found), meaning, tuple(remedy))


def _opengl() -> Diagnosis:
    from graphengine.physics.pictures import opengl

    try:
        return Diagnosis("ok", opengl.driver())
    except RenderError as error:
        found = "; ".join(line for line in str(error).splitlines() if line not in opengl.INSTALL)
        return Diagnosis("problem", found, "Cameras deliver no images, and `graphrun snapshot` fails.", opengl.INSTALL)


def _numba() -> Diagnosis:
    meaning = "MuJoCo casts the rays of lidars, which takes about ten times as long."
    if importlib.util.find_spec("numba") is None:
        return Diagnosis("note", "it is not installed", meaning, (install_command("fast"),))
    try:
        import numba

        from graphengine.physics.kernels.compiled import kept_in
        from graphengine.physics.ray_casting.fast.kernel import cast
        from graphengine.physics.ray_casting.fast.rays import trouble
    except Exception as error:  # one of its libraries does not fit
        return Diagnosis("problem", f"{type(error).__name__}: {error}", meaning, (install_command("fast"),))
    if reason := trouble():
        remedy = "unset NUMBA_DISABLE_JIT" if numba.config.DISABLE_JIT else install_command("fast")
        return Diagnosis("problem", reason, meaning, (remedy,))
    return Diagnosis("ok", f"{numba.__version__}; the ray casting of lidars is compiled, in {kept_in(cast)}")


def _sandbox() -> Diagnosis:
    from graphengine.sandbox import borders

    if not borders.missing():
        return Diagnosis("ok", borders.describe())
    meaning = "Robot descriptions and meshes are read with less confinement (W206); "
    meaning += "scripts and stages of Isaac Sim are read only with --trust."
    remedy = (
        "use Linux 5.13 or newer on x86_64 or aarch64, with `landlock` in /sys/kernel/security/lsm",
        "in a container: use a seccomp profile that allows the system calls landlock_* and seccomp, as Docker's does",
    )
    return Diagnosis("note", borders.describe(), meaning, remedy)


def _ros() -> Diagnosis:
    from graphengine.ros.transports import dds
    from graphengine.ros.transports.rcl import installation

    rmw, distro = (os.environ.get(name, "") for name in ("RMW_IMPLEMENTATION", "ROS_DISTRO"))
    setting = f"RMW_IMPLEMENTATION is {rmw or 'not set'}"
    no_rclpy, no_dds = ((why or "").splitlines() for why in (installation.missing(), dds.TRANSPORT.missing()))
    if no_rclpy and no_dds:
        meaning = "Runs reach no other programs; they work with --transport memory."
        remedy = (*no_rclpy[1:], *no_dds[1:])
        return Diagnosis("problem", f"{no_rclpy[0]}; no embedded DDS: {no_dds[0]}", meaning, remedy)
    if no_rclpy:
        return _embedded_dds(no_rclpy, rmw, setting)
    if not installation.is_from_wheels():
        return Diagnosis("ok", f"rclpy of ROS 2 {distro}; {setting}")
    found = f"rclpy is that of PyPI; {setting}"
    if no_dds:
        meaning = f"Runs need the option --transport rclpy, as there is no embedded DDS: {no_dds[0]}."
        return Diagnosis("note", found, meaning, tuple(no_dds[1:]))
    return Diagnosis("ok", f"{found}; runs use embedded DDS, or rclpy with --transport rclpy")


def _embedded_dds(no_rclpy: list[str], rmw: str, setting: str) -> Diagnosis:
    """Return the diagnosis for a machine on which runs use embedded DDS, because rclpy cannot be used."""
    from graphengine.ros.transports.rcl import installation
    from graphengine.ros.transports.vendors import CYCLONE_RMW

    reason, *remedy = no_rclpy
    limit = f"Runs use embedded DDS, whose services and actions reach only peers on {CYCLONE_RMW}."
    if installation.folders_of("rclpy"):
        return Diagnosis("problem", f"rclpy cannot be used: {reason}; {setting}", limit, tuple(remedy))
    if os.environ.get("AMENT_PREFIX_PATH"):
        found = f"AMENT_PREFIX_PATH is set, but Python finds no rclpy; {setting}"
        return Diagnosis("note", found, limit, ("source the setup file of ROS 2; it sets PYTHONPATH too",))
    if rmw not in ("", CYCLONE_RMW):
        lost = "topics, services and actions" if "zenoh" in rmw else "services and actions"
        meaning = f"Runs use embedded DDS; its {lost} do not reach peers on {rmw}."
        remedy.insert(0, f"start the peers with RMW_IMPLEMENTATION={CYCLONE_RMW}")
        return Diagnosis("note", f"{reason}; {setting}", meaning, tuple(remedy))
    return Diagnosis("ok", f"{reason}, so runs use embedded DDS; {setting}")


def _domain() -> Diagnosis:
    from graphengine.ros.domain import Domain

    domain = Domain.from_environment(os.environ)
    if domain.discovery_range == "OFF":
        remedy = "unset ROS_AUTOMATIC_DISCOVERY_RANGE"
        return Diagnosis("note", str(domain), "Runs reach no other process, not even on this machine.", (remedy,))
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        meaning = "ROS_LOCALHOST_ONLY is deprecated in ROS 2; it overrides the discovery range and ROS_STATIC_PEERS."
        remedy = "use ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"
        return Diagnosis("note", str(domain), meaning, (remedy,))
    peers = f"; static peers: {', '.join(domain.static_peers)}" if domain.static_peers else ""
    return Diagnosis("ok", f"{domain}{peers}")


def _ports() -> Diagnosis:
    from graphengine.ros import ports
    from graphengine.ros.domain import Domain

    try:
        domain = Domain.from_environment(os.environ)
    except TransportError:
        return Diagnosis("note", "not checked", "The domain is not legal.")
    shared, pairs = ports.shared_port(domain.id), ports.process_ports(domain.id)
    free = sum(ports.can_bind(first) and ports.can_bind(second) for first, second in pairs)
    found = f"domain {domain.id} has UDP ports for {free} more processes of at most {len(pairs)}, from {pairs[0][0]} on"
    another = "set another ROS_DOMAIN_ID, in the environment of all programs of this domain"
    if not ports.can_bind(shared, reuse=True):
        found = f"UDP port {shared} of domain {domain.id} is taken by a program that does not share it"
        return Diagnosis("problem", found, "Runs cannot join the domain.", (another,))
    if not free:
        return Diagnosis("problem", found, "Runs cannot join the domain.", ("end other programs", another))
    if ephemeral := ports.ephemeral_ports(shared, pairs[-1][1]):
        meaning = f"Linux may give these ports to any program, as it does with all ports from {ephemeral}."
        return Diagnosis("note", found, meaning, ("use a domain from 0 to 101",))
    if domain.discovery_range == "SUBNET" and not ports.has_multicast():
        remedy = "bring up a network interface with multicast, or name the other machines in ROS_STATIC_PEERS"
        meaning = "Runs do not discover programs on other machines."
        return Diagnosis("note", f"{found}; no network interface has multicast", meaning, (remedy,))
    return Diagnosis("ok", found + ("; multicast works" if domain.discovery_range == "SUBNET" else ""))


def _buffers() -> Diagnosis:
    paths = {name: Path("/proc/sys", *name.split(".")) for name in _READERS}
    sizes = {name: int(path.read_text("ascii")) for name, path in paths.items() if path.is_file()}
    found = ", ".join(f"{name} is {size}" for name, size in sizes.items())
    small = [name for name, size in sizes.items() if size < _BUFFER]
    if not small:
        return Diagnosis("ok", found or "not checked, as this is not Linux, or a container without these parameters")
    readers = " and ".join(_READERS[name] for name in small)
    meaning = f"Best-effort subscribers on {readers} lose images and large clouds; reliable ones receive them "
    meaning += "(docs/reference/large_messages.md)."
    return Diagnosis("note", found, meaning, tuple(f"sudo sysctl -w {name}={_BUFFER}" for name in small))


CHECKS: dict[str, tuple[str, Callable[[], Diagnosis]]] = {
    "versions": ("versions", _versions),
    "installation": ("installation", _installation),
    "opengl": ("OpenGL", _opengl),
    "numba": ("numba", _numba),
    "sandbox": ("sandbox", _sandbox),
    "ros": ("ROS 2", _ros),
    "domain": ("domain", _domain),
    "ports": ("ports", _ports),
    "buffers": ("socket buffers", _buffers),
}
"""A dict from the names of checks to their titles and functions, in the order of the output."""
