"""What the engine asks of the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from graphengine.devices.entity import Box, Entity, EntityState, Move, Overlap
from graphengine.devices.motion import Articulation, Body, Frame, Placement
from graphengine.devices.sensor import Friction, Light, Vector3
from graphengine.devices.stage import Prim, Stage
from graphengine.format.errors import JointError
from graphengine.format.wording import did_you_mean, listing

D = TypeVar("D")


class Entities(Protocol):
    """The robots and objects of a world as wholes: looked at, put elsewhere and pushed from outside, between two steps."""

    def all(self) -> Sequence[Entity]:
        """Robots in the order they came, then what else stands in the world."""

    def state(self, name: str) -> EntityState:
        """Where an entity is, and how it moves.

        Raises:
            UnknownEntityError: there is none of that name, here and below.
        """

    def bounds(self, name: str, *, own: bool = False) -> Box | None:
        """The box around an entity's geometry, in the world or in the entity's own frame; None where it has none that ends."""

    def overlaps(self, name: str) -> Sequence[Overlap]:
        """What an entity is stuck in, deepest first: physics pushes them apart at once. Light touches do not count."""

    def place(self, name: str, move: Move) -> None:
        """Put an entity elsewhere; its joints go on as they are, and `reset` puts it back.

        Raises:
            UsageError: a number is not finite or beyond all bounds, or the entity hangs on a joint; nothing has changed.
        """

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Let a force act on an entity from the next step on, beside others that do; `reset` ends it.

        Args:
            name: of the entity.
            force: in the world frame, N.
            duration: how long, s; within a step the force acts for a part of it with that part of its strength.
            point: of the world where it acts, which from then on moves with the entity, m; None for its centre of mass.

        Raises:
            UsageError: as for `place`, or nothing can move the entity.
        """


class World(Protocol):
    """Physics and sensors of a scene. Handles stay valid for its life."""

    @property
    def stage(self) -> Stage:
        """The prim tree that the handles belong to."""

    @property
    def tick_period(self) -> tuple[int, int]:
        """Seconds between two ticks as numerator and denominator, exact."""

    @property
    def substeps(self) -> int:
        """Physics steps in a tick."""

    realtime: bool
    """Whether ticks follow the wall clock: a picture that is not ready in time is then dropped, else waited for."""

    @property
    def dropped_pictures(self) -> Mapping[str, int]:
        """How many pictures came too late since play, by prim path of the camera; only where some did."""

    clamps_commands: bool
    """Whether a command to a joint beyond its limits is set to the limit."""

    @property
    def clamped_commands(self) -> Mapping[str, int]:
        """How many commands were set to a limit, by kind, joint and limit; only where some were."""

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall in the world frame, m/s2."""

    def set_gravity(self, gravity: Vector3) -> None:
        """Let bodies fall otherwise from the next step on; `reset_state` takes it back.

        Args:
            gravity: in the world frame, m/s2; finite.
        """

    def friction(self, prim: Prim) -> Friction:
        """Static and dynamic friction of a material prim."""

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Let what a material is bound to slide otherwise from the next step on; `reset_state` takes it back.

        Args:
            prim: of the material.
            friction: static and dynamic; finite, not negative.
        """

    def light(self, prim: Prim) -> Light:
        """Intensity and colour of a light prim."""

    def set_light(self, prim: Prim, light: Light) -> None:
        """Let a light shine otherwise in the pictures to come; `reset_state` takes it back.

        Args:
            prim: of the light.
            light: intensity and colour; finite, not negative.
        """

    def body(self, prim: Prim) -> Body:
        """The rigid body at, or carrying, a prim."""

    def frame(self, prim: Prim) -> Frame:
        """The pose of a prim."""

    def mass(self, prim: Prim) -> float:
        """Mass of the body that a prim has of its own, kg."""

    def placement(self, prim: Prim) -> Placement | None:
        """What puts a prim's body somewhere and holds it there; None where nothing can move it, or only with another body."""

    def articulation(self, robot: Prim) -> Articulation:
        """The joints of a robot prim."""

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """The device at a prim of its kind; always the same for the same options.

        Args:
            interface: its Protocol.
            prim: of the device.
            options: as the kind takes them: a camera has `size`, width and height of its pictures in pixels.
        """

    @property
    def rays_in_use(self) -> str:
        """Name of the rays that lidars cast; empty while nobody has asked for a lidar."""

    def picture_driver(self) -> str:
        """Name and version of what draws the pictures of cameras."""

    @property
    def entities(self) -> Entities:
        """Its robots and objects as wholes."""

    def step(self) -> None:
        """Apply the joints' targets and integrate one substep; afterwards every handle reads the new state.

        Raises:
            PhysicsError: the state is not finite any more.
        """

    def begin_tick(self, tick: int) -> None:
        """Tell the sensors, after the tick's last substep, that tick n is at time n times the tick period."""

    def zero_commands(self) -> None:
        """Set every joint's target velocity and effort to zero."""

    def reset_state(self) -> None:
        """Put bodies, joints and commands back to what they were at the start, and let go of forces; ticks count on."""

    def reset_time(self) -> None:
        """Count ticks from 0 again, and sensors' samples with them; bodies and joints stay where they are."""

    def save(self) -> Any:
        """A copy of the state, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, while the same robots were there; what follows is the same, bit by bit."""

    def close(self) -> None:
        """Release what the world holds; safe to call twice."""


def select_joints(articulation: Articulation, names: Sequence[str], indices: Sequence[int]) -> list[int]:
    """Positions of the joints that a selection means: by name, else by index, else all.

    Raises:
        JointError: a name or index that the articulation does not have.
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
