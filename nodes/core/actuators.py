"""Feed-forward efforts of a robot's drives (`isaacsim.core.experimental.actuators`)."""

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
    """Sets feed-forward efforts, which are added to the efforts of the joints' drives.

    The actuators are the drives in the robot file: a drive with `stiffness` and `damping` corresponds to Isaac Sim's PD
    actuator, and `max_force` to its effort limit. A feed-forward effort acts from the next physics step until it is set again
    or replaced by the `effortCommand` of an IsaacArticulationController. Joints without a drive ignore it, as in Isaac Sim.

    Drives act in every physics step, also if `autoStepPrePhysics` is false; in Isaac Sim, they then act only when the node is
    executed. `stepDt` has no effect, because PID and neural controllers, which use it in Isaac Sim, are not available; nor are
    delays and motor curves. The joint's effort limit applies to the feed-forward effort alone and `max_force` to the drive
    alone; Isaac Sim limits their sum.
    """

    exec_in = ExecIn()
    robot_path: String = In(
        default="", required=True, setup=True, doc="path of the robot's prim, base link or articulation root"
    )
    auto_step_pre_physics: bool = In(default=True, doc="no effect: drives act in every physics step")
    step_dt: float = In(default=0.016667, unit="s", doc="no effect: drives do not integrate errors")
    feedforward_command: Floats = In(
        unit="N m, N", doc="feed-forward effort of each selected joint, or one for all; empty: keep the present efforts"
    )
    indices: Ints = In(doc="must be empty or 0, as `robotPath` is a single robot")
    dof_indices: Ints = In(doc="indices of the joints to set; if empty, all")

    articulation: Articulation = Bound()
    has_drive: NDArray[np.bool_] = Bound()

    def setup(self, context: Context) -> None:
        """Bind the robot and find the joints with drives."""
        self.articulation = context.articulation(self.robot_path)
        positions, velocities = self.articulation.set_points()
        self.has_drive = ~(np.isnan(positions) & np.isnan(velocities))
        if not self.auto_step_pre_physics:
            context.log("warning", "autoStepPrePhysics: false has no effect, as drives act in every physics step")
        if not self.has_drive.any():
            context.log("warning", f"{self.robot_path} has no joint with a drive: feedforwardCommand has no effect")

    def compute(self) -> None:
        """Set the efforts, or none on an error.

        Raises:
            BadValueError: no robot or joint has an index, the numbers of efforts and joints differ, or an effort is too large.
        """
        efforts = self.feedforward_command.tolist()
        if not efforts:
            return
        if set(self.indices.tolist()) - {0}:
            raise BadValueError("indices", self.indices, "0, as robotPath is one robot")
        selection = self.select()
        joints = len(selection.names)
        if len(efforts) not in (1, joints):
            legal = f"one, or one for each of {joints} joints of {self.articulation.prim_path}"
            raise BadValueError("feedforwardCommand, dofIndices", efforts, legal)
        driven = self.has_drive[self.dof_indices] if len(self.dof_indices) else self.has_drive
        try:
            selection.command(efforts=np.where(driven, efforts, np.nan).tolist())
        except BadValueError as error:
            raise BadValueError("feedforwardCommand", efforts) from error

    def select(self) -> JointSelection:
        """Return the joints that `dofIndices` selects.

        Raises:
            BadValueError: no joint has an index.
        """
        try:
            return self.articulation.select((), self.dof_indices.tolist())
        except JointError as error:
            raise BadValueError("dofIndices", self.dof_indices) from error

    def writes(self) -> Iterable[str]:
        """Return the resource keys of the robot's drive targets."""
        return (drives_of(self.robot_path),) if self.robot_path else ()
