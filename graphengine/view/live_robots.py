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
            "joints": _joints(session, robot),
            "spawned": robot.entity_name in spawned,
            "use": _short(uses.get(robot.entity_name, "")),
            "sensors": [_sensor(prim) for prim in robot.descendants() if prim.kind not in _NO_SENSORS],
        }
        for robot in stage.prims("robot")
    ]


def _joints(session: SessionCore, robot: Prim) -> list[Mapping[str, Any]]:
    """Return name, unit, limits and drive of each joint: an infinite limit is None, the drive empty without one."""
    if not robot.facts.get("joints"):
        return []
    arm = session.services.world.articulation(robot)
    undriven = {kind: {*arm.select().undriven(kind)} for kind in ("position", "velocity")}
    found: list[Mapping[str, Any]] = []
    for row, name in enumerate(arm.joint_names):
        position = arm.stiffness[row] > 0.0 and name not in undriven["position"] and not arm.leaders[row]
        velocity = name not in undriven["velocity"] and not arm.leaders[row]
        limits = arm.target_ranges[row] if position else (-arm.max_velocities[row], arm.max_velocities[row])
        found.append(
            {
                "name": name,
                "unit": "m" if arm.prismatic[row] else "rad",
                "limits": [limit if math.isfinite(limit) else None for limit in limits],
                "drive": "position" if position else "velocity" if velocity else "",
            }
        )
    return found


def with_joints(session: SessionCore, states: Mapping[str, Mapping[str, Any]]) -> Mapping[str, Mapping[str, Any]]:
    """Return states of entities with `joints` for robots: position, velocity and both set points of each joint."""
    found = dict(states)
    for robot in session.services.stage.prims("robot") if states else ():
        if robot.entity_name in found and robot.facts.get("joints"):
            arm = session.services.world.articulation(robot)
            rows = zip(arm.positions(), arm.velocities(), *arm.set_points(), strict=True)
            numbers = [[float(number) if math.isfinite(number) else None for number in row] for row in rows]
            joints = dict(zip(arm.joint_names, numbers, strict=True))
            found[robot.entity_name] = {**found[robot.entity_name], "joints": joints}
    return found


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
