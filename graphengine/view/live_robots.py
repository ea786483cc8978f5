"""Lists the robots of a session with their sensors, and reads the state of selected robots and objects."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graphengine.devices.rotation import yaw_of
from graphengine.devices.stage import Prim
from graphengine.messages.names import join_namespaces

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

_NO_SENSORS = ("scope", "robot", "link", "joint", "frame", "material", "graph", "body", "light", "sensor")
"""Kinds of prims that are not sensors."""


def list_robots(session: SessionCore) -> Sequence[Mapping[str, Any]]:
    """Return name, prim path, namespace, file and sensors of each robot, and whether it was spawned, as JSON values."""
    stage, spawned, uses = session.services.stage, session.roster.spawned, session.roster.uses
    return [
        {
            "name": robot.entity_name,
            "prim": robot.path,
            "namespace": join_namespaces(stage.namespaces(robot.facts["base_link"])),
            "spawned": robot.entity_name in spawned,
            "use": _short(uses.get(robot.entity_name, "")),
            "sensors": [_sensor(prim) for prim in robot.descendants() if prim.kind not in _NO_SENSORS],
        }
        for robot in stage.prims("robot")
    ]


def _short(use: str) -> str:
    """Return the source of a robot if it is a file name; empty if it is the text of a robot description."""
    return use if len(use) < 1000 and use.isprintable() else ""


def _sensor(prim: Prim) -> Mapping[str, str]:
    return {"name": prim.path.rpartition("/")[2], "kind": prim.kind, "prim": prim.path}


def states_of(session: SessionCore, names: Collection[str]) -> Mapping[str, Mapping[str, Any]]:
    """Return position (m), heading (deg), speed (m/s) and turn rate (rad/s) of each existing entity among `names`, by name."""
    found = {}
    entities = session.services.world.entities
    for name in sorted({*names} & {entity.name for entity in entities.all()} if names else ()):
        state = entities.state(name)
        numbers = {
            "x": state.position[0],
            "y": state.position[1],
            "z": state.position[2],
            "heading": math.degrees(yaw_of(state.orientation)),
            "speed": math.hypot(*state.linear_velocity),
            "turn": state.angular_velocity[2],
        }
        found[name] = {key: value if math.isfinite(value) else None for key, value in numbers.items()}
    return found
