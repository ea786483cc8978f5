"""Properties of the platform that affect a run: versions, processor, OpenGL driver."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

from graphengine.format.version import __version__
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import LoadedScene

_OF_CAMERAS = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")


def describe(scene: LoadedScene, session: SessionCore) -> dict[str, str]:
    """Return the properties of this platform that affect a session.

    Args:
        scene: scene of the session.
        session: the session, whose nodes are set up.
    """
    world = session.services.world
    packages, rays = ["numpy"], world.rays_in_use
    if scene.world is not None:
        packages.append("mujoco-core")
    if rays == "fast":
        packages += ["numba", "llvmlite"]
    found = {"graphengine": __version__, "python": platform.python_version(), "processor": _processor()}
    found |= {package: _version(package) for package in packages}
    if rays:
        found["rays"] = rays
    if scene.world is not None and any(claim.message_type in _OF_CAMERAS for claim in scene.claims):
        found["OpenGL"] = world.picture_driver()
    return found


def differences(recorded: Mapping[str, str], here: Mapping[str, str]) -> list[str]:
    """Return one line for each property that two runs have with different values."""
    return [
        f"{name}: {here[name]}, recorded with {value}"
        for name, value in recorded.items()
        if value != here.get(name, value)
    ]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


def _processor() -> str:
    """Return the processor model if the system reports it, else the architecture; numpy's code depends on the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()
