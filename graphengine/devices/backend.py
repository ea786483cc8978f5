"""The interface between the engine and the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.entity import Box, Entity, EntityState, Move, Overlap
from graphengine.devices.motion import Articulation, Body, Frame, Placement
from graphengine.devices.rotation import Vector3
from graphengine.devices.stage import Prim, Stage
from graphengine.devices.visible import Bodies
from graphengine.format.errors import JointError
from graphengine.format.wording import did_you_mean, listing

D = TypeVar("D")

Friction = tuple[float, float]
"""Static and dynamic friction."""

Light = tuple[float, Vector3]
"""Intensity as a multiple of its initial value, and colour (red, green, blue)."""


class Entities(Protocol):
    """The robots and objects of a world, each as one entity; methods are called between two steps."""

    def all(self) -> Sequence[Entity]:
        """All robots in the order they were added, then all other objects."""

    def state(self, name: str) -> EntityState:
        """Pose and velocity of an entity.

        Raises:
            UnknownEntityError: no entity has the name; all methods below raise it too.
        """

    def bounds(self, name: str, *, own: bool = False) -> Box | None:
        """The bounding box of an entity in the world frame or its own frame; None without geometry of finite size."""

    def overlaps(self, name: str) -> Sequence[Overlap]:
        """Objects that an entity overlaps, deepest first. Light contact does not count."""

    def touching(self) -> Mapping[str, Overlap]:
        """The deepest contact of each entity that touches anything but what carries it, after the last step."""

    def place(self, name: str, move: Move) -> None:
        """Move an entity; its joint states stay, and `reset` puts it back.

        Raises:
            UsageError: a number is not finite or too large, or the entity hangs on a joint; nothing has changed.
        """

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Apply a force to an entity from the next step on, in addition to other forces; `reset` ends it.

        Args:
            name: name of the entity.
            force: force in the world frame, N.
            duration: s; for a part of a step, the force is scaled by that part.
            point: where the force acts, in the world frame, m; it then moves with the entity. None is the centre of mass.

        Raises:
            UsageError: as for `place`, or the entity cannot move.
        """


class World(Protocol):
    """Physics and sensors of a scene. Handles stay valid as long as the world exists."""

    @property
    def stage(self) -> Stage:
        """The prim tree that the handles belong to."""

    @property
    def tick_period(self) -> tuple[int, int]:
        """Seconds between two ticks as numerator and denominator, exact."""

    @property
    def substeps(self) -> int:
        """Physics steps in a tick."""

    seed: int
    """Seed of the sensors' noise."""

    realtime: bool
    """Whether ticks follow the wall clock. If so, late pictures are dropped, else ticks wait for them."""

    @property
    def dropped_pictures(self) -> Mapping[str, int]:
        """Numbers of pictures since play that were rendered too late, by the camera's prim path; without zeros."""

    clamps_commands: bool
    """Whether commands beyond a joint's limits are clamped."""

    @property
    def clamped_commands(self) -> Mapping[str, int]:
        """Numbers of commands clamped to a limit, by kind, joint and limit; without zeros."""

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall in the world frame, m/s2."""

    def set_gravity(self, gravity: Vector3) -> None:
        """Set gravity from the next step on; `reset_state` restores the original.

        Args:
            gravity: acceleration in the world frame, m/s2; finite.
        """

    def friction(self, prim: Prim) -> Friction:
        """Static and dynamic friction of a material prim."""

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Set the friction of a material from the next step on; `reset_state` restores the original.

        Args:
            prim: prim of the material.
            friction: static and dynamic friction; finite, not negative.
        """

    def light(self, prim: Prim) -> Light:
        """Intensity and colour of a light prim."""

    def set_light(self, prim: Prim, light: Light) -> None:
        """Set intensity and colour of a light for later pictures; `reset_state` restores the original.

        Args:
            prim: prim of the light.
            light: intensity and colour; finite, not negative.
        """

    def bodies(self) -> Bodies:
        """All bodies and their visible shapes; others after a robot was added or removed."""

    def poses(self) -> NDArray[np.float64]:
        """Position (m) and quaternion (x, y, z, w) of each body in the world frame, shape (bodies, 7); a fresh array."""

    def contacts(self) -> Contacts:
        """All contact points of the present state with their forces; contacts of bodies that sleep are left out."""

    def body(self, prim: Prim) -> Body:
        """The rigid body of a prim, or the one that carries it."""

    def frame(self, prim: Prim) -> Frame:
        """The pose of a prim."""

    def mass(self, prim: Prim) -> float:
        """Mass of the prim's own body, kg."""

    def placement(self, prim: Prim) -> Placement | None:
        """A handle that places the prim's body and holds it there; None if the body cannot be moved on its own."""

    def articulation(self, robot: Prim) -> Articulation:
        """The joints of a robot prim."""

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """The device at a prim; equal options give the same object.

        Args:
            interface: Protocol of the device.
            prim: prim of the device.
            options: options of the kind: a camera has `size`, width and height of its pictures in pixels.
        """

    @property
    def rays_in_use(self) -> str:
        """Name of the ray casting method of lidars; empty before the first lidar is requested."""

    def picture_driver(self) -> str:
        """Name and version of the driver that renders camera pictures."""

    @property
    def entities(self) -> Entities:
        """The robots and objects of the world."""

    def step(self) -> None:
        """Apply the joints' targets and integrate one substep; afterwards every handle reads the new state.

        Raises:
            PhysicsError: the state became infinite or NaN.
        """

    def begin_tick(self, tick: int) -> None:
        """Update the sensors to tick n at time n times the tick period; called after the tick's last substep."""

    def zero_commands(self) -> None:
        """Set every joint's target velocity and effort to zero."""

    def reset_state(self) -> None:
        """Reset bodies, joints and commands to their initial state and end all forces; the tick count continues."""

    def reset_time(self) -> None:
        """Reset the tick count and the sensors' sample numbers to 0; bodies and joints stay where they are."""

    def save(self) -> Any:
        """A copy of the state, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Return to a saved state of the same robots; the simulation then repeats bit by bit."""

    def close(self) -> None:
        """Release all resources; safe to call twice."""


def select_joints(articulation: Articulation, names: Sequence[str], indices: Sequence[int]) -> list[int]:
    """Positions of the selected joints in the articulation: by name, else by index, else all.

    Raises:
        JointError: the articulation has no joint with a name or index.
    """
    known = articulation.joint_names
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) or listing(known, "joints")
            raise JointError(f"{articulation.prim_path} has no joint {name!r}", name, hint)
    for index in indices:
        if not 0 <= index < len(known):
            raise JointError(f"{articulation.prim_path} has no joint {index}", index, f"legal: 0 to {len(known) - 1}")
    return [known.index(name) for name in names] or [int(index) for index in indices] or list(range(len(known)))
