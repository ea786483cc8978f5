"""The node that sets feed-forward efforts of a robot's drives (`isaacsim.core.experimental.actuators`)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.motion import Articulation, JointSelection
from graphengine.format.errors import JointError
from graphengine.node import BadValueError, Bound, Context, ExecIn, In, Node
from graphengine.node.types import Floats, Ints, String
from graphengine.nodes.touched import drives_of


class ArticulationActuators(Node, type="isaacsim.core.experimental.actuators.ArticulationActuators"):
    """Sets feed-forward efforts. They are added to the efforts of the joints' drives.

    Isaac Sim's actuators correspond to the drives of the robot file: a drive with `stiffness` and `damping` to a PD actuator,
    and its `max_force` to the effort limit of the actuator. A feed-forward effort acts from the next physics step until it is
    set again or replaced by the `effortCommand` of an IsaacArticulationController. As in Isaac Sim, a feed-forward effort has no
    effect on a joint without a drive.

    Drives act in every physics step. In Isaac Sim, if `autoStepPrePhysics` is false, drives act only when the node is executed.
    The joint's effort limit bounds the feed-forward effort, and `max_force` bounds the effort of the drive; Isaac Sim limits the
    sum of the two efforts. Isaac Sim's PID and neural controllers, delays and motor curves are not available. `stepDt` has no
    effect, because only PID and neural controllers use it.
    """

    exec_in = ExecIn()
    robot_path: String = In(default="", required=True, setup=True, doc="path of the robot's prim, base link or root")
    auto_step_pre_physics: bool = In(default=True, doc="no effect: drives act in every physics step")
    step_dt: float = In(default=0.016667, unit="s", doc="no effect: drives do not integrate errors")
    feedforward_command: Floats = In(
        unit="N m, N", doc="feed-forward efforts: one per selected joint, or one for all; if empty, efforts stay"
    )
    indices: Ints = In(ge=0, le=0, doc="index of the robot: empty or [0], because `robotPath` selects a single robot")
    dof_indices: Ints = In(ge=0, doc="indices of the joints whose efforts are set; if empty, all joints")

    articulation: Articulation = Bound()
    has_drive: NDArray[np.bool_] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot at `robotPath` and its joints with drives; warn of inputs that have no effect."""
        self.articulation = context.articulation(self.robot_path)
        positions, velocities = self.articulation.set_points()
        self.has_drive = ~(np.isnan(positions) & np.isnan(velocities))
        if not self.auto_step_pre_physics:
            context.log("warning", "autoStepPrePhysics: false has no effect, as drives act in every physics step")
        if not self.has_drive.any():
            context.log("warning", f"{self.robot_path} has no joint with a drive: feedforwardCommand has no effect")

    def compute(self) -> None:
        """Set the feed-forward efforts of the selected joints that have a drive. On an error, no effort changes.

        Raises:
            BadValueError: `indices` contains an index other than 0, an index in `dofIndices` is out of range, the number of
                efforts is neither 1 nor the number of selected joints, or an effort is infinite or too large.
        """
        efforts = self.feedforward_command.tolist()
        if not efforts:
            return
        if set(self.indices.tolist()) - {0}:
            raise BadValueError("indices", self.indices, "empty or [0], because robotPath selects a single robot")
        selection = self.select()
        joints = len(selection.names)
        if len(efforts) not in (1, joints):
            legal = f"one effort, or one for each of {joints} joints of {self.articulation.prim_path}"
            raise BadValueError("feedforwardCommand, dofIndices", efforts, legal)
        driven = self.has_drive[self.dof_indices] if len(self.dof_indices) else self.has_drive
        try:
            selection.command(efforts=np.where(driven, efforts, np.nan).tolist())
        except BadValueError as error:
            raise BadValueError("feedforwardCommand", efforts) from error

    def select(self) -> JointSelection:
        """Return the joints that `dofIndices` selects; all joints if it is empty.

        Raises:
            BadValueError: an index in `dofIndices` is out of range.
        """
        try:
            return self.articulation.select((), self.dof_indices.tolist())
        except JointError as error:
            raise BadValueError("dofIndices", self.dof_indices) from error

    def writes(self) -> Iterable[str]:
        """Return the resource key of the robot's drive targets."""
        return (drives_of(self.robot_path),) if self.robot_path else ()
