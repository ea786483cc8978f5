"""The ROS 2 distributions whose message types are known: selection by environment, and their types from rosbags."""

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
    """Return the sourced distribution, from ROS_DISTRO; Jazzy if it is unset or not a known distribution."""
    return next((distro for distro in DISTROS if distro == environ.get("ROS_DISTRO")), JAZZY)


@cache
def base_types(distro: Distro) -> Any:
    """Return the types of a distribution: their fields as `FIELDDEFS`, and their classes as attributes.

    A type with the same definition as in Jazzy gets Jazzy's class, because nodes create messages with Jazzy's classes. The import
    takes 50 ms, so it happens at the first call; most graphs are checked without it.
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
