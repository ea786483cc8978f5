"""The Protocol of the world, through which the engine and the nodes reach physics and sensors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
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
from graphengine.format.faults import Faults
from graphengine.format.wording import did_you_mean, listing

D = TypeVar("D")

Friction = tuple[float, float]
"""Static and dynamic friction coefficients."""

Light = tuple[float, Vector3]
"""Intensity as a multiple of its initial value, and colour (red, green, blue)."""


class Entities(Protocol):
    """Access to the entities of a world: its robots and objects. Methods may be called only between two steps."""

    def all(self) -> Sequence[Entity]:
        """Return all robots in the order in which they were added, then all other objects."""

    def state(self, name: str) -> EntityState:
        """Return the pose, velocity and acceleration of an entity.

        Raises:
            UnknownEntityError: no entity has this name. All methods with the argument `name` raise this error.
        """

    def bounds(self, name: str, *, own: bool = False) -> Box | None:
        """Return the bounding box of an entity; None if the entity has no geometry of finite size.

        Args:
            name: name of the entity.
            own: whether the box is in the frame of the entity, and parallel to the axes of this frame; if false, the world frame.
        """

    def overlaps(self, name: str, *, floors: bool = True) -> Sequence[Overlap]:
        """Return the overlaps of an entity with other objects, deepest first; overlaps of less than 5 mm are left out.

        Args:
            name: name of the entity.
            floors: whether overlaps with planes below the entity count; such a plane lifts the entity out.
        """

    def clearance(self, name: str, position: tuple[float, float], margin: float) -> Mapping[str, float]:
        """Return a dict from each neighbour that an entity would have at another position to the distance (m), nearest first.

        The distance is the smallest in a full turn of the entity about the vertical axis through its prim's origin; it is 0 if
        the entity would overlap the neighbour.

        Args:
            name: name of the entity.
            position: x and y of the entity's prim in the world frame, m.
            margin: largest distance that counts, m.
        """

    def touching(self) -> Mapping[str, Overlap]:
        """Return a dict from the name of each entity to its deepest contact after the last step.

        Contacts with the floor or body on which an entity rests are ignored. Entities without other contacts are left out.
        """

    def touched(self, name: str) -> Sequence[str]:
        """Return the names of all bodies, including floors, that an entity touched in any physics step of this tick.

        The first call for an entity covers only the contacts after the last step, and starts the observation of later steps.
        For a geom that belongs to no entity, the name of the geom is returned.
        """

    def place(self, name: str, move: Move, *, forced: bool = True) -> None:
        """Set the pose and velocity of an entity, and keep the states of its joints; `reset_state` moves the entity back.

        Args:
            name: name of the entity.
            move: new pose and velocity.
            forced: whether the entity is placed at a new pose even if it then overlaps others deeper than now; floors do not
                count as others.

        Raises:
            BlockedPoseError: `forced` is false, and the entity would overlap others; it keeps its pose and velocity.
            UsageError: a number is not finite or too large, a velocity is given for an entity that is fixed to the world, or the
                entity is attached to a joint of the world. The entity then keeps its pose and velocity.
        """

    def reset(
        self, name: str, move: Move, joints: Mapping[str, float], keyframe: str | None, *, forced: bool = True
    ) -> None:
        """Return a robot to its initial pose, joint positions and commands, with zero velocities; reset its sensors.

        Args:
            name: name of the robot.
            move: pose in place of the initial pose; a part that is None keeps its initial value.
            joints: a dict from names of joints that do not mimic others to positions in place of the initial ones, rad or m. The
                drives of these joints hold the positions.
            keyframe: name of a keyframe of the robot's MuJoCo model in place of the initial state; None for the initial state.
            forced: whether the robot is placed even if it then overlaps others; see `place`.

        Raises:
            BlockedPoseError: `forced` is false, and the robot would overlap others at the pose in `move`; nothing has changed.
                The initial pose is not checked.
            UsageError: the robot cannot have this pose or these joint positions; nothing has changed.
        """

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Apply a force to an entity from the next step on, in addition to other forces; `reset_state` ends the force.

        Args:
            name: name of the entity.
            force: force in the world frame, N.
            duration: duration of the force, s, greater than 0. If the force ends within a step, a proportional part of it acts
                during the whole step.
            point: point of application in the world frame, m; it moves with the entity. None stands for the centre of mass.

        Raises:
            UsageError: a number is not finite or too large, `duration` is not positive, or the entity is fixed to the world.
        """


class World(Protocol):
    """The physics and the sensors of a scene. The handles that its methods return stay valid as long as the world exists."""

    @property
    def stage(self) -> Stage:
        """The prim tree of the world; handles are requested for its prims."""

    @property
    def tick_period(self) -> tuple[int, int]:
        """Time between two ticks, s, as an exact fraction: numerator and denominator."""

    @property
    def substeps(self) -> int:
        """Number of physics steps per tick."""

    seed: int
    """Seed of the sensors' noise."""

    realtime: bool
    """Whether ticks follow the wall clock. If so, late camera images are dropped; if not, ticks wait for them."""

    faults: Faults
    """Current faults of sensors; `reset_time` ends them."""

    @property
    def dropped_pictures(self) -> Mapping[str, int]:
        """A dict from the prim path of a camera to the number of images dropped since the start of play by slow rendering.

        Cameras without dropped images are left out.
        """

    clamps_commands: bool
    """Whether commands beyond the limits of a joint are clamped to these limits; otherwise they are applied unchanged."""

    @property
    def clamped_commands(self) -> Mapping[str, int]:
        """A dict from a limit of a joint to the number of commands that were clamped to it.

        A limit is a text such as `velocity of /dd100/left_wheel beyond -10 to 10`. Limits without clamped commands are left out.
        """

    @property
    def gravity(self) -> Vector3:
        """Acceleration of gravity in the world frame, m/s2, such as (0, 0, -9.81)."""

    def set_gravity(self, gravity: Vector3) -> None:
        """Set gravity from the next step on; `reset_state` restores the original gravity.

        Args:
            gravity: acceleration in the world frame, m/s2; the numbers must be finite.
        """

    def friction(self, prim: Prim) -> Friction:
        """Return the static and dynamic friction coefficients of a material prim."""

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Set the friction of a material from the next step on; `reset_state` restores the original friction.

        Args:
            prim: prim of the material.
            friction: coefficients of static and dynamic friction; they must be finite and not negative.
        """

    def conveyor(self, prim: Prim) -> Surface:
        """Make a body a conveyor, and return a handle to its surface velocity, which is initially zero.

        Args:
            prim: prim of a body that is fixed to the world or to another body.

        Raises:
            ContextError: a joint moves the body.
        """

    def light(self, prim: Prim) -> Light:
        """Return the intensity and colour of a light prim."""

    def set_light(self, prim: Prim, light: Light) -> None:
        """Set the intensity and colour of a light for all later images; `reset_state` restores the original values.

        Args:
            prim: prim of the light.
            light: intensity and colour; the numbers must be finite and not negative.
        """

    def bodies(self) -> Bodies:
        """Return all bodies and their visible shapes; only adding or removing a robot changes the result."""

    def poses(self) -> NDArray[np.float64]:
        """Return the position (m) and quaternion (x, y, z, w) of each body in the world frame: a new array, shape (bodies, 7)."""

    def contacts(self) -> Contacts:
        """Return all contact points of the current state with their forces, except for contacts of sleeping bodies."""

    def body(self, prim: Prim) -> Body:
        """Return a handle to the pose and velocity of a prim that is a rigid body or is fixed to one."""

    def frame(self, prim: Prim) -> Frame:
        """Return a handle to the pose of any prim."""

    def mass(self, prim: Prim) -> float:
        """Return the mass of the prim's own body, kg."""

    def placement(self, prim: Prim) -> Placement | None:
        """Return a handle that moves a prim to a pose and holds it there; None if the prim cannot be moved separately."""

    def articulation(self, robot: Prim) -> Articulation:
        """Return a handle to the movable joints of a robot prim."""

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """Return a handle to the sensor or gripper at a prim. Calls with equal arguments return the same object.

        Args:
            interface: Protocol of the device, such as `Lidar`.
            prim: prim of the device.
            options: for a camera, `size` is the width and height of its images in pixels; other devices have no options.
        """

    @property
    def rays_in_use(self) -> str:
        """Name of the method that casts the rays of sensors; empty until a sensor with rays is used."""

    def picture_driver(self) -> str:
        """Return the name and version of the graphics driver that renders camera images."""

    @property
    def entities(self) -> Entities:
        """Access to the robots and objects of the world."""

    def step(self) -> None:
        """Apply the joint targets and integrate one physics step; all handles then return the new state.

        Raises:
            PhysicsError: the state became infinite or NaN.
        """

    def begin_tick(self, tick: int) -> None:
        """Update the sensors for a tick; called after the tick's last physics step.

        Args:
            tick: number of the tick since the start of play; the first is 1. Its time is `tick` times the tick period.
        """

    def zero_commands(self) -> None:
        """Set the target velocity and the effort of every joint to zero; position targets stay."""

    def reset_state(self) -> None:
        """Reset bodies, joints and commands to their initial state, and end all pushes; the tick count continues."""

    def reset_time(self) -> None:
        """Reset the tick count and the sensors' sample indices to 0; bodies and joints keep their state."""

    def save(self) -> Any:
        """Return a copy of the world's state, to be passed to `restore`."""

    def restore(self, saved: Any) -> None:
        """Restore a state that `save` returned for the same robots. Equal inputs then give results that are equal bit by bit."""

    def close(self) -> None:
        """Release all resources of the world; safe to call twice."""


def select_joints(articulation: Articulation, names: Sequence[str], indices: Sequence[int]) -> list[int]:
    """Return the indices of the selected joints: those of `names`; without names, `indices`; with neither, all joints.

    The name of an actuator selects the joint that it moves. An actuator that moves several joints or none has an index of its
    own; these indices follow the indices of the joints.

    Raises:
        JointError: the articulation has no joint or actuator with a given name, or an index is out of range.
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
            text = f"{articulation.prim_path} has no joint with index {index}"
            raise JointError(text, index, f"legal: 0 to {len(known) - 1}")
    return [places[name] for name in names] or [int(index) for index in indices] or list(range(len(known)))


def follower_warnings(articulation: Articulation, names: Collection[str]) -> list[str]:
    """Return a warning for each named joint that mimics another joint; the warning advises to command the other joint."""
    leaders, robot = zip(articulation.joint_names, articulation.leaders, strict=True), articulation.prim_path
    followers = [(name, leader) for name, leader in leaders if leader and name in names]
    return [f"joint {name} of {robot} follows {leader}: command {leader} instead" for name, leader in followers]


def joint_numbers(articulation: Articulation, names: Sequence[str]) -> list[int]:
    """Return the indices of the joints with these names; without names, the indices of all joints.

    The name of an actuator selects the joint that it moves.

    Raises:
        JointError: a name is neither that of a joint nor that of an actuator, or an actuator does not move exactly one joint.
    """
    known, found = articulation.joint_names, select_joints(articulation, names, ())
    for name, index in zip(names, found, strict=False):
        if index >= len(known):
            text = f"actuator {name!r} of {articulation.prim_path} has no position: it does not move exactly one joint"
            raise JointError(text, name, listing(known, "joints"))
    return found
