"""Reads mobile bases from drive plugins of Gazebo Sim and Gazebo classic."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from graphengine.bringup.robots.base import Base, flaw, given
from graphengine.bringup.robots.gazebo_topics import legal
from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_files.draft import Draft, Remark
from graphengine.format.wording import printable


def base_of_plugins(draft: Draft) -> Base | None:
    """Return the base of the first usable drive plugin, with topics of other plugins; None without such a plugin."""
    base: Base | None = None
    topics: dict[str, float | str] = {}
    for plugin in (element for element in draft.description.element.walk() if element.tag == "plugin"):
        told = _told(plugin)
        if "planar_move" in told:
            draft.use(plugin)
            draft.pushed = True
            draft.lost.append(Remark("plugin planar_move: it pushes the base without turning its wheels", plugin.span))
        elif "joint_state_publisher" in told or "jointstatepublisher" in told:
            draft.use(plugin)
            topics |= given(joint_states=_topic(plugin, "joint_states", "topic"))
        elif "odometry_publisher" in told or "odometrypublisher" in told:
            draft.use(plugin)
            topics |= given(odom=_topic(plugin, "odom", "odom_topic"), odom_frame=_first(plugin, "odom_frame") or None)
        else:
            reader = next((reader for part, reader in _READERS.items() if part in told), None)
            if reader is None or base is not None:
                continue
            read = reader(plugin)
            read = replace(read, source=_source(plugin), span=plugin.span, parameters=_topics(plugin) | read.parameters)
            draft.use(plugin)
            if reason := flaw(draft, read):
                draft.lost.append(Remark(f"{read.source}: {reason}", plugin.span))
            else:
                base = read
    return base.with_parameters(topics) if base is not None else None


def topics_of_plugins(draft: Draft) -> dict[str, float | str]:
    """Return topics from the remappings of Gazebo's ros2_control plugin, as parameters of the base's graph."""
    found: dict[str, float | str] = {}
    for plugin in (element for element in draft.description.element.walk() if element.tag == "plugin"):
        if "ros2_control" in _told(plugin) or "ros2control" in _told(plugin):
            command = [_remapped(plugin, f"~/{name}") for name in ("cmd_vel_unstamped", "cmd_vel", "reference")]
            odometry = [_remapped(plugin, f"~/{name}") for name in ("odom", "odometry")]
            found |= given(
                cmd_vel=legal(next(filter(None, command), "")) or None,
                odom=legal(next(filter(None, odometry), "")) or None,
                joint_states=legal(_remapped(plugin, "joint_states")) or None,
            )
    return found


_ACCELERATIONS = ("max_linear_acceleration", "max_acceleration", "max_wheel_acceleration", "wheelAcceleration")
"""Tags of the acceleration, m/s2; the last two are those of Gazebo classic, where it is that of the rim of a wheel."""


def _differential(plugin: Element) -> Base:
    left = (*_texts(plugin, "left_joint"), *_texts(plugin, "leftJoint"))
    right = (*_texts(plugin, "right_joint"), *_texts(plugin, "rightJoint"))
    sides = [f"{side}{end}Joint" for end in ("Front", "Rear") for side in ("left", "right")]  # skid_steer_drive
    sides += [f"{side}_{end}" for end in ("front", "rear") for side in ("left", "right")]  # SkidSteerDrivePlugin
    driven = (*left, *right) or tuple(name for side in sides for name in _texts(plugin, side))
    return Base(
        "differential",
        driven,
        radius=_radius(plugin),
        track=_number(plugin, "wheel_separation", "wheelSeparation"),
        parameters=given(
            speed=_number(plugin, "max_linear_velocity", "max_velocity"),
            turn=_number(plugin, "max_angular_velocity"),
            acceleration=_number(plugin, *_ACCELERATIONS),
            deceleration=_number(plugin, *_ACCELERATIONS),
            turn_acceleration=_number(plugin, "max_angular_acceleration"),
        ),
    )


def _mecanum(plugin: Element) -> Base:
    wheels = [f"{end}_{side}_joint" for end in ("front", "back") for side in ("left", "right")]
    return Base(
        "mecanum",
        tuple(name for wheel in wheels for name in _texts(plugin, wheel)),
        radius=_radius(plugin),
        parameters=given(speed=_number(plugin, "max_velocity"), acceleration=_number(plugin, "max_acceleration")),
    )


def _ackermann(plugin: Element) -> Base:
    driven = (*_texts(plugin, "left_joint"), *_texts(plugin, "right_joint"))
    classic = (*_texts(plugin, "rear_left_joint"), *_texts(plugin, "rear_right_joint"))
    return Base(
        "ackermann",
        driven or classic,
        (*_texts(plugin, "left_steering_joint"), *_texts(plugin, "right_steering_joint")),
        radius=_radius(plugin),
        track=_number(plugin, "wheel_separation"),
        wheelbase=_number(plugin, "wheel_base"),
        parameters=given(
            steering_limit=_number(plugin, "steering_limit", "max_steer"),
            acceleration=_number(plugin, "max_acceleration"),
        ),
    )


_READERS: dict[str, Callable[[Element], Base]] = {
    "diff_drive": _differential,
    "diff-drive": _differential,
    "diffdrive": _differential,
    "skid_steer_drive": _differential,
    "skidsteerdrive": _differential,
    "mecanum-drive": _mecanum,
    "mecanumdrive": _mecanum,
    "ackermann": _ackermann,
}
"""Function that reads the base of a plugin, by a part of the plugin's file name or name in lower case."""


def _told(plugin: Element) -> str:
    return f"{plugin.get('filename')} {plugin.get('name')}".lower().replace("-publisher", "_publisher")


def _source(plugin: Element) -> str:
    name = plugin.get("name").rpartition("::")[2] or plugin.get("filename")
    return printable(f"Gazebo's plugin {name}")


def _texts(plugin: Element, tag: str) -> tuple[str, ...]:
    return tuple(child.text for child in plugin.all(tag) if child.text)


def _first(plugin: Element, *tags: str) -> str:
    return next((text for tag in tags for text in _texts(plugin, tag)), "")


def _number(plugin: Element, *tags: str) -> float | None:
    """Return the absolute value of the first number other than 0 in elements with the given tags; None if there is none."""
    values = (number(text) for tag in tags for text in _texts(plugin, tag))
    return next((abs(value) for value in values if value), None)


def _radius(plugin: Element) -> float | None:
    diameter = _number(plugin, "wheel_diameter", "wheelDiameter")
    return _number(plugin, "wheel_radius", "wheelRadius") or (diameter / 2.0 if diameter is not None else None)


def _topics(plugin: Element) -> dict[str, float | str]:
    return given(
        cmd_vel=_topic(plugin, "cmd_vel", "topic", "command_topic", "commandTopic"),
        odom=_topic(plugin, "odom", "odom_topic", "odometry_topic", "odometryTopic"),
        odom_frame=_first(plugin, "frame_id", "odometry_frame", "odometryFrame").rpartition("/")[2] or None,
    )


def _topic(plugin: Element, name: str, *tags: str) -> str | None:
    """Return the topic in one of a plugin's tags, or to which the plugin remaps its topic `name`; None without either.

    A plugin of Gazebo classic may have a namespace, which is put before each name that does not begin with `/`.
    """
    written = _first(plugin, *tags) or _remapped(plugin, name)
    spaces = [text for ros in plugin.all("ros") for text in _texts(ros, "namespace")]
    space = legal(next(iter(spaces), "") or _first(plugin, "robotNamespace"))
    if space and not written.startswith("/"):
        written = f"{space}/{written or name}"
    return legal(written) or None


def _remapped(plugin: Element, name: str) -> str:
    """Return the new name that a `<remapping>` of a plugin gives to `name`; empty if the name is not remapped."""
    elements = (each for ros in plugin.all("ros") for tag in ("remapping", "argument") for each in ros.all(tag))
    remappings = (element.text.partition(":=") for element in elements)
    return next((new.strip() for old, _, new in remappings if old.strip() == name), "")
