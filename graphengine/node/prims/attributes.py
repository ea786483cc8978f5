"""USD attributes whose values the simulation holds: poses, joint states, drive targets, gravity, friction and lights."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from graphengine.devices.backend import World
from graphengine.devices.entity import Move
from graphengine.devices.rotation import Pose, compose, relative
from graphengine.devices.stage import Prim
from graphengine.format.errors import ContextError
from graphengine.format.wording import shown

STRONGEST_GRAVITY = 1000.0
"""Maximum magnitude of gravity, m/s2; about forty times the gravity of Jupiter."""
BRIGHTEST = 1e6
"""Maximum intensity of a light and maximum colour component. Brighter values look the same, and could overflow in OpenGL."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """One attribute of a prim, with values of JSON types: numbers, strings, booleans and lists.

    Attributes:
        read: returns the value.
        write: sets the value; None for a read-only attribute.
    """

    read: Callable[[], Any]
    write: Callable[[Any], None] | None = None


def numbers(value: Any, count: int) -> list[float]:
    """Return the numbers of a JSON array of `count` elements as floats.

    Raises:
        ContextError: the value is not an array of `count` finite numbers.
    """
    if isinstance(value, list) and len(value) == count and all(type(number) in (int, float) for number in value):
        with contextlib.suppress(OverflowError):
            found = [float(number) for number in value]
            if all(map(math.isfinite, found)):
                return found
    what = "a finite number" if count == 1 else f"an array of {count} finite numbers"
    several = isinstance(value, list) and len(value) == count
    given = f"[{', '.join(map(shown, value))}]" if several and count > 1 else shown(value[0] if several else value)
    raise ContextError(f"the value must be {what}, not {given}", value)


def of_pose(world: World, prim: Prim) -> dict[str, Attribute]:
    """Return the attributes of a prim's pose relative to its parent prim: position (m) and quaternion (w, x, y, z).

    The attributes are writable for robots and objects that are entities of the world.
    """

    def parent() -> Pose:
        assert prim.parent is not None  # the root has no pose
        return world.frame(prim.parent).pose()

    def read() -> Pose:
        return relative(parent(), world.frame(prim).pose())

    def put(pose: Pose) -> None:
        """Set the pose of the prim relative to its parent, and keep its velocity."""
        world.entities.place(prim.path, Move(*compose(parent(), pose), *world.body(prim).velocity()))

    def orient() -> list[float]:
        x, y, z, w = read()[1]
        return [w, x, y, z]

    def set_translate(value: Any) -> None:
        x, y, z = numbers(value, 3)
        put(((x, y, z), read()[1]))

    def set_orient(value: Any) -> None:
        w, x, y, z = numbers(value, 4)
        put((read()[0], (x, y, z, w)))

    movable = any(entity.prim_path == prim.path for entity in world.entities.all())
    return {
        "xformOp:translate": Attribute(lambda: list(read()[0]), set_translate if movable else None),
        "xformOp:orient": Attribute(orient, set_orient if movable else None),
    }


def of_joint(world: World, prim: Prim) -> dict[str, Attribute]:
    """Return the attributes of a joint: whether it is enabled, its position and velocity, and the targets of its drive.

    Angles are in degrees, distances in m. Only the targets are writable, and they exist only if the joint's drive has them. A
    fixed joint has only the attribute `physics:jointEnabled`.
    """
    found = {"physics:jointEnabled": Attribute(lambda: bool(prim.facts.get("enabled", True)))}
    robot, name = world.stage.robot_of(prim), prim.facts.get("joint", prim.name)
    if robot is None or name not in robot.facts.get("joints", ()):
        return found
    articulation = world.articulation(robot)
    selection, index = articulation.select([name]), articulation.joint_names.index(name)
    kind, unit = ("linear", 1.0) if articulation.prismatic[index] else ("angular", math.degrees(1.0))

    def add(attribute: str, read: Callable[[], Any], command: str = "") -> None:
        """Add an attribute of the joint.

        Args:
            attribute: USD name of the attribute.
            read: returns an array with one value per joint of the robot; the attribute is this joint's value.
            command: keyword of `JointSelection.command` that sets the attribute; empty if the attribute is read-only.
        """

        def write(value: Any) -> None:
            selection.command(**{command: [numbers([value], 1)[0] / unit]})

        found[attribute] = Attribute(lambda: float(read()[index]) * unit, write if command else None)

    add(f"state:{kind}:physics:position", articulation.positions)
    add(f"state:{kind}:physics:velocity", articulation.velocities)
    stiff, damped = (not math.isnan(targets[index]) for targets in articulation.set_points())
    if stiff:
        add(f"drive:{kind}:physics:targetPosition", lambda: articulation.set_points()[0], "positions")
    if damped:
        add(f"drive:{kind}:physics:targetVelocity", lambda: articulation.set_points()[1], "velocities")
    return found


def of_gravity(world: World) -> dict[str, Attribute]:
    """Return the attributes of gravity: its direction as a unit vector in the world frame, and its magnitude in m/s2."""

    def magnitude() -> float:
        return math.hypot(*world.gravity)

    def direction() -> list[float]:
        size = magnitude()
        return [part / size for part in world.gravity] if size else [0.0, 0.0, -1.0]

    def fall(way: Sequence[float], strength: float) -> None:
        size = math.hypot(*way)
        if not 0.0 < size < math.inf or not 0.0 <= strength <= STRONGEST_GRAVITY:
            text = f"gravity needs a direction other than zero, and a magnitude from 0 to {STRONGEST_GRAVITY:g} m/s2"
            raise ContextError(text, strength)
        x, y, z = (strength * part / size for part in way)
        world.set_gravity((x, y, z))

    return {
        "physics:gravityDirection": Attribute(direction, lambda value: fall(numbers(value, 3), magnitude())),
        "physics:gravityMagnitude": Attribute(magnitude, lambda value: fall(direction(), numbers([value], 1)[0])),
    }


def of_friction(world: World, prim: Prim) -> dict[str, Attribute]:
    """Return the attributes of a material: its coefficients of static and dynamic friction.

    They are read-only if the material is bound to a link that is fixed to the world, because such a link has no body of its own.
    """
    reachable = len(prim.facts["bodies"]) == len(prim.facts["bind"])

    def coefficient(index: int) -> Attribute:
        def write(value: Any) -> None:
            changed = list(world.friction(prim))
            changed[index] = _not_negative(value)
            world.set_friction(prim, (changed[0], changed[1]))

        return Attribute(lambda: world.friction(prim)[index], write if reachable else None)

    return {"physics:staticFriction": coefficient(0), "physics:dynamicFriction": coefficient(1)}


def of_light(world: World, prim: Prim) -> dict[str, Attribute]:
    """Return the attributes of a light: its intensity as a multiple of the initial one, and its colour (red, green, blue)."""

    def brighten(value: Any) -> None:
        world.set_light(prim, (_bright(numbers([value], 1))[0], world.light(prim)[1]))

    def colour(value: Any) -> None:
        red, green, blue = _bright(numbers(value, 3))
        world.set_light(prim, (world.light(prim)[0], (red, green, blue)))

    return {
        "inputs:intensity": Attribute(lambda: world.light(prim)[0], brighten),
        "inputs:color": Attribute(lambda: list(world.light(prim)[1]), colour),
    }


def _bright(found: list[float]) -> list[float]:
    for number in found:
        if not 0 <= number <= BRIGHTEST:
            raise ContextError(f"the value must be a value from 0 to {BRIGHTEST:g}, not {shown(number)}", number)
    return found


def _not_negative(value: Any) -> float:
    (number,) = numbers([value], 1)
    if number < 0:
        raise ContextError(f"the value must be 0 or more, not {shown(value)}", value)
    return number
