"""Reads sensors: cameras, lidars, IMUs and contact sensors; runs in the confined process."""

from __future__ import annotations

from pxr import Usd

from graphengine.descriptions.usd.stage_bodies import body_of
from graphengine.descriptions.usd.stage_frames import StageFrames, number, text
from graphengine.descriptions.usd_model import StageSensor

_TYPES = {
    "Camera": "camera",
    "OmniLidar": "lidar",
    "Lidar": "lidar",
    "IsaacImuSensor": "imu",
    "IsaacContactSensor": "contact",
}
_REALSENSE = "RSD455"
"""Name of the prim with the cameras of a RealSense D455, which are one sensor."""
_MODELS = ("sensorModelConfig", "omni:sensor:modelName", "omni:sensor:Core:modelName")
"""Attributes with the name of a lidar's configuration."""


def read_sensor(prim: Usd.Prim, frames: StageFrames) -> StageSensor | None:
    """Return a sensor; None if the prim is none.

    Raises:
        UnusableError: the transform is not finite.
    """
    kind = _TYPES.get(str(prim.GetTypeName()))
    if kind is None:
        return None
    body, mount = body_of(prim), prim
    while (above := mount.GetParent()) and str(above.GetPath()) != body and not above.IsPseudoRoot():
        mount = above
    if _REALSENSE in str(prim.GetPath()).split("/"):
        path = str(mount.GetPath())
        return StageSensor(path, "realsense_d455", body, frames.placed(mount).pose, path)
    model = next(filter(None, (text(prim, name) for name in _MODELS)), "")
    if kind == "camera" and (model or text(prim, "cameraSensorType") == "lidar"):
        kind = "lidar"
    sensor = StageSensor(str(prim.GetPath()), kind, body, frames.placed(prim).pose, str(mount.GetPath()), model)
    if kind == "camera":
        sensor.focal = number(prim, "focalLength", 50.0)
        sensor.aperture = number(prim, "horizontalAperture", 20.955), number(prim, "verticalAperture", 15.2908)
    return sensor
