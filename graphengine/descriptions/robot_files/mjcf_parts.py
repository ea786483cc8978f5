"""Adds entries for actuators, cameras and IMUs of a MuJoCo model to a robot file.

The model itself defines the actuators; the robot file only lists them in comments. Sensors are mounted on the frames of the
model's cameras and sites.
"""

from __future__ import annotations

import math

from graphengine.descriptions.actuators.drives import Drive
from graphengine.descriptions.actuators.mjcf_model import MjcfModel
from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.robot_files.draft import Claim, Draft, rounded
from graphengine.descriptions.robot_files.entries import Entry, SensorKeys
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import printable

KEYFRAME = "home"
"""Name of the keyframe in which robots start, as in the models of MuJoCo Menagerie."""
_STATES = ("JOINTPOS", "JOINTVEL", "JOINTACTFRC", "ACTUATORFRC", "ACTUATORPOS", "ACTUATORVEL")
_PUBLISHED = (*_STATES, "FRAMEPOS", "FRAMEQUAT", "FRAMELINVEL", "FRAMEANGVEL", "VELOCIMETER")
"""Types of sensors whose values JointState, TF and odometry messages contain."""
_INERTIAL = ("ACCELEROMETER", "GYRO")
_KINDS = {"position": "position servo", "velocity": "velocity servo", "effort": "motor"}
_UNITS = {"position": ("rad", "m"), "velocity": ("rad/s", "m/s"), "effort": ("N m", "N")}
_PIXELS = (640, 480)
"""Image size (width, height) of a camera for which the model gives no resolution; MuJoCo's own default is one pixel."""


def add_model_parts(draft: Draft) -> None:
    """List the actuators of each joint, and add a sensor for each camera and IMU of the model."""
    model = draft.description.mjcf
    assert model is not None
    _joints(draft, model)
    for actuator in model.actuators:
        if not actuator.joint:
            label = f"{_KINDS[actuator.kind]} {printable(actuator.name)}"
            draft.carry(f"{label}: commands use its name, as it does not move exactly one joint")
    if KEYFRAME in model.keyframes and draft.library is not None:
        draft.settings["start"] = KEYFRAME
    if model.keyframes:
        names = ", ".join(map(printable, model.keyframes))
        draft.carry(f"keyframes, which `start:` can select: {names}")
    _cameras(draft, model.spec)
    _sensors(draft, model.spec)


def _joints(draft: Draft, model: MjcfModel) -> None:
    names = {joint.name: joint.type == "prismatic" for joint in draft.description.moving()}
    driven: dict[str, list[str]] = {}
    for actuator in model.actuators:
        about = _about(actuator.name, actuator.drive, names.get(actuator.joint, False))
        driven.setdefault(actuator.joint, []).append(about)
    for joint in draft.description.moving():
        free = "" if joint.mimic is not None else "no actuator: takes efforts"
        draft.joints[joint.name].hint = "; ".join(driven.get(joint.name, [])) or free
    for kind in _KINDS:
        if found := [actuator.joint for actuator in model.actuators if actuator.joint and actuator.kind == kind]:
            draft.carry(f"{_KINDS[kind]}s of the model: {', '.join(map(printable, found))}")
    if floating := [joint.name for joint in draft.description.joints.values() if joint.type == "floating"]:
        known = ", ".join(map(printable, floating))
        draft.notice(f"ball and free joints, which graphs cannot read or command: {known}")


def _about(name: str, drive: Drive, slides: bool) -> str:
    (servo,) = drive.servos or ()
    text = f"{_KINDS[servo.kind]} {printable(name)}"
    if math.isfinite(servo.lowest) and math.isfinite(servo.highest):
        text += f", {servo.lowest:.6g} to {servo.highest:.6g} {_UNITS[servo.kind][slides]}"
    return text


def _cameras(draft: Draft, spec: mujoco.MjSpec) -> None:
    """Add a camera sensor on the frame of each named camera of the model."""
    for camera in spec.cameras:
        link = _link(draft, camera.name, "camera")
        if not link:
            continue
        width, height = (int(size) for size in camera.resolution)
        if width * height <= 1:
            width, height = _PIXELS
        tall = float(camera.fovy)
        wide = math.degrees(2 * math.atan(math.tan(math.radians(tall) / 2) * width / height)) if tall < 180 else 180.0
        if not (0.1 <= tall <= 179.0 and 0.1 <= wide <= 179.0 and width <= 4096 and height <= 4096):
            text = f"camera {printable(camera.name)} of {wide:g} x {tall:g} degrees: not supported; "
            text += "legal are 0.1 to 179 degrees and up to 4096 pixels per side"
            draft.lose(text)
            continue
        profile = {"size": [width, height], "fov_deg": [rounded(wide), rounded(tall)], "rate": 30.0}
        claim = _mount(draft, f"{link}_sensor", {"type": "camera", "parent": link, "profile": profile})
        draft.carry(f"camera {printable(camera.name)}: {width} x {height} pixels, 30 images per second", claim=claim)


def _sensors(draft: Draft, spec: mujoco.MjSpec) -> None:
    """Add an IMU at each site with an accelerometer or gyroscope; report other sensors as lost.

    Sensors whose values other messages contain are not reported.
    """
    units: dict[str, None] = {}
    lost: list[str] = []
    for sensor in spec.sensors:
        kind = sensor.type.name.removeprefix("mjSENS_")
        if kind in _INERTIAL:
            units[sensor.objname] = None
        elif kind not in _PUBLISHED:
            lost.append(sensor.name or kind.lower())
    for site in units:
        if link := _link(draft, site, "site"):
            claim = _mount(draft, f"{link}_sensor", {"type": "imu", "parent": link, "profile": {"rate": 100.0}})
            draft.carry(f"IMU at site {printable(site)}: 100 samples per second, without noise or bias", claim=claim)
    if lost:
        text = "sensors of the model that no node publishes; they stay in the model"
        draft.lose(f"{text}: {', '.join(map(printable, lost))}")


def _link(draft: Draft, name: str, kind: str) -> str:
    """Return the name of the link that represents a site or camera in the description; empty if there is none."""
    return next((link for link in (f"{name}_{kind}", name) if name and link in draft.description.links), "")


def _mount(draft: Draft, name: str, value: SensorKeys) -> Claim:
    """Add a sensor, and return the claim that the robot file has this sensor."""
    draft.sensors[prim_name(name)] = Entry(value)
    return {("sensors", prim_name(name)): value}
