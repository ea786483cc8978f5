"""The joints of a robot (`isaacsim.core.nodes`)."""

from __future__ import annotations

from graphengine.context import Articulation, Context, JointSelection
from graphengine.node import ExecIn, In, Node, State
from graphengine.types import (
    Doubles,
    Ints,
    String,
    Target,
    Tokens,
)


class IsaacArticulationController(Node, type="isaacsim.core.nodes.IsaacArticulationController"):
    """Joint targets from arrays; they act from the next physics step on, and hold until the next command."""

    exec_in = ExecIn()
    target_prim: Target = In(required="robot", setup=True, doc="prim that stands for the robot")
    robot_path: String = In(default="", required="robot", setup=True, doc="the same as text; wins over targetPrim")
    joint_names: Tokens = In(doc="joints that the arrays are for; empty for all, or by index")
    joint_indices: Ints = In(doc="joints by number, where no names are given")
    position_command: Doubles = In(unit="rad, m", doc="one a joint; NaN leaves a joint alone")
    velocity_command: Doubles = In(unit="rad/s, m/s", doc="one a joint; NaN leaves a joint alone")
    effort_command: Doubles = In(unit="N m, N", doc="one a joint; NaN leaves a joint alone")

    articulation: Articulation = State()
    selection: JointSelection | None = State(default=None)
    selected: tuple[object, object] = State(default=((), ()))

    def setup(self, context: Context) -> None:
        """Bind the robot, and the joints that are known by now."""
        self.articulation = context.articulation(self.robot_path or self.target_prim[0])
        self.select()

    def select(self) -> JointSelection:
        """Bind the joints."""
        self.selected = (self.joint_names, self.joint_indices)
        self.selection = self.articulation.select(self.joint_names, self.joint_indices.tolist())
        return self.selection

    def compute(self) -> None:
        """Apply the commands, all or none."""
        selection = self.selection
        if selection is None or self.selected[0] is not self.joint_names or self.selected[1] is not self.joint_indices:
            selection = self.select()
        position, velocity, effort = self.position_command, self.velocity_command, self.effort_command
        joints = len(selection.names)
        for name, command in (("positionCommand", position), ("velocityCommand", velocity), ("effortCommand", effort)):
            if len(command) not in (0, joints):
                path = self.articulation.prim_path
                raise ValueError(f"{name} has {len(command)} values for {joints} joints of {path}; nothing was applied")
        selection.command(position.tolist() or None, velocity.tolist() or None, effort.tolist() or None)
