"""The distributions of ROS 2 whose message types are known: which one is chosen, and its types from rosbags."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from types import SimpleNamespace
from typing import Any, Literal, get_args

Distro = Literal["jazzy", "kilted", "lyrical"]
JAZZY: Distro = "jazzy"
DISTROS: tuple[Distro, ...] = get_args(Distro)
"""Oldest first."""


def sourced_distro(environ: Mapping[str, str]) -> Distro:
    """Return the distribution that is sourced, by ROS_DISTRO; Jazzy if none is, or one whose types are not known."""
    return next((distro for distro in DISTROS if distro == environ.get("ROS_DISTRO")), JAZZY)


@cache
def base_types(distro: Distro) -> Any:
    """Return the types of a distribution: their fields as `FIELDDEFS`, and their classes as attributes.

    A type whose definition is that of Jazzy has Jazzy's class, since nodes create messages by those classes. The import takes
    50 ms, and most graphs are checked without it.
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
