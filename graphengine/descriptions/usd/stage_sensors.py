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
    model = next(filter(None, (text(prim, name) for name in _MODELS)), "")
    if kind == "camera" and (model or text(prim, "cameraSensorType") == "lidar"):
        kind = "lidar"
    sensor = StageSensor(str(prim.GetPath()), kind, body_of(prim), frames.placed(prim).pose, model)
    if kind == "camera":
        sensor.focal = number(prim, "focalLength", 50.0)
        sensor.aperture = number(prim, "horizontalAperture", 20.955), number(prim, "verticalAperture", 15.2908)
    return sensor
