"""Prims as USD shows them: types, and attributes with their values as JSON has them.

Attributes are those that something here stands behind: poses relative to the parent prim, masses, what joints and their drives
do, gravity, friction of materials, lights, the clipping range of cameras, and the two names that the reference writes on prims.
Angles are in degrees, as USD has them. What the physics and the cameras can be told while they run can be written: where a robot
or a free body is, the targets of drives, gravity, friction, and lights. Bodies slide by the dynamic friction; the static one,
which MuJoCo does not have, is kept and does nothing.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

from graphengine.backend import World
from graphengine.context import Articulation
from graphengine.diagnostics import ContextError, did_you_mean, listing, shown
from graphengine.rotation import Pose, compose, relative
from graphengine.stage import PHYSICS_SCENE, Prim, PrimKind
from graphengine.types import PortType, coerce

USD_TYPES: Mapping[PrimKind, str] = MappingProxyType(
    {
        "scope": "Scope",
        "robot": "Xform",
        "link": "Xform",
        "frame": "Xform",
        "body": "Xform",
        "sensor": "Xform",
        "lidar": "OmniLidar",
        "camera": "Camera",
        "imu": "IsaacImuSensor",
        "contact": "IsaacContactSensor",
        "material": "Material",
        "graph": "OmniGraph",
    }
)
_JOINT_TYPES = {
    "revolute": "PhysicsRevoluteJoint",
    "continuous": "PhysicsRevoluteJoint",
    "prismatic": "PhysicsPrismaticJoint",
    "fixed": "PhysicsFixedJoint",
}
STRONGEST_GRAVITY = 1000.0
"""m/s2, some forty times that of Jupiter."""
BRIGHTEST = 1e6
"""Of intensities and colours: far more than any picture shows, and their product is a number to OpenGL."""
_WITHOUT_POSE = ("scope", "joint", "material", "graph")


PORT_TYPES: Mapping[str, PortType] = MappingProxyType(
    {
        "bool": PortType("bool"),
        "color3f": PortType("float", 3, role="color"),
        "double3": PortType("double", 3),
        "float": PortType("float"),
        "float2": PortType("float", 2),
        "quatd": PortType("double", 4, role="quat"),
        "string": PortType("string"),
        "vector3f": PortType("float", 3, role="vector"),
    }
)
"""OmniGraph's types by those of USD, for all that attributes have."""


def type_of_attribute(name: str) -> PortType | None:
    """OmniGraph's type of an attribute by its name, which is the same on every prim; None for one that no prim has."""
    if name.startswith(("state:", "drive:")):
        return PORT_TYPES["float"] if _OF_JOINTS.fullmatch(name) else None
    return PORT_TYPES.get(_TYPES.get(name, ""))


_TYPES = {"xformOp:translate": "double3", "xformOp:orient": "quatd", "physics:mass": "float", "clippingRange": "float2"}
_TYPES |= {"physics:gravityDirection": "vector3f", "physics:gravityMagnitude": "float"}
_TYPES |= {"physics:staticFriction": "float", "physics:dynamicFriction": "float"}
_TYPES |= {"inputs:intensity": "float", "inputs:color": "color3f"}
_TYPES |= {"physics:jointEnabled": "bool", "isaac:namespace": "string", "isaac:nameOverride": "string"}
_OF_JOINTS = re.compile(
    r"(state:(angular|linear):physics:|drive:(angular|linear):physics:target)([Pp]osition|[Vv]elocity)"
)


@dataclass(frozen=True, slots=True)
class Attribute:
    """One attribute of a prim.

    Attributes:
        type: as USD calls it.
        read: its value, as JSON has it.
        write: changes it; None where it cannot be changed while the simulation runs.
    """

    type: str
    read: Callable[[], Any]
    write: Callable[[Any], None] | None = None


class BoundAttribute:
    """An attribute of a prim, with its value as ports carry it."""

    def __init__(self, place: str, attribute: Attribute) -> None:
        self._place = place
        self._attribute = attribute
        self._type = PORT_TYPES[attribute.type]

    def read(self) -> Any:
        """Its value now."""
        value = self._attribute.read()
        if self._type.role == "quat":
            w, x, y, z = value
            return x, y, z, w
        return tuple(value) if isinstance(value, list) else value

    def write(self, value: Any) -> None:
        """Change it.

        Raises:
            ContextError: to that it cannot be changed.
        """
        assert self._attribute.write is not None  # it was asked for to be written
        try:
            given = coerce(value, self._type)
        except (TypeError, ValueError) as error:
            raise ContextError(f"{self._place} is a {self._type}: {error}, got {shown(value)}", value) from None
        if self._type.role == "quat":
            x, y, z, w = given
            given = (w, x, y, z)
        try:
            self._attribute.write(list(given) if isinstance(given, tuple) else given)
        except ContextError as error:
            raise ContextError(f"{self._place}: {error.message}", error.value, *error.help) from None


class StagePrims:
    """The prims of a world."""

    def __init__(self, world: World) -> None:
        self._world = world

    def below(self, path: str) -> Sequence[tuple[str, str]]:
        """Paths and types of a prim and of all below it, depth first.

        Raises:
            PrimError: there is no such prim.
        """
        return [(prim.path, usd_type(prim)) for prim in self._world.stage.find(path).descendants()]

    def attributes(self, path: str) -> Mapping[str, str]:
        """Types of a prim's attributes by their names.

        Raises:
            PrimError: there is no such prim.
        """
        return {name: attribute.type for name, attribute in self._of(path).items()}

    def read(self, path: str, attribute: str) -> tuple[str, Any]:
        """The type and the value of an attribute.

        Raises:
            ContextError: there is no such prim or attribute.
        """
        found = self._find(path, attribute)
        return found.type, found.read()

    def write(self, path: str, attribute: str, value: Any) -> None:
        """Change an attribute.

        Raises:
            GraphError: there is no such prim or attribute, it cannot be changed, or not to that.
        """
        found = self._find(path, attribute)
        if found.write is None:
            raise self._fixed(path, attribute)
        found.write(value)

    def attribute(self, path: str, name: str, *, writable: bool) -> BoundAttribute:
        """An attribute to keep.

        Raises:
            ContextError: there is no such prim or attribute, or it cannot be changed although it has to be.
        """
        found = self._find(path, name)
        if writable and found.write is None:
            raise self._fixed(path, name)
        return BoundAttribute(f"{name} of {path}", found)

    def _fixed(self, path: str, name: str) -> ContextError:
        changing = [other for other, attribute in self._of(path).items() if attribute.write is not None]
        hint = listing(changing, "what can be changed there") if changing else "nothing can be changed there"
        return ContextError(f"{name} of {path} cannot be changed while the simulation runs", name, hint)

    def _find(self, path: str, attribute: str) -> Attribute:
        attributes = self._of(path)
        if attribute not in attributes:
            near = did_you_mean(attribute, attributes) or listing(attributes, "attributes")
            raise ContextError(f"{path} has no attribute {attribute!r}", attribute, near)
        return attributes[attribute]

    def _of(self, path: str) -> dict[str, Attribute]:
        world, prim = self._world, self._world.stage.find(path)
        found: dict[str, Attribute] = {}
        if prim.kind not in _WITHOUT_POSE:
            found |= _pose_attributes(_Pose(world, prim))
        if prim.body is not None:
            found["physics:mass"] = Attribute("float", partial(world.mass, prim))
        if _is_physics_scene(prim):
            found |= _gravity_attributes(world)
        if prim.kind == "joint":
            found |= _joint_attributes(world, prim)
        if prim.kind == "material":
            found |= _friction_attributes(world, prim)
        if prim.kind == "light":
            found |= _light_attributes(world, prim)
        if prim.kind == "camera":
            found["clippingRange"] = Attribute("float2", lambda: list(world.camera(prim).clip))
        if prim.namespace:
            found["isaac:namespace"] = Attribute("string", lambda: prim.namespace)
        if prim.name_override:
            found["isaac:nameOverride"] = Attribute("string", lambda: prim.name_override)
        return found


class _Pose:
    """Where a prim is, relative to its parent."""

    def __init__(self, world: World, prim: Prim) -> None:
        self.movable = any(entity.prim_path == prim.path for entity in world.entities.all())
        self._world = world
        self._prim = prim

    def translate(self) -> list[float]:
        """Position, m."""
        return list(self._read()[0])

    def orient(self) -> list[float]:
        """Orientation, the real part first."""
        x, y, z, w = self._read()[1]
        return [w, x, y, z]

    def set_translate(self, value: Any) -> None:
        """Move it, and leave its orientation."""
        x, y, z = _numbers(value, 3)
        self._put(((x, y, z), self._read()[1]))

    def set_orient(self, value: Any) -> None:
        """Turn it, and leave its position."""
        w, x, y, z = _numbers(value, 4)
        self._put((self._read()[0], (x, y, z, w)))

    def _parent(self) -> Pose:
        assert self._prim.parent is not None  # the root has no pose
        return self._world.frame(self._prim.parent).pose()

    def _read(self) -> Pose:
        return relative(self._parent(), self._world.frame(self._prim).pose())

    def _put(self, pose: Pose) -> None:
        """Let it go on from there as fast as it was."""
        self._world.entities.place(
            self._prim.path, *compose(self._parent(), pose), *self._world.body(self._prim).velocity()
        )


def _pose_attributes(pose: _Pose) -> dict[str, Attribute]:
    return {
        "xformOp:translate": Attribute("double3", pose.translate, pose.set_translate if pose.movable else None),
        "xformOp:orient": Attribute("quatd", pose.orient, pose.set_orient if pose.movable else None),
    }


class _Joint:
    """A joint that moves, in degrees or metres."""

    def __init__(self, articulation: Articulation, name: str) -> None:
        self._articulation = articulation
        self._selection = articulation.select([name])
        self._index = articulation.joint_names.index(name)
        slides = articulation.prismatic[self._index]
        self.kind, self.unit = ("linear", 1.0) if slides else ("angular", math.degrees(1.0))

    def position(self) -> float:
        """Where it is."""
        return float(self._articulation.positions()[self._index]) * self.unit

    def velocity(self) -> float:
        """How fast it moves, in units a second."""
        return float(self._articulation.velocities()[self._index]) * self.unit

    def target_position(self) -> float:
        """Where its drive wants it; NaN without stiffness."""
        return float(self._articulation.set_points()[0][self._index]) * self.unit

    def target_velocity(self) -> float:
        """How fast its drive wants it; NaN without damping."""
        return float(self._articulation.set_points()[1][self._index]) * self.unit

    def set_target_position(self, value: Any) -> None:
        """Tell the drive."""
        self._selection.command(positions=[_numbers([value], 1)[0] / self.unit])

    def set_target_velocity(self, value: Any) -> None:
        """Tell the drive."""
        self._selection.command(velocities=[_numbers([value], 1)[0] / self.unit])


def _joint_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """What a joint does, and what its drive is told."""
    found = {"physics:jointEnabled": Attribute("bool", lambda: bool(prim.facts.get("enabled", True)))}
    robot, name = world.stage.robot_of(prim), prim.facts.get("joint", prim.name)
    if robot is None or name not in robot.facts.get("joints", ()):
        return found
    joint = _Joint(world.articulation(robot), name)
    state, drive = f"state:{joint.kind}:physics", f"drive:{joint.kind}:physics"
    found[f"{state}:position"] = Attribute("float", joint.position)
    found[f"{state}:velocity"] = Attribute("float", joint.velocity)
    if not math.isnan(joint.target_position()):
        found[f"{drive}:targetPosition"] = Attribute("float", joint.target_position, joint.set_target_position)
    if not math.isnan(joint.target_velocity()):
        found[f"{drive}:targetVelocity"] = Attribute("float", joint.target_velocity, joint.set_target_velocity)
    return found


def _gravity_attributes(world: World) -> dict[str, Attribute]:
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
            "vector3f", direction, lambda value: fall(_numbers(value, 3), math.hypot(*world.gravity))
        ),
        "physics:gravityMagnitude": Attribute(
            "float", lambda: math.hypot(*world.gravity), lambda value: fall(direction(), _numbers([value], 1)[0])
        ),
    }


def _friction_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
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


def _light_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """How bright a light is, in times of what it is at the start, and its colour."""

    def brighten(value: Any) -> None:
        world.set_light(prim, (_bright(_numbers([value], 1))[0], world.light(prim)[1]))

    def colour(value: Any) -> None:
        red, green, blue = _bright(_numbers(value, 3))
        world.set_light(prim, (world.light(prim)[0], (red, green, blue)))

    return {
        "inputs:intensity": Attribute("float", lambda: world.light(prim)[0], brighten),
        "inputs:color": Attribute("color3f", lambda: list(world.light(prim)[1]), colour),
    }


def _bright(numbers: list[float]) -> list[float]:
    for number in numbers:
        if not 0 <= number <= BRIGHTEST:
            raise ContextError(f"it has to be 0 to {BRIGHTEST:g}, not {shown(number)}", number)
    return numbers


def _not_negative(value: Any) -> float:
    (number,) = _numbers([value], 1)
    if number < 0:
        raise ContextError(f"it has to be 0 or more, not {shown(value)}", value)
    return number


def _is_physics_scene(prim: Prim) -> bool:
    return prim.path == PHYSICS_SCENE and prim.kind == "scope"


def usd_type(prim: Prim) -> str:
    """The name of a prim's type."""
    if _is_physics_scene(prim):
        return "PhysicsScene"
    if prim.kind == "light":
        return "DistantLight" if prim.facts.get("directional") else "SphereLight"
    if prim.kind == "joint":
        return _JOINT_TYPES.get(prim.facts.get("type", ""), "PhysicsJoint")
    return USD_TYPES[prim.kind]


def _numbers(value: Any, count: int) -> list[float]:
    """Finite numbers of a JSON array.

    Raises:
        ContextError: it holds anything else.
    """
    if isinstance(value, list) and len(value) == count and all(type(number) in (int, float) for number in value):
        with contextlib.suppress(OverflowError):
            numbers = [float(number) for number in value]
            if all(map(math.isfinite, numbers)):
                return numbers
    what = "a finite number" if count == 1 else f"an array of {count} finite numbers"
    several = isinstance(value, list) and len(value) == count
    given = f"[{', '.join(map(shown, value))}]" if several and count > 1 else shown(value[0] if several else value)
    raise ContextError(f"it has to be {what}, not {given}", value)
