"""The command that sets targets of a robot's joints."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from pydantic import model_validator

from graphengine.devices.backend import follower_warnings
from graphengine.devices.motion import Articulation, CommandKind
from graphengine.format.errors import BadValueError, JointError, UsageError
from graphengine.runtime.command import ChangeCommand, EntityName, JointNumbers, find_robot
from graphengine.runtime.session_core import SessionCore

_REMEDIES: Mapping[CommandKind, str] = {
    "position": "give these joints a drive with stiffness below `joints:` of the robot file, or command efforts",
    "velocity": "give these joints a drive with damping below `joints:` of the robot file, or command efforts",
    "effort": "command the joints that the actuators move",
}


class JointCommand(ChangeCommand):
    """Set targets of joints; a target acts from the physics steps of the next tick until the next command to the joint.

    These steps run before the graphs of the tick; a graph that commands the same joint in the tick replaces the target. Targets
    beyond the limits of a joint are clamped and counted, as in IsaacArticulationController. After an error, no target has
    changed.
    """

    robot: EntityName
    positions: JointNumbers | None = None
    """Position targets by joint name, rad or m; a joint needs a drive with stiffness."""
    velocities: JointNumbers | None = None
    """Velocity targets by joint name, rad/s or m/s; a joint needs a drive with damping."""
    efforts: JointNumbers | None = None
    """Torques or forces by joint name, N m or N, in addition to those of the drives."""

    @classmethod
    def command_name(cls) -> str:
        """Return `command`, the name of the method of robots in the Python API."""
        return "command"

    @model_validator(mode="after")
    def _something(self) -> JointCommand:
        if all(targets is None for targets in (self.positions, self.velocities, self.efforts)):
            raise ValueError("give positions, velocities or efforts")
        return self

    def _apply(self, session: SessionCore) -> None:
        robot = find_robot(session, self.robot)
        try:
            self._command(session, session.services.world.articulation(robot))
        except (JointError, BadValueError) as error:
            raise UsageError(str(error).replace("\n", "\n  ")) from error
        self._record(session, **self.model_dump())

    def _command(self, session: SessionCore, robot: Articulation) -> None:
        kinds: dict[CommandKind, JointNumbers] = {
            "position": self.positions or {},
            "velocity": self.velocities or {},
            "effort": self.efforts or {},
        }
        for kind, targets in kinds.items():
            undriven = robot.select(list(targets)).undriven(kind) if targets else ()
            if undriven:
                text = f"{robot.prim_path} has joints without a drive for {kind} targets: {', '.join(undriven)}"
                raise UsageError("\n  ".join([text, *(follower_warnings(robot, undriven) or [_REMEDIES[kind]])]))
        names = list(dict.fromkeys(itertools.chain.from_iterable(kinds.values())))
        if not names:
            return
        for warning in follower_warnings(robot, robot.select(names).names):
            session.services.log("warning", "", warning)
        rows = ([targets.get(name, math.nan) for name in names] for targets in kinds.values())
        robot.select(names).command(*rows)
