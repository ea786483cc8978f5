"""A surface gripper. It holds bodies by welds at its grip points.

While the gripper closes, it casts a ray from each point along its forward axis. If the ray hits a body, the body is welded to the
gripper at its current pose. A weld breaks if its force exceeds a limit of the gripper. A new weld needs ten steps to settle; its
force is ignored during these steps.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import vector
from graphengine.devices.stage import Prim
from graphengine.devices.surface_gripper import GripperStatus, SurfaceGripperDevice
from graphengine.format.spec import NotNegative, Positive
from graphengine.physics.dynamics.welds import add_weld
from graphengine.physics.handles.motion_handles import CarriedPrim
from graphengine.physics.implementations import Offsets, Profile, check_less, implements
from graphengine.physics.ray_casting.own_colliders import OwnColliders

_SETTLING = 10
"""Number of physics steps for which the force of a new weld is ignored; also the pause of a point after its weld breaks."""
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


class SurfaceGripperProfile(Profile):
    """The parameters of a surface gripper, such as suction cups or magnets."""

    points: Annotated[tuple[Offsets, ...], Field(strict=False, min_length=1, max_length=100)] = ((0.0, 0.0, 0.0),)
    """Positions of the grip points in the gripper's frame, m; each point holds one body."""
    forward_axis: Literal["X", "Y", "Z"] = "X"
    """Axis of the gripper's frame along which the gripper grips."""
    max_grip_distance: Positive = Field(default=0.01, le=10.0)
    """Largest distance from a point at which the gripper grips a body, m."""
    clearance_offset: NotNegative = 0.0
    """Distance in front of a point at which its ray starts, m; less than max_grip_distance."""
    coaxial_force_limit: Positive | None = None
    """Pulling force along the forward axis above which a point releases its body, N; default: no limit."""
    shear_force_limit: Positive | None = None
    """Force across the forward axis above which a point releases its body, N; default: no limit."""
    retry_interval: NotNegative = 0.0
    """Time for which a closing gripper tries to grip, s; with 0, it tries once."""

    @model_validator(mode="after")
    def _reaches(self) -> SurfaceGripperProfile:
        check_less(clearance_offset=self.clearance_offset, max_grip_distance=self.max_grip_distance)
        return self


def _weld_names(prim: Prim) -> list[str]:
    """Return the names of a gripper's welds in the model of its robot, one per point."""
    robot = next(above for above in prim.ancestors() if above.kind == "robot")
    below = prim.path.removeprefix(f"{robot.path}/").replace("/", ".")
    return [f"{below}.point{number}" for number in range(len(prim.facts["points"]))]


def add_gripper_welds(spec: mujoco.MjSpec, body: str, prim: Prim) -> None:
    """Add the welds of a gripper to the model of its robot.

    Args:
        spec: model of the robot.
        body: name of the body that carries the gripper.
        prim: prim of the gripper.
    """
    for name in _weld_names(prim):
        add_weld(spec, name, body)


@implements(SurfaceGripperDevice, SurfaceGripperProfile, build=add_gripper_welds)
class SuctionGripper(CarriedPrim):
    """The surface gripper at a prim, whose `facts` contain the parameters of the gripper's profile."""

    sees_steps = casts_rays = True
    kept = ("status", "_trying", "_tried", "_waiting")

    def _set_up(self) -> None:
        robot = next(above for above in self._prim.ancestors() if above.kind == "robot")
        self._welds = [f"{robot.entity_name}/{name}" for name in _weld_names(self._prim)]
        self._forward = np.array(_AXES[self._prim.facts["forward_axis"]])
        self.reset()

    def bind(self) -> None:
        """Look up the body that carries the gripper, and create the caster of its rays."""
        super().bind()
        simulation, facts = self._simulation, self._prim.facts
        self._reach: float = facts["max_grip_distance"] - facts["clearance_offset"]
        model = simulation.model
        own = OwnColliders(model, simulation.data, int(model.body_rootid[self.body]))
        self._caster = simulation.rays.caster(self._forward[None], self._reach, own)

    def reset(self) -> None:
        """Set the status to open; the simulation itself releases the welds."""
        self.status: GripperStatus = "Open"
        self._trying, self._tried = False, 0.0
        self._waiting = [0] * len(self._welds)

    @property
    def gripped(self) -> list[str]:
        """Paths of the prims whose bodies the gripper holds."""
        held = self._simulation.welds.held
        bodies = dict.fromkeys(held[weld][0] for weld in self._welds if weld in held)
        paths = {prim.body: prim.path for prim in self._simulation.stage.prims() if prim.body in bodies}
        return [paths[body] for body in bodies if body in paths]

    def close(self) -> None:
        """Start to close, unless the gripper is closing or closed already."""
        if self.status == "Open":
            self.status, self._trying, self._tried = "Closing", True, 0.0

    def open(self) -> None:
        """Release all bodies immediately."""
        simulation = self._simulation
        holding = [weld for weld in self._welds if weld in simulation.welds.held]
        self.status, self._trying = "Open", False
        for weld in holding:
            simulation.welds.release(weld)
        if holding:
            simulation.wake_all()  # a sleeping body would not fall

    def see_forces(self) -> None:
        """Grip bodies while closing, and release bodies whose force exceeds a limit; called in each physics step."""
        self._waiting = [max(steps - 1, 0) for steps in self._waiting]
        if self.status == "Open":
            return
        holds = [weld in self._simulation.welds.held for weld in self._welds]
        if self.status == "Closing":
            for number in range(len(holds)):
                if not holds[number] and not self._waiting[number]:
                    holds[number] = self._grip(number)
        for number in range(len(holds)):
            if holds[number] and not self._waiting[number] and self._is_pulled_off(number):
                self._simulation.welds.release(self._welds[number])
                self._waiting[number], holds[number] = _SETTLING, False
        self._update(holds)

    def _update(self, holds: list[bool]) -> None:
        """Update the status after a step; `holds` says whether each point holds a body."""
        retry: float = self._prim.facts["retry_interval"]
        if self.status == "Closing" and self._trying:
            self._tried += self._simulation.model.opt.timestep
            self._trying = self._tried < retry
        if all(holds):
            self.status, self._tried = "Closed", 0.0
        elif self._trying:
            self.status = "Closing"
        elif not any(holds):
            self.status = "Open"

    def _grip(self, number: int) -> bool:
        """Cast a ray forward from a gripping point, and weld the body that it hits to the gripper.

        Args:
            number: index of the point.

        Returns:
            Whether the ray hit a body within reach.
        """
        facts, (position, rotation) = self._prim.facts, self.frame()
        forward = rotation @ self._forward
        begin = position + rotation @ facts["points"][number] + facts["clearance_offset"] * forward
        (distance,), (geom,) = self._caster.cast(begin, rotation)
        if not 0.0 <= distance <= self._reach:
            return False
        body = int(self._simulation.model.geom_bodyid[geom])
        self._simulation.welds.hold(self._welds[number], body, vector(begin + distance * forward))
        self._waiting[number] = _SETTLING
        return True

    def _is_pulled_off(self, number: int) -> bool:
        """Return whether the force on the weld of a point exceeds a limit of the gripper."""
        facts, forward = self._prim.facts, self.frame()[1] @ self._forward
        force = self._simulation.welds.force(self._welds[number])
        pull = float(force @ forward)
        shear = float(np.linalg.norm(force - pull * forward))
        coaxial_limit, shear_limit = facts["coaxial_force_limit"], facts["shear_force_limit"]
        return bool((coaxial_limit and pull > coaxial_limit) or (shear_limit and shear > shear_limit))
