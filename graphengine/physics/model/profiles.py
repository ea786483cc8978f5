"""Reads sensor profiles: the parameters of a sensor, or the devices of a rig with several sensors.

A profile is a file `sensors/NAME.yaml` to which robot files refer, or a mapping of parameters in the robot file itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, create_model, model_validator

from graphengine.descriptions.robot_files.robot_file import RobotFile
from graphengine.devices.device import Device
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document, Value
from graphengine.format.files import Files, NotFoundError, shipped
from graphengine.format.kinds import DEVICES
from graphengine.format.legal_names import Name
from graphengine.format.robot_spec import Share
from graphengine.format.spec import UPRIGHT, Format, Orientation, Spec, Vector
from graphengine.format.spec_reader import Loaded, read, validate
from graphengine.physics.implementations import IMPLEMENTATIONS, Offsets, Profile

S = TypeVar("S", bound="DeviceSections")

Length = Annotated[float, Field(gt=0.0, le=10.0)]


class DeviceSections(Spec):
    """A pydantic model with an optional section for each kind of device; a file contains exactly one of these sections."""

    @classmethod
    def kinds(cls) -> list[Device]:
        """Return the kinds of device for which the model has a section."""
        return [device for device in DEVICES.all.values() if device.kind in cls.model_fields]

    def devices(self) -> list[tuple[Device, Profile]]:
        """Return the sections in the file as (kind of device, profile)."""
        return [(kind, profile) for kind in self.kinds() if (profile := getattr(self, kind.kind)) is not None]


def _with_sections(*, only_in_rigs: bool = False) -> Callable[[type[S]], type[S]]:
    """Return a class decorator that adds a section for each kind of device, or only for kinds that a rig can contain."""

    def add(model: type[S]) -> type[S]:
        kinds = [device.kind for device in DEVICES.all.values() if device.in_rigs or not only_in_rigs]
        sections: dict[str, Any] = {kind: (IMPLEMENTATIONS.all[kind].profile | None, None) for kind in kinds}
        return create_model(model.__name__, __base__=model, __module__=__name__, **sections)

    return add


@_with_sections(only_in_rigs=True)
class PartSpec(DeviceSections):
    """A device of a rig. A camera looks along its -z axis, with +y up in the image."""

    position: Vector = (0.0, 0.0, 0.0)
    """Position in the frame of the housing, m."""
    orientation: Orientation = UPRIGHT
    """Orientation in the frame of the housing."""

    @model_validator(mode="after")
    def _one_kind(self) -> PartSpec:
        if len(self.devices()) != 1:
            raise ValueError(f"a part is {' or '.join(device.title for device in self.kinds())}")
        return self


class RigProfile(Spec):
    """Several devices, such as cameras and IMUs, in one housing."""

    housing: Name
    """Name of the prim that carries the devices of the rig."""
    parts: dict[Name, PartSpec]
    """Devices of the rig, as name: {position: [0, 0, 0], camera: {…}}."""


class ShapeSpec(Spec):
    """A part of a sensor's body. It is visible to cameras and to rays of other robots, and does not collide."""

    shape: Literal["box", "cylinder"]
    """Shape of the part."""
    size: Annotated[tuple[Length, Length, Length], Field(strict=False)]
    """Length, width and height, m; a cylinder stands upright and is round."""
    position: Offsets = (0.0, 0.0, 0.0)
    """Position of the shape's centre in the frame of the sensor's mount, m."""
    colour: Annotated[tuple[Share, Share, Share], Field(strict=False)]
    """Red, green, blue; 0 to 1."""

    @model_validator(mode="after")
    def _round(self) -> ShapeSpec:
        if self.shape == "cylinder" and self.size[0] != self.size[1]:
            raise ValueError("a cylinder is round: length and width must be equal")
        return self


@_with_sections()
class DeviceProfile(DeviceSections):
    """The content of a sensor profile for a single device."""

    format: Format = 1
    sensor: Name
    """Name of the profile."""
    doc: str = ""
    """Description for readers of the file, such as the source of the values."""


class SensorProfile(DeviceProfile):
    """The content of a sensor profile, for a single device or a rig."""

    rig: RigProfile | None = None
    """Several devices in one housing, instead of the section of a single device."""
    appearance: Annotated[tuple[ShapeSpec, ...], Field(strict=False, max_length=100)] = ()
    """Appearance for cameras and for rays of other robots."""

    @model_validator(mode="after")
    def _one_section(self) -> SensorProfile:
        if len(self.devices()) + (self.rig is not None) != 1:
            raise ValueError(f"a profile is one of: {', '.join([*(device.kind for device in self.kinds()), 'rig'])}")
        return self

    def all_devices(self) -> list[Profile]:
        """Return the profiles of the single device, or of the devices of the rig."""
        holders: list[DeviceSections] = [self, *(self.rig.parts.values() if self.rig is not None else ())]
        return [profile for holder in holders for _, profile in holder.devices()]


def read_profiles(robot: RobotFile, files: Files, findings: Findings) -> dict[str, SensorProfile]:
    """Return a dict from the name of each sensor of a robot to its profile; sensors whose profile has errors are left out."""
    loaded: dict[str, Loaded[SensorProfile] | None] = {}
    found = {name: _profile(robot, name, loaded, files, findings) for name in robot.spec.sensors}
    return {name: profile for name, profile in found.items() if profile is not None}


def _section(sensor_type: str) -> str:
    """Return the name of the profile section that a sensor of this type requires."""
    return "rig" if sensor_type == "realsense_d455" else sensor_type


def _figures(
    robot: RobotFile, name: str, sensor_type: str, figures: dict[str, Any], findings: Findings
) -> SensorProfile | None:
    """Return the profile of a sensor whose parameters are in the robot file itself; None after an error."""
    location, section = ("sensors", name, "profile"), _section(sensor_type)
    document = robot.document(*location)
    value = document.find(*location) or document.root
    whole = Value(value.span, {section: value}, {section: document.key_span(*location)})
    profile = Document(document.source, whole, document.size)
    return validate(SensorProfile, profile, {"sensor": name, section: figures}, findings)


def _profile(
    robot: RobotFile, name: str, loaded: dict[str, Loaded[SensorProfile] | None], files: Files, findings: Findings
) -> SensorProfile | None:
    """Return the profile of a sensor; None after an error.

    If the robot file names no profile, the built-in profile with the name of the sensor type is used.

    Args:
        robot: robot file.
        name: name of the sensor.
        loaded: a dict from name to profile for the files that were read; None for a file with an error.
        files: finds the file of the profile.
        findings: receives the errors.
    """
    sensor_type, profile = robot.spec.sensors[name].type, robot.spec.sensors[name].profile
    if isinstance(profile, dict):
        return _figures(robot, name, sensor_type, profile, findings)
    profile = profile or _own_profile(sensor_type)
    span = robot.span("sensors", name, "profile")
    if not profile:
        place = robot.key_span("sensors", name)
        findings.add("G107", f"sensor {name!r}: a {sensor_type} needs a profile", place, _known())
        return None
    if profile not in loaded:
        try:
            path = files.find(f"sensors/{profile}.yaml", robot.folder("sensors", name, "profile"))
        except NotFoundError as error:
            near = error.help[0].replace("sensors/", "").replace(".yaml", "")
            findings.add("S101", f"no sensor profile {profile!r}", span, near, _known())
            return None
        loaded[profile] = read(SensorProfile, path, findings)
    entry = loaded[profile]
    if entry is None:
        return None
    if getattr(entry.spec, _section(sensor_type)) is None:
        findings.add("G109", f"profile {profile!r} is not for a {sensor_type}", span, _known())
        return None
    return entry.spec


def _own_profile(sensor_type: str) -> str:
    """Return the name of the built-in profile for a sensor type, for sensors without `profile:`; empty if there is none."""
    return sensor_type if (shipped() / f"scenes/sensors/{sensor_type}.yaml").is_file() else ""


def _known() -> str:
    names = sorted(path.stem for path in (shipped() / "scenes/sensors").glob("*.yaml"))
    return f"built-in profiles: {', '.join(names)}"
