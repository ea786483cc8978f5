"""Gravity, the friction of materials, and lights, as attributes that can be written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from graphengine.devices.backend import World
from graphengine.devices.stage import Prim
from graphengine.format.errors import ContextError
from graphengine.format.wording import shown
from graphengine.node.prims.attribute import Attribute, numbers

STRONGEST_GRAVITY = 1000.0
"""m/s2, some forty times that of Jupiter."""
BRIGHTEST = 1e6
"""Of intensities and colours: far more than any picture shows, and their product is a number to OpenGL."""


def gravity_attributes(world: World) -> dict[str, Attribute]:
    """How bodies fall: which way, as a vector of length 1, and how fast, m/s2."""

    def direction() -> list[float]:
        size = math.hypot(*world.gravity)
        return [part / size for part in world.gravity] if size else [0.0, 0.0, -1.0]

    def fall(way: Sequence[float], magnitude: float) -> None:
        size = math.hypot(*way)
        if not 0.0 < size < math.inf or not 0.0 <= magnitude <= STRONGEST_GRAVITY:
            raise ContextError(
                f"gravity has a direction, and a magnitude of 0 to {STRONGEST_GRAVITY:g} m/s2", magnitude
            )
        x, y, z = (magnitude * part / size for part in way)
        world.set_gravity((x, y, z))

    return {
        "physics:gravityDirection": Attribute(
            "vector3f", direction, lambda value: fall(numbers(value, 3), math.hypot(*world.gravity))
        ),
        "physics:gravityMagnitude": Attribute(
            "float", lambda: math.hypot(*world.gravity), lambda value: fall(direction(), numbers([value], 1)[0])
        ),
    }


def friction_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """How a material slides; each of the two numbers is written alone, and neither where a collider is the world's."""

    def static(value: Any) -> None:
        world.set_friction(prim, (_not_negative(value), world.friction(prim)[1]))

    def dynamic(value: Any) -> None:
        world.set_friction(prim, (world.friction(prim)[0], _not_negative(value)))

    reachable = len(prim.facts["bodies"]) == len(prim.facts["bind"])
    return {
        "physics:staticFriction": Attribute("float", lambda: world.friction(prim)[0], static if reachable else None),
        "physics:dynamicFriction": Attribute("float", lambda: world.friction(prim)[1], dynamic if reachable else None),
    }


def light_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """How bright a light is, in times of what it is at the start, and its colour."""

    def brighten(value: Any) -> None:
        world.set_light(prim, (_bright(numbers([value], 1))[0], world.light(prim)[1]))

    def colour(value: Any) -> None:
        red, green, blue = _bright(numbers(value, 3))
        world.set_light(prim, (world.light(prim)[0], (red, green, blue)))

    return {
        "inputs:intensity": Attribute("float", lambda: world.light(prim)[0], brighten),
        "inputs:color": Attribute("color3f", lambda: list(world.light(prim)[1]), colour),
    }


def _bright(found: list[float]) -> list[float]:
    for number in found:
        if not 0 <= number <= BRIGHTEST:
            raise ContextError(f"it has to be 0 to {BRIGHTEST:g}, not {shown(number)}", number)
    return found


def _not_negative(value: Any) -> float:
    (number,) = numbers([value], 1)
    if number < 0:
        raise ContextError(f"it has to be 0 or more, not {shown(value)}", value)
    return number
