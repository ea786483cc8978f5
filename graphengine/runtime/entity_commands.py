"""The commands that add, remove, place and push robots and objects, and the command `clearance`."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from graphengine.devices import entity as entities
from graphengine.devices.rotation import Pose, Vector3, from_orientation
from graphengine.devices.stage import Prim
from graphengine.format.errors import UsageError
from graphengine.format.spec import Orientation, Positive, RobotUse, Vector
from graphengine.format.wording import unknown
from graphengine.runtime.command import ChangeCommand, Command, EntityName, JointNumbers, find_robot
from graphengine.runtime.session_core import SessionCore


class _Placing(ChangeCommand):
    """Base class of the commands that place an entity; refused if the entity would overlap another one, except a floor."""

    force: bool = False
    """Whether to place the entity even if it overlaps others; physics then pushes them apart."""

    def _forced(self, session: SessionCore) -> bool:
        return self.force or session.inbox.replays  # recordings contain only commands that succeeded


class Spawn(_Placing):
    """Add a robot to the scene; `use` has the same keys as an entry of `robots` in a scene file."""

    name: EntityName
    use: RobotUse

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        session.roster.add(self.name, self.use, forced=self._forced(session))
        self._record(session, name=self.name, use=self.use.model_dump(mode="json"))
        return _overlaps(session, self.name)


class Delete(ChangeCommand):
    """Remove a robot, its graphs and its topics."""

    name: EntityName

    def _apply(self, session: SessionCore) -> None:
        session.roster.remove(self.name)
        self._record(session, name=self.name)


class Move(_Placing):
    """Move a robot or an object of the world. Joints keep their state; the velocity becomes 0 unless one is given."""

    entity: EntityName
    position: Annotated[tuple[float, ...], Field(strict=False)] | None = None
    """Position of the robot's base link, or of the object, in the world, m: [x, y, z], or [x, y] to keep the height."""
    orientation: Orientation | None = None
    linear: Vector | None = None
    """Linear velocity along the axes of the world, m/s."""
    angular: Vector | None = None
    """Angular velocity about the axes of the world, rad/s."""
    odometry: Literal["continues", "jumps"] | None = None
    """Whether ground-truth odometry continues from the pose before the move (REP 105), or jumps with the entity.

    None means `continues`; in recordings of older versions, which lack this argument, None means `jumps`.
    """

    @model_validator(mode="after")
    def _something(self) -> Move:
        given = (self.position, self.orientation, self.linear, self.angular)
        if not any(value is not None for value in given):
            raise ValueError("give a position, an orientation, or a velocity")
        if self.position is not None and len(self.position) not in (2, 3):
            raise ValueError(f"a position is [x, y] or [x, y, z], not {len(self.position)} numbers")
        return self

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        position, turned = self._place(session), self.orientation
        # A given quaternion is used unchanged to the last bit, so that a replay does the same.
        orientation = (turned.quaternion_xyzw or from_orientation(turned)) if turned is not None else None
        to, world = entities.Move(position, orientation, self.linear, self.angular), session.services.world
        odometry = self.odometry or ("jumps" if session.inbox.replays else "continues")
        prim = next((entity.prim_path for entity in world.entities.all() if entity.name == self.entity), "")
        with _moving(session, prim if odometry == "continues" else ""):
            world.entities.place(self.entity, to, forced=self._forced(session))
        turn = {"quaternion_xyzw": orientation} if orientation is not None else None
        where = {"position": position, "orientation": turn, "linear": self.linear, "angular": self.angular}
        self._record(session, entity=self.entity, odometry=odometry, **where)
        return _overlaps(session, self.entity)

    def _place(self, session: SessionCore) -> Vector3 | None:
        if self.position is None:
            return None
        x, y, *height = self.position
        return x, y, height[0] if height else session.services.world.entities.state(self.entity).position[2]


class ResetRobot(_Placing):
    """Return one robot to its initial pose, joint positions and commands, with zero velocities; time and graphs continue.

    The robot's sensors are reset, forces on the robot end, and its grippers release their objects.
    """

    robot: EntityName
    position: Vector | None = None
    """Position of the robot's base link in the world, m; default: the initial position."""
    orientation: Orientation | None = None
    joints: JointNumbers = Field(default_factory=dict)
    """Positions by joint name, rad or m; drives hold these joints there. Other joints return to their initial positions."""
    keyframe: EntityName | None = None
    """Keyframe of the robot's MuJoCo model, instead of the initial state."""

    @classmethod
    def command_name(cls) -> str:
        """Return `reset-robot`."""
        return "reset-robot"

    def _apply(self, session: SessionCore) -> dict[str, Any]:
        prim = find_robot(session, self.robot)
        self._check(prim)
        turned = self.orientation
        orientation = (turned.quaternion_xyzw or from_orientation(turned)) if turned is not None else None
        to, reset = entities.Move(self.position, orientation), session.services.world.entities.reset
        with _moving(session, prim.path):
            reset(self.robot, to, self.joints, self.keyframe, forced=self._forced(session))
        where = {"position": self.position, "orientation": {"quaternion_xyzw": orientation} if orientation else None}
        self._record(session, robot=self.robot, joints=self.joints, keyframe=self.keyframe, **where)
        return _overlaps(session, self.robot)

    def _check(self, robot: Prim) -> None:
        facts = robot.facts
        joints = dict(zip(facts["joints"], zip(facts["leaders"], facts["ranges"], strict=True), strict=True))
        if self.keyframe is not None and self.keyframe not in facts["keyframes"]:
            raise UsageError(unknown("keyframe", self.keyframe, facts["keyframes"]))
        for name, position in self.joints.items():
            if name not in joints:
                raise UsageError(unknown("joint", name, joints))
            leader, (lowest, highest) = joints[name]
            if leader:
                raise UsageError(f"joint {name!r} follows {leader!r}\n  give a position for {leader} instead")
            if not lowest <= position <= highest:
                text = f"joint {name!r} cannot be at {position:g}, which is outside of its limits"
                raise UsageError(f"{text}\n  legal: {lowest:g} to {highest:g}")


@contextmanager
def _moving(session: SessionCore, entity: str) -> Iterator[None]:
    """Return a context that moves an entity: the session then counts as disturbed, and ground-truth odometry continues.

    Args:
        session: the session.
        entity: prim path of the entity; empty if odometry jumps with the entity.
    """
    frame = session.services.world.frame(session.services.stage.find(entity)) if entity else None
    before = frame.pose() if frame is not None else None
    yield
    session.services.disturbed = True
    if frame is not None and before is not None:
        _carry(session, entity, before, frame.pose())


def _carry(session: SessionCore, entity: str, before: Pose, after: Pose) -> None:
    """Call the method `carry` of all nodes that have it: the entity at a prim path was moved between two poses in the world."""
    for node in itertools.chain.from_iterable(run.executor.nodes for run in session.graphs):
        if (carry := getattr(node, "carry", None)) is not None:
            carry(entity, before, after)


def _overlaps(session: SessionCore, name: str) -> dict[str, Any]:
    """Return the result of a command that placed an entity: `warnings`, with a text if the entity overlaps others, and log it."""
    text = entities.warning(name, session.services.world.entities.overlaps(name))
    if text:
        session.services.log("warning", "", text)
    return {"warnings": [text] if text else []}


class Push(ChangeCommand):
    """Apply a force or an impulse to a robot or an object from the next physics step on; an impulse acts evenly over time."""

    entity: EntityName
    force: Vector | None = None
    """Force along the axes of the world, N."""
    impulse: Vector | None = None
    """Impulse along the axes of the world, N s."""
    duration: Positive | None = None
    """Simulation time over which the force or impulse acts, s; required for a force; default for an impulse: one tick."""
    at: Vector | None = None
    """Point in the world at which the force or impulse acts, m; default: the centre of mass."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Push:
        if (self.force is None) == (self.impulse is None):
            raise ValueError("give either a force (N) or an impulse (N s)")
        if self.force is not None and self.duration is None:
            raise ValueError("a force needs a duration (s)")
        return self

    def _apply(self, session: SessionCore) -> None:
        duration = self.duration or session.clock.delta
        x, y, z = self.force or self.impulse or (0.0, 0.0, 0.0)
        force = (x, y, z) if self.force is not None else (x / duration, y / duration, z / duration)
        session.services.world.entities.push(self.entity, force, duration, self.at)
        session.services.disturbed = True
        self._record(session, entity=self.entity, force=force, duration=duration, at=self.at)


class Clearance(Command):
    """Return `near`: the name of each obstacle close to an entity at another position, in any orientation, with its distance (m).

    The state of the simulation does not change. Obstacles up to 5 cm high, over which the entity can drive, are left out.
    """

    entity: EntityName
    position: Annotated[tuple[float, float], Field(strict=False)]
    """Position of the entity's prim in the world frame, x and y, m; its height stays."""
    margin: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """Largest distance of a reported obstacle, m."""

    def _apply(self, session: SessionCore) -> dict[str, dict[str, float]]:
        return {"near": dict(session.services.world.entities.clearance(self.entity, self.position, self.margin))}
