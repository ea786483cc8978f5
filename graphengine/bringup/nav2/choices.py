"""The choices of a user for the Nav2 files of a scene: distribution, controller, tolerances, and machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from graphengine.bringup.nav2.motion_limits import MotionLimits
from graphengine.bringup.nav2.sourced import Sourced
from graphengine.format.errors import UsageError
from graphengine.messages.distros import JAZZY, Distro

Controller = Literal["dwb", "mppi", "rpp"]
CONTROLLERS: tuple[Controller, ...] = get_args(Controller)

REACHED, FACING, COARSE = 0.15, 0.1, 0.2
"""Distance (m) from a goal within which the robot has reached it, and angle (rad) with DWB and with the other controllers."""


@dataclass(frozen=True, slots=True)
class Choices:
    """Options for Nav2's files, with the defaults of `graphrun nav2 files`.

    Attributes:
        distribution: the ROS 2 distribution.
        busy: whether timeouts and rates tolerate a machine on which the simulation and Nav2 compete for the processor.
        controller: Nav2's controller; None chooses DWB, or regulated pure pursuit for a car.
        xy_tolerance: maximum distance from a reached goal, m; None chooses the default.
        yaw_tolerance: maximum angle from a reached goal, rad; None chooses the default of the controller.
    """

    distribution: Distro = JAZZY
    busy: bool = False
    controller: Controller | None = None
    xy_tolerance: float | None = None
    yaw_tolerance: float | None = None

    @property
    def frequency(self) -> float:
        """Rate at which the controller sends velocity commands, Hz."""
        return 10.0 if self.busy else 20.0

    def controller_for(self, limits: MotionLimits) -> Controller:
        """Return the controller for a robot.

        Raises:
            UsageError: the chosen controller cannot steer a car.
        """
        if limits.car and self.controller == "dwb":
            raise UsageError("--controller dwb: DWB turns on the spot, which a car cannot do; choose mppi or rpp")
        return self.controller or ("rpp" if limits.car else "dwb")

    def reached(self) -> Sourced[float]:
        """Return the maximum distance from a reached goal, m."""
        if self.xy_tolerance is not None:
            return Sourced(self.xy_tolerance, "--xy-tolerance")
        return Sourced(REACHED, "smaller than 0.25 in Nav2's parameter file, because the localization error adds to it")

    def facing(self, limits: MotionLimits) -> Sourced[float]:
        """Return the maximum angle from a reached goal, rad."""
        if self.yaw_tolerance is not None:
            return Sourced(self.yaw_tolerance, "--yaw-tolerance")
        if self.controller_for(limits) == "dwb":
            return Sourced(FACING, "DWB stops its turn at the goal within this angle; --yaw-tolerance changes it")
        return Sourced(COARSE, "smaller than 0.25 in Nav2's parameter file; --yaw-tolerance changes it")
