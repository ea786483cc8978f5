"""Finds out whether rclpy can be used, from files and variables only: the import of rclpy may end the process."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from graphengine.format.distribution import install_command

_BOOTSTRAPPER = "ros_wheels_bootstrapper"
"""Module beside the wheels of ROS 2 on PyPI; it sets LD_LIBRARY_PATH at each start of Python."""
_DEFAULT_RMW = "rmw_fastrtps_cpp"
"""The RMW that rclpy loads unless RMW_IMPLEMENTATION names another RMW; the wheels have only this RMW."""
_NATIVE = "_rclpy_pybind11"
_TYPES = ("rcl_interfaces", "std_msgs")
"""A package with types that rclpy needs, and a package of common_interfaces."""


def missing() -> str | None:
    """Return the reason why rclpy cannot be used, such as another Python version, then a line with a remedy; None without one."""
    return next(_obstacles(), None)


def is_from_wheels() -> bool:
    """Return whether rclpy comes from the wheels on PyPI, not from a sourced ROS 2 installation."""
    return any((folder.parent / _BOOTSTRAPPER).is_dir() for folder in folders_of("rclpy"))


def _obstacles() -> Iterator[str]:
    folders = folders_of("rclpy")
    if not folders:
        extra = f", or {install_command('ros')}" if _has_wheels() else ""
        yield f"no ROS 2 is sourced\nsource a ROS 2 installation{extra}"
        return
    built = [file.name.partition(".")[2] for folder in folders for file in sorted(folder.glob(f"{_NATIVE}.*"))]
    loaded = [suffix.removeprefix(".") for suffix in importlib.machinery.EXTENSION_SUFFIXES]
    if not built:
        yield f"{folders[0]} is not the rclpy of ROS 2: it has no {_NATIVE}\nrename or remove it"
    elif not set(built) & set(loaded):
        python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
        remedy = "install graphengine for the Python of that ROS 2"
        yield f"rclpy in {folders[0].parent} is built as {built[0]}, and this {python} loads {loaded[0]}\n{remedy}"
    if os.environ.get("AMENT_PREFIX_PATH") and folders_of(_BOOTSTRAPPER):
        sourced = "ROS 2 is sourced (AMENT_PREFIX_PATH) in an environment with wheels of ROS 2 from PyPI"
        yield f"{sourced}, whose libraries would be mixed\nuse a shell without ROS 2, or an environment without the wheels"
    yield from _missing_libraries(is_from_wheels())
    for package in _TYPES:
        if not folders_of(package):
            yield f"the package {package} is not installed\ninstall common_interfaces beside rclpy"


def _has_wheels() -> bool:
    """Return whether PyPI has wheels of ROS 2 for this Python on this machine."""
    return sys.platform == "linux" and os.uname().machine == "x86_64" and sys.version_info < (3, 14)


def _missing_libraries(wheels: bool) -> Iterator[str]:
    named = os.environ.get("RMW_IMPLEMENTATION", "")
    rmw = _DEFAULT_RMW if wheels or not named else named
    for name in ("RMW_IMPLEMENTATION", "RCL_ASSERT_RMW_ID_MATCHES"):
        if os.environ.get(name, rmw) not in ("", rmw):  # librcl ends the process
            whose = "rclpy from PyPI has no other than" if wheels else "rclpy would load"
            yield f"{name} is {os.environ[name]}, and {whose} {rmw}\nunset {name}"
    if sys.platform != "linux":
        return
    folders = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    if not wheels:  # found without the variable: libraries of conda and of Linux distributions
        folders += [f"{sys.prefix}/lib", "/usr/lib", "/usr/local/lib"]
    for library in ("rcl", *([rmw] if named or wheels else [])):  # without a name, rclpy takes any installed RMW
        if not any(folder and Path(folder, f"lib{library}.so").is_file() for folder in folders):
            whose = f"RMW_IMPLEMENTATION is {named}, whose" if library == named else "its"
            remedy = "install it, or source the ROS 2 that has it"
            yield f"{whose} library lib{library}.so is not on LD_LIBRARY_PATH\n{remedy}"


def folders_of(package: str) -> list[Path]:
    """Return the folders of a package without importing it; an empty list if the package is not installed."""
    try:
        spec = importlib.util.find_spec(package)
    except ValueError:  # a module of this name was made by hand
        return []
    if spec is None:
        return []
    found = spec.submodule_search_locations or [str(Path(spec.origin or package).with_suffix(""))]
    return [Path(folder) for folder in found]
