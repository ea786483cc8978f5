"""Reads mobile bases from the parameters of ros2_control controllers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from graphengine.bringup.robots.base import Base, flaw, given
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.robot_files.draft import Draft, Remark

_WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def base_of_controllers(draft: Draft, controllers: Iterable[Controller]) -> Base | None:
    """Return the base of the first controller that drives a base; None if no controller does.

    Bases that cannot be used, and bases after the first one, are added to `draft.lost`.
    """
    chosen: Base | None = None
    for controller in controllers:
        reader = _READERS.get(controller.kind)
        if reader is None:
            continue
        read = reader(controller)
        parameters = _topics(controller) | read.parameters
        base = replace(read, source=controller.title, span=controller.span, parameters=parameters)
        if reason := f"{chosen.source} drives the base" if chosen is not None else flaw(draft, base):
            draft.lost.append(Remark(f"{base.source}: {reason}", base.span))
            continue
        chosen = base
        if not controller.flag("enable_odom_tf", default=True):
            text = f"{base.source}: enable_odom_tf is false, but the graph publishes the transform odom -> base"
            draft.lost.append(Remark(text, base.span))
    return chosen


def _differential(controller: Controller) -> Base:
    left = controller.texts("left_wheel_names") or controller.texts("left_wheel")
    right = controller.texts("right_wheel_names") or controller.texts("right_wheel")
    return Base(
        "differential",
        (*left, *right),
        radius=_product(controller.positive("wheel_radius"), controller.positive("left_wheel_radius_multiplier")),
        track=controller.positive("wheel_separation"),
        multiplier=controller.positive("wheel_separation_multiplier") or 1.0,
        parameters=given(
            speed=_limit(controller, "linear.x", "velocity"),
            turn=_limit(controller, "angular.z", "velocity"),
            acceleration=_limit(controller, "linear.x", "acceleration"),
            deceleration=_limit(controller, "linear.x", "deceleration")
            or _limit(controller, "linear.x", "acceleration"),
            turn_acceleration=_limit(controller, "angular.z", "acceleration"),
        ),
    )


def _mecanum(controller: Controller) -> Base:
    names = [f"{wheel}_wheel_{kind}" for kind in ("command_joint_name", "name", "joint") for wheel in _WHEELS]
    return Base(
        "mecanum",
        tuple(dict.fromkeys(controller.texts(*names) or controller.texts("command_joint_names", "wheel_names"))),
        radius=_product(
            controller.positive("kinematics.wheels_radius", "wheel_radius", "wheels_radius"),
            controller.positive("wheel_radius_multiplier"),
        ),
        parameters=given(
            speed=_limit(controller, "linear.x", "velocity"),
            turn=_limit(controller, "angular.z", "velocity"),
            acceleration=_limit(controller, "linear.x", "acceleration"),
        ),
    )


def _omni(controller: Controller) -> Base:
    return Base("omni", controller.texts("wheel_names"), radius=controller.positive("wheel_radius"))


def _steering(controller: Controller) -> Base:
    front = controller.texts("front_wheels_names")
    rear = controller.texts("rear_wheels_names")
    if not controller.flag("front_steering", default=True):
        front, rear = rear, front
    return Base(
        "ackermann",
        controller.texts("traction_joints_names") or rear,
        controller.texts("steering_joints_names") or front,
        radius=controller.positive("traction_wheels_radius", "rear_wheels_radius"),
        track=controller.positive("traction_track_width", "rear_wheel_track", "wheel_track"),
        wheelbase=controller.positive("wheelbase"),
        parameters=given(timeout=controller.positive("reference_timeout")),
    )


def _tricycle(controller: Controller) -> Base:
    timeout = controller.positive("cmd_vel_timeout")
    return Base(
        "ackermann",
        controller.texts("traction_joint_name"),
        controller.texts("steering_joint_name"),
        radius=controller.positive("wheel_radius"),
        wheelbase=controller.positive("wheelbase"),
        parameters=given(
            timeout=timeout / 1000.0 if timeout is not None else None,  # this controller has it in ms
            steering_limit=controller.positive("steering.max_position"),
            steering_speed=controller.positive("steering.max_velocity"),
            wheel_speed=controller.positive("traction.max_velocity"),
        ),
    )


_READERS: dict[str, Callable[[Controller], Base]] = {
    "DiffDriveController": _differential,
    "MecanumDriveController": _mecanum,
    "OmniWheelDriveController": _omni,
    "AckermannSteeringController": _steering,
    "BicycleSteeringController": _steering,
    "TricycleSteeringController": _steering,
    "TricycleController": _tricycle,
}
"""Function that reads the base of a controller, by the last part of the controller's type."""


def _topics(controller: Controller) -> dict[str, float | str]:
    """Return the odometry frame and command timeout of a controller, as parameters of the graph."""
    frames = controller.texts("odom_frame_id")
    return given(odom_frame=frames[0] if frames else None, timeout=controller.positive("cmd_vel_timeout"))


def _limit(controller: Controller, axis: str, what: str) -> float | None:
    """Return the absolute value of a limit; None if it is missing, zero or disabled.

    Args:
        controller: controller that has the limit.
        axis: prefix of the parameter, such as `linear.x`.
        what: `velocity`, `acceleration` or `deceleration`.
    """
    switch = "acceleration" if what == "deceleration" else what
    if not controller.flag(f"{axis}.has_{switch}_limits", default=True):
        return None
    number = controller.number(f"{axis}.max_{what}")
    return abs(number) or None if number is not None else None


def _product(value: float | None, factor: float | None) -> float | None:
    return value * (factor or 1.0) if value is not None else None
