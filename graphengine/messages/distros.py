"""Names the ROS 2 distributions whose message types are known, finds the sourced one, and loads types from rosbags."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from types import SimpleNamespace
from typing import Any, Literal, get_args

Distro = Literal["jazzy", "kilted", "lyrical"]
JAZZY: Distro = "jazzy"
DISTROS: tuple[Distro, ...] = get_args(Distro)
"""Names of the known distributions, oldest first."""


def sourced_distro(environ: Mapping[str, str]) -> Distro:
    """Return the distribution that ROS_DISTRO names; Jazzy if the variable is unset or names no known distribution."""
    return next((distro for distro in DISTROS if distro == environ.get("ROS_DISTRO")), JAZZY)


@cache
def base_types(distro: Distro) -> Any:
    """Return an object with the types of a distribution: their fields as `FIELDDEFS`, and their classes as attributes.

    A type with the same definition as in Jazzy gets Jazzy's class, because nodes create messages with Jazzy's classes. The first
    call imports the types: the import takes 50 ms, and most graphs are checked without it.
    """
    jazzy, chosen = (importlib.import_module(f"rosbags.typesys.stores.ros2_{name}") for name in (JAZZY, distro))
    if chosen is jazzy:
        return jazzy
    types = SimpleNamespace(FIELDDEFS=chosen.FIELDDEFS)
    for name, definition in chosen.FIELDDEFS.items():
        owner = jazzy if jazzy.FIELDDEFS.get(name) == definition else chosen
        attribute = name.replace("/", "__")
        setattr(types, attribute, getattr(owner, attribute))
    return types
