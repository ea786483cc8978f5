"""Reads and writes USD attributes of the prims of a world.

Attributes that can be read: poses relative to the parent prim, masses, positions and velocities of joints, targets of drives,
gravity, friction of materials, lights, the clipping range of cameras, `isaac:status` of surface grippers, `isaac:nameOverride`
and `isaac:namespace`. Angles are in degrees, as in USD.

Attributes that can be written while the simulation runs: poses of robots and free bodies, targets of drives, gravity, friction
and lights. The static friction is stored but has no effect, because MuJoCo has only one coefficient, the dynamic friction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from graphengine.devices.backend import World
from graphengine.devices.camera import Camera
from graphengine.devices.surface_gripper import SurfaceGripperDevice
from graphengine.format.errors import ContextError
from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.node.prims import attributes
from graphengine.node.prims.attributes import Attribute
from graphengine.node.types import coerce
from graphengine.node.usd_types import ATTRIBUTE_TYPES, is_physics_scene, type_of_attribute, usd_type

_WITHOUT_POSE = ("scope", "joint", "material", "graph")


class Prims:
    """The prims of the stage, with USD types and attributes. Values are read and written as JSON types."""

    def __init__(self, world: World) -> None:
        self._world = world

    def below(self, path: str) -> Sequence[tuple[str, str]]:
        """Return the paths and USD types of a prim and all its descendants, depth first.

        Raises:
            PrimError: no prim has the path.
        """
        return [(prim.path, usd_type(prim)) for prim in self._world.stage.find(path).descendants()]

    def attributes(self, path: str) -> Mapping[str, str]:
        """Return the USD types of a prim's attributes, by attribute name.

        Raises:
            PrimError: no prim has the path.
        """
        return {name: ATTRIBUTE_TYPES[name] for name in self._of(path)}

    def read(self, path: str, attribute: str) -> tuple[str, Any]:
        """Return the USD type and the value of an attribute.

        Raises:
            ContextError: the prim or attribute does not exist.
        """
        value = self._find(path, attribute).read()
        return ATTRIBUTE_TYPES[attribute], value

    def write(self, path: str, attribute: str, value: Any) -> None:
        """Set the value of an attribute in the simulation.

        Raises:
            GraphError: the prim or attribute does not exist, the attribute is read-only, or the value is not legal.
        """
        found = self._find(path, attribute, writable=True)
        assert found.write is not None
        found.write(value)

    def attribute(self, path: str, name: str, *, writable: bool) -> PrimAttribute:
        """Return a handle to an attribute.

        Args:
            path: path of the prim.
            name: USD name of the attribute.
            writable: whether the caller needs to write the attribute.

        Raises:
            ContextError: the prim or attribute does not exist, or `writable` is true and the attribute is read-only.
        """
        return PrimAttribute(path, name, self._find(path, name, writable=writable))

    def _find(self, path: str, name: str, *, writable: bool = False) -> Attribute:
        known = self._of(path)
        if name not in known:
            near = did_you_mean(name, known) or listing(known, "attributes")
            raise ContextError(f"{path} has no attribute {name!r}", name, near)
        if writable and known[name].write is None:
            changing = [other for other, attribute in known.items() if attribute.write is not None]
            hint = listing(changing, "writable attributes") if changing else "the prim has no writable attributes"
            raise ContextError(f"{name} of {path} cannot be changed while the simulation runs", name, hint)
        return known[name]

    def _of(self, path: str) -> dict[str, Attribute]:
        world, prim = self._world, self._world.stage.find(path)
        found: dict[str, Attribute] = {}
        if prim.kind not in _WITHOUT_POSE:
            found |= attributes.of_pose(world, prim)
        if prim.body is not None:
            found["physics:mass"] = Attribute(partial(world.mass, prim))
        if is_physics_scene(prim):
            found |= attributes.of_gravity(world)
        if prim.kind == "joint":
            found |= attributes.of_joint(world, prim)
        if prim.kind == "material":
            found |= attributes.of_friction(world, prim)
        if prim.kind == "light":
            found |= attributes.of_light(world, prim)
        if prim.kind == "camera":
            found["clippingRange"] = Attribute(lambda: list(world.device(Camera, prim).clip))
        if prim.kind == "surface_gripper":
            found["isaac:status"] = Attribute(lambda: world.device(SurfaceGripperDevice, prim).status)
        if prim.namespace:
            found["isaac:namespace"] = Attribute(lambda: prim.namespace)
        if prim.name_override:
            found["isaac:nameOverride"] = Attribute(lambda: prim.name_override)
        return found


class PrimAttribute:
    """A handle to one attribute of a prim. Values have the Python types of ports, and quaternions are (x, y, z, w)."""

    def __init__(self, path: str, name: str, attribute: Attribute) -> None:
        self._place = f"{name} of {path}"
        self._attribute = attribute
        self._type = type_of_attribute(name)

    def read(self) -> Any:
        """Return the current value of the attribute."""
        value = self._attribute.read()
        if self._type.role == "quat":
            w, x, y, z = value
            return x, y, z, w
        return tuple(value) if isinstance(value, list) else value

    def write(self, value: Any) -> None:
        """Set the value of the attribute in the simulation.

        Raises:
            ContextError: the value is not legal for the attribute.
        """
        assert self._attribute.write is not None  # the handle was requested with `writable`
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
