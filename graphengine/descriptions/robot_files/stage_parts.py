"""Adds what a USD stage says about a robot to a robot file: materials, sensors, gravity, names, and start positions."""

from __future__ import annotations

import math
from typing import Any

from graphengine.descriptions.robot_files.draft import Draft, Remark, in_path, rounded
from graphengine.descriptions.robot_files.entries import Entry, MaterialKeys, SensorKeys
from graphengine.descriptions.usd_model import StageMaterial, StageSensor, StatedDrive
from graphengine.devices.rotation import IDENTITY
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import printable

_LIDARS = {
    "microscan3": "microscan3_9m_20hz",
    "rotary2d": "lidar_360",
    "rplidar": "lidar_360",
    "tim781": "lidar_360",
    "16": "lidar_3d_16",
    "32": "lidar_3d_32",
    "64": "lidar_3d_64",
    "128": "lidar_3d_64",
    "rotary": "lidar_3d_64",
}
"""Profiles of lidars, by a part of the names of their configurations in Isaac Sim; the first that fits counts."""
_PIXELS = (640, 480)
"""Size of a picture of a camera, which a stage does not give."""
_UPRIGHT = 1e-9


def add_stage_parts(draft: Draft) -> None:
    """Add to a draft what its stage says beyond links, joints and drives."""
    usd = draft.description.usd
    assert usd is not None
    if usd.fixed:
        draft.fixed_base = True
        draft.carry("the base is fixed to the world, as a joint of the stage fixes it", claim={("fixed_base",): True})
    if usd.articulation_root:
        draft.settings["articulation_root"] = usd.articulation_root
    if usd.self_collision:
        draft.settings["self_collision"] = True
    for setting, texts in (("namespaces", usd.namespaces), ("name_overrides", usd.overrides)):
        if texts:
            root = draft.description.root
            draft.settings[setting] = {in_path(name or root): text for name, text in texts.items()}
    for link in usd.weightless:
        draft.links[link].value["gravity"] = False
    for joint in draft.description.moving():
        if joint.name in usd.drives:
            _joint(draft, joint.name, usd.drives[joint.name])
    for name, (material, links) in usd.materials.items():
        _material(draft, name, material, links)
    for name, sensor in usd.sensors.items():
        _sensor(draft, name, sensor)
    for lost, path, text, span in usd.remarks:
        (draft.lost if lost else draft.guessed).append(Remark(text, span, {}, ("prim", printable(path))))


def _joint(draft: Draft, name: str, stated: StatedDrive) -> None:
    entry, joint = draft.joints[name], draft.description.joints[name]
    if stated.armature:
        entry.value["armature"] = stated.armature
    held = stated.stiffness > 0 and stated.position
    start = stated.position if held else stated.start
    if start and joint.mimic is None:
        entry.value["start"] = rounded(start, 9)
        where = "the target of its drive" if held else "its position in the stage"
        draft.carry(f"joint {printable(name)} starts at {start:g}, {where}", joint.element.span)


def _material(draft: Draft, name: str, stated: StageMaterial, links: list[str]) -> None:
    value: MaterialKeys = {
        "static_friction": rounded(stated.static_friction),
        "dynamic_friction": rounded(stated.dynamic_friction),
        "combine": stated.combine,
        "bind": links,
    }
    draft.materials[name] = Entry(value)
    frictions = f"friction {stated.dynamic_friction:g} sliding"
    if stated.static_friction != stated.dynamic_friction:
        frictions += f"; {stated.static_friction:g} at rest, which MuJoCo does not distinguish"
    draft.carry(f"physics material {printable(name)}: {frictions}", claim={("materials", name): ...})
    if stated.restitution:
        draft.lose(f"restitution {stated.restitution:g} of {printable(name)}: contacts of MuJoCo have none")


def _sensor(draft: Draft, name: str, sensor: StageSensor) -> None:
    span = draft.description.links[sensor.body].element.span
    profile, problem = _profile(sensor)
    if problem:
        draft.lose(f"sensor {printable(sensor.path)}: {problem}", span)
        return
    value: SensorKeys = {"type": sensor.type, "parent": in_path(sensor.body)}
    if profile:
        value["profile"] = profile
    position, orientation = sensor.pose
    if any(position):
        value["position"] = [rounded(part) for part in position]
    if any(abs(one - other) > _UPRIGHT for one, other in zip(orientation, IDENTITY, strict=True)):
        value["orientation"] = {"quaternion_xyzw": [rounded(part, 9) for part in orientation]}
    key = name
    while key in draft.sensors or prim_name(key) in draft.description.links:
        key += "_sensor"
    draft.sensors[key] = Entry(value)
    draft.carry(f"{sensor.type} {printable(sensor.path)}", span, {("sensors", key): ...})
    if guessed := _GUESSED.get(sensor.type):
        draft.guess(f"sensor {printable(key)}: {guessed}", span, {("sensors", key): ...})


_GUESSED = {
    "camera": f"{_PIXELS[0]} x {_PIXELS[1]} pixels, 30 pictures per second",
    "imu": "100 samples per second, without noise or bias",
    "lidar": "the profile, by the name of its configuration",
}


def _profile(sensor: StageSensor) -> tuple[dict[str, Any] | str, str]:
    """Return the profile of a sensor, and the reason why it has none; the reason is empty if it has one."""
    if sensor.type == "camera":
        wide, high = (math.degrees(2 * math.atan2(size, 2 * sensor.focal)) for size in sensor.aperture)
        if not (0.1 <= wide <= 179.0 and 0.1 <= high <= 179.0):
            return "", f"a field of view of {wide:g} x {high:g} degrees; legal are 0.1 to 179"
        return {"size": [*_PIXELS], "fov_deg": [rounded(wide), rounded(high)], "rate": 30.0}, ""
    if sensor.type != "lidar":
        return ({"rate": 100.0} if sensor.type == "imu" else "contact" * (sensor.type == "contact")), ""
    plain = sensor.model.lower().replace("_", "").replace(" ", "")
    found = next((profile for part, profile in _LIDARS.items() if part in plain), "")
    return found, "" if found else f"no profile is known for its configuration {printable(sensor.model)!r}"
