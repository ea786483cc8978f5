"""Defines prims for bodies and lights of the world."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import pose_of
from graphengine.devices.stage import Stage
from graphengine.format.prim_paths import prim_name


def add_world(stage: Stage, model: mujoco.MjModel, robots: Collection[str]) -> None:
    """Define a prim below /World for each body and light of the model that does not belong to a robot."""
    paths = {0: "/World"}
    stage.add("/World", "scope")
    for index in range(1, model.nbody):
        body = model.body(index)
        parent = int(model.body_parentid[index])
        if parent not in paths or any(body.name.startswith(f"{robot}/") for robot in robots):
            continue
        path = f"{paths[parent]}/{prim_name(body.name)}"
        paths[index] = path if path not in stage else f"{path}_{index}"
        position, orientation = pose_of(body.pos, body.quat)
        facts = {"jointed": bool(model.body_jntnum[index])}
        stage.add(paths[index], "body", position=position, orientation=orientation, body=body.name, facts=facts)
    for number, index in enumerate(world_lights(model, robots)):
        _add_light(stage, model, index, number, paths[int(model.light_bodyid[index])])


def _add_light(stage: Stage, model: mujoco.MjModel, index: int, number: int, above: str) -> None:
    """Define the prim of a light; as in USD, the light shines along the prim's -z axis.

    Args:
        stage: stage to which the prim is added.
        model: compiled model with the light.
        index: id of the light in the model.
        number: index of the light among the lights of the world.
        above: path of the prim that carries the light.
    """
    light = model.light(index)
    path = f"{above}/{prim_name(light.name or f'light_{number}')}"
    turn = np.empty(4)
    mujoco.mju_quatZ2Vec(turn, -light.dir)
    position, orientation = pose_of(light.pos, turn)
    facts: dict[str, Any] = {name: tuple(getattr(light, name).tolist()) for name in ("diffuse", "ambient", "specular")}
    facts |= {"number": number, "directional": bool(light.type[0] == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value)}
    path = path if path not in stage else f"{path}_light_{number}"
    stage.add(path, "light", position=position, orientation=orientation, facts=facts)


def world_lights(model: mujoco.MjModel, robots: Collection[str]) -> list[int]:
    """Return the ids of the lights that do not belong to a robot, in an order that does not depend on the robots."""
    prefixes = tuple(f"{robot}/" for robot in robots)
    bodies = [model.body(body).name for body in model.light_bodyid]
    return [light for light, body in enumerate(bodies) if not body.startswith(prefixes)]
