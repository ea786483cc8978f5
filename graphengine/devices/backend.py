"""The interface between the engine and the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.contact_points import Contacts
from graphengine.devices.entity import Box, Entity, EntityState, Move, Overlap
from graphengine.devices.motion import Articulation, Body, Frame, Placement, Surface
from graphengine.devices.rotation import Vector3
from graphengine.devices.stage import Prim, Stage
from graphengine.devices.visible import Bodies
from graphengine.format.errors import JointError
from graphengine.format.wording import did_you_mean, listing

D = TypeVar("D")

Friction = tuple[float, float]
"""Static and dynamic friction coefficients."""

Light = tuple[float, Vector3]
"""Intensity as a multiple of its initial value, and colour (red, green, blue)."""


class Entities(Protocol):
    """The robots and objects of a world, each as one entity; methods are called between two steps."""

    def all(self) -> Sequence[Entity]:
        """All robots in the order they were added, then all other objects."""

    def state(self, name: str) -> EntityState:
        """Return the pose, velocity and acceleration of an entity.

        Raises:
            UnknownEntityError: no entity has the name. The other methods with a `name` raise it too.
        """

    def bounds(self, name: str, *, own: bool = False) -> Box | None:
        """Return the bounding box of an entity in the world frame, or in its own frame if `own` is true.

        None without geometry of finite size.
        """

    def overlaps(self, name: str) -> Sequence[Overlap]:
        """Return the overlaps of an entity with other objects, deepest first; contacts of less than 5 mm depth do not count."""

    def touching(self) -> Mapping[str, Overlap]:
        """Return the deepest contact of each entity after the last step; contacts with the supporting body do not count."""

    def place(self, name: str, move: Move) -> None:
        """Move an entity without changing its joint states; `reset_state` moves it back.

        Raises:
            UsageError: a number is not finite or too large, or a joint of the world carries the entity; nothing has changed.
        """

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Apply a force to an entity from the next step on, in addition to other forces; `reset_state` ends the force.

        Args:
            name: name of the entity.
            force: force in the world frame, N.
            duration: duration of the force, s. In a step that it covers only in part, the force is scaled accordingly.
            point: point of application in the world frame, m, which then moves with the entity. None: the centre of mass.

        Raises:
            UsageError: the errors of `place`, or the entity cannot move.
        """


class World(Protocol):
    """Physics and sensors of a scene. Handles stay valid as long as the world exists."""

    @property
    def stage(self) -> Stage:
        """The prim tree that the handles belong to."""

    @property
    def tick_period(self) -> tuple[int, int]:
        """Time between two ticks, s, as an exact fraction: numerator and denominator."""

    @property
    def substeps(self) -> int:
        """Physics steps in a tick."""

    seed: int
    """Seed of the sensors' noise."""

    realtime: bool
    """Whether ticks follow the wall clock. If so, late pictures are dropped, otherwise ticks wait for them."""

    @property
    def dropped_pictures(self) -> Mapping[str, int]:
        """Number of pictures since play that were rendered too late, by camera prim path; cameras with none are left out."""

    clamps_commands: bool
    """Whether commands beyond a joint's limits are clamped."""

    @property
    def clamped_commands(self) -> Mapping[str, int]:
        """Number of clamped commands, by a text with the kind of command, the joint and its limits. Zero counts are left out."""

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall in the world frame, m/s2."""

    def set_gravity(self, gravity: Vector3) -> None:
        """Set gravity from the next step on; `reset_state` restores the original.

        Args:
            gravity: acceleration in the world frame, m/s2; finite.
        """

    def friction(self, prim: Prim) -> Friction:
        """Return the static and dynamic friction coefficients of a material prim."""

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Set the friction of a material from the next step on; `reset_state` restores the original.

        Args:
            prim: prim of the material.
            friction: static and dynamic friction; finite, not negative.
        """

    def conveyor(self, prim: Prim) -> Surface:
        """Return a handle to the surface velocity of a body; the velocity is initially zero.

        Args:
            prim: prim of a body that is fixed to the world or to another body.

        Raises:
            ContextError: a joint moves the body.
        """

    def light(self, prim: Prim) -> Light:
        """Return the intensity and colour of a light prim."""

    def set_light(self, prim: Prim, light: Light) -> None:
        """Set intensity and colour of a light for later pictures; `reset_state` restores the original.

        Args:
            prim: prim of the light.
            light: intensity and colour; finite, not negative.
        """

    def bodies(self) -> Bodies:
        """Return all bodies and their visible shapes; the result changes when a robot is added or removed."""

    def poses(self) -> NDArray[np.float64]:
        """Return position (m) and quaternion (x, y, z, w) of each body in the world frame: a new array, shape (bodies, 7)."""

    def contacts(self) -> Contacts:
        """Return all contact points of the current state with their forces, except for contacts of sleeping bodies."""

    def body(self, prim: Prim) -> Body:
        """Return the rigid body of a prim, or the rigid body that carries the prim."""

    def frame(self, prim: Prim) -> Frame:
        """Return a handle to the pose of a prim."""

    def mass(self, prim: Prim) -> float:
        """Return the mass of the prim's own body, kg."""

    def placement(self, prim: Prim) -> Placement | None:
        """Return a handle that places the prim's body and holds it there; None if the body cannot be moved on its own."""

    def articulation(self, robot: Prim) -> Articulation:
        """Return the joints of a robot prim."""

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """Return the device at a prim; equal options give the same object.

        Args:
            interface: Protocol of the device.
            prim: prim of the device.
            options: for a camera `size`, the width and height of its pictures in pixels; other devices have no options.
        """

    @property
    def rays_in_use(self) -> str:
        """Name of the ray casting method of lidars; empty before the first lidar is requested."""

    def picture_driver(self) -> str:
        """Return the name and version of the driver that renders camera pictures."""

    @property
    def entities(self) -> Entities:
        """The robots and objects of the world."""

    def step(self) -> None:
        """Apply the joint targets and integrate one substep; all handles then return the new state.

        Raises:
            PhysicsError: the state became infinite or NaN.
        """

    def begin_tick(self, tick: int) -> None:
        """Update the sensors to the time of a tick, `tick` times the tick period; called after the tick's last substep."""

    def zero_commands(self) -> None:
        """Set every joint's target velocity and effort to zero."""

    def reset_state(self) -> None:
        """Reset bodies, joints and commands to their initial state and end all forces; the tick count continues."""

    def reset_time(self) -> None:
        """Reset the tick count and the sensors' sample numbers to 0; bodies and joints stay where they are."""

    def save(self) -> Any:
        """Return a copy of the state, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Return to a saved state of the same robots; the simulation then repeats bit by bit."""

    def close(self) -> None:
        """Release all resources; safe to call twice."""


def select_joints(articulation: Articulation, names: Sequence[str], indices: Sequence[int]) -> list[int]:
    """Return indices of the selected joints: of `names` if given, otherwise `indices` if given, otherwise all joints.

    The name of an actuator selects the joint that it moves. If it moves several joints or none, its index follows those of the
    joints.

    Raises:
        JointError: the articulation has no joint with a name or index.
    """
    known = articulation.joint_names
    others = [name for name, joint in articulation.actuators.items() if not joint and name not in known]
    places = {name: known.index(joint) for name, joint in articulation.actuators.items() if joint}
    places |= {name: index for index, name in enumerate((*known, *others))}
    for name in names:
        if name not in places:
            hint = did_you_mean(name, places) or listing(places, "joints")
            raise JointError(f"{articulation.prim_path} has no joint {name!r}", name, hint)
    for index in indices:
        if not 0 <= index < len(known):
            raise JointError(f"{articulation.prim_path} has no joint {index}", index, f"legal: 0 to {len(known) - 1}")
    return [places[name] for name in names] or [int(index) for index in indices] or list(range(len(known)))


def joint_numbers(articulation: Articulation, names: Sequence[str]) -> list[int]:
    """Return the indices of joints, each given by its own name or that of its actuator; without names, of all joints.

    Raises:
        JointError: no joint or actuator has a name, or the actuator does not move exactly one joint.
    """
    known, found = articulation.joint_names, select_joints(articulation, names, ())
    for name, index in zip(names, found, strict=False):
        if index >= len(known):
            text = f"actuator {name!r} of {articulation.prim_path} does not move a single joint, and has no position"
            raise JointError(text, name, listing(known, "joints"))
    return found
