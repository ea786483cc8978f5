"""Reads mobile bases from ros2_control's controllers, and from drive plugins of Gazebo Sim and Gazebo classic."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from graphengine.bringup.robots.base import Base, Kinematics, given
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.bringup.robots.gazebo_topics import legal
from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_files.draft import Draft, no_joint
from graphengine.format.wording import printable


@dataclass(frozen=True, slots=True)
class _Names:
    """The names under which a type of controller or plugin gives the properties of a base.

    A text lists alternative names, separated by spaces; the first name with a value counts.

    Attributes:
        kinematics: kinematics of the base.
        driven: groups of names for the joints of driven wheels; the joints of the first group with a joint count.
        steering: groups of names for the joints that take steering commands.
        radius: names for the radius of the wheels.
        diameter: names for the diameter of the wheels, for sources without a radius.
        factor: names for a factor of the radius.
        track: names for the distance between left and right wheels.
        multiplier: names for a factor of the track.
        wheelbase: names for the distance between front and rear axle.
        parameters: names for each parameter of the base's graph.
    """

    kinematics: Kinematics
    driven: tuple[str, ...]
    steering: tuple[str, ...] = ()
    radius: str = "wheel_radius"
    diameter: str = ""
    factor: str = ""
    track: str = ""
    multiplier: str = ""
    wheelbase: str = ""
    parameters: Mapping[str, str] = field(default_factory=dict)

    def read(self, joints: Callable[..., tuple[str, ...]], positive: Callable[..., float | None]) -> Base:
        """Return the base.

        Args:
            joints: returns all joints under the given names.
            positive: returns the first positive number under the given names; None without such a number.
        """
        radius, diameter = positive(*self.radius.split()), positive(*self.diameter.split())
        radius = diameter / 2.0 if radius is None and diameter is not None else radius
        factor = positive(*self.factor.split()) or 1.0
        return Base(
            self.kinematics,
            next(filter(None, (joints(*names.split()) for names in self.driven)), ()),
            next(filter(None, (joints(*names.split()) for names in self.steering)), ()),
            radius=radius * factor if radius is not None else None,
            track=positive(*self.track.split()),
            wheelbase=positive(*self.wheelbase.split()),
            multiplier=positive(*self.multiplier.split()) or 1.0,
            parameters=given(**{name: positive(*names.split()) for name, names in self.parameters.items()}),
        )


_TABLES = json.loads(Path(__file__).with_name("base_names.json").read_text("utf-8"))
_CONTROLLERS = {kind: _Names(**names) for kind, names in _TABLES["controllers"].items()}
"""A dict from the last part of a controller's type to the names of its parameters."""
_PLUGINS = {pattern: _Names(**names) for pattern, names in _TABLES["plugins"].items()}
"""A dict from a pattern of a plugin's file name or name, in lower case, to the names of its tags.

The accelerations `max_wheel_acceleration` and `wheelAcceleration` of Gazebo classic are those of the rim of a wheel, in m/s2.
"""
_REAR_STEERED = {"rear_wheels_names": "front_wheels_names", "front_wheels_names": "rear_wheels_names"}
"""Names that a controller exchanges if its parameter `front_steering` is false."""
_MILLISECONDS = "TricycleController"
"""The controller whose timeout is in ms instead of s."""


def base_of_controllers(draft: Draft, controllers: Iterable[Controller]) -> Base | None:
    """Return the base of the first controller that drives a base; None if no controller does.

    Bases that cannot be used, and bases after the first one, are added to `draft.lost`.
    """
    chosen: Base | None = None
    for controller in (each for each in controllers if each.kind in _CONTROLLERS):
        read = _CONTROLLERS[controller.kind].read(partial(_joints, controller), partial(_positive, controller))
        base = read.of_source(controller.title, controller.span, _general(controller))
        if reason := f"{chosen.source} drives the base" if chosen is not None else _flaw(draft, base):
            draft.lose(f"{base.source}: {reason}", base.span)
            continue
        chosen = base
        if not controller.flag("enable_odom_tf", default=True):
            text = "enable_odom_tf is false, but the graph publishes the transform odom -> base"
            draft.lose(f"{base.source}: {text}", base.span)
    return chosen


def _general(controller: Controller) -> dict[str, float | str]:
    """Return the odometry frame and command timeout of a controller, as parameters of the graph."""
    frame, timeout = next(iter(controller.texts("odom_frame_id")), None), controller.positive("cmd_vel_timeout")
    if timeout is not None and controller.kind == _MILLISECONDS:
        timeout /= 1000.0
    return given(odom_frame=frame, timeout=timeout)


def _joints(controller: Controller, *names: str) -> tuple[str, ...]:
    if not controller.flag("front_steering", default=True):
        names = tuple(_REAR_STEERED.get(name, name) for name in names)
    return tuple(dict.fromkeys(controller.texts(*names)))


def _positive(controller: Controller, *names: str) -> float | None:
    """Return the first positive number in these parameters; the magnitude of a limit, unless another parameter disables it."""
    for name in names:
        axis, _, limit = name.rpartition(".max_")
        if not axis:
            return controller.positive(*names)
        switch = "acceleration" if limit == "deceleration" else limit
        value = abs(controller.number(name) or 0.0)
        if value and controller.flag(f"{axis}.has_{switch}_limits", default=True):
            return value
    return None


def base_of_plugins(draft: Draft) -> Base | None:
    """Return the base of the first usable drive plugin, or None if the description has no usable drive plugin.

    Topics of other plugins, such as odometry_publisher, replace those of the drive plugin.
    """
    base: Base | None = None
    topics: dict[str, float | str] = {}
    for plugin, told in _plugins(draft):
        if "planar_move" in told:
            draft.use(plugin)
            draft.pushed = True
            draft.lose("plugin planar_move: it pushes the base without turning its wheels", plugin.span)
        elif "joint_state_publisher" in told or "jointstatepublisher" in told:
            draft.use(plugin)
            topics |= given(joint_states=_topic(plugin, "joint_states", "topic"))
        elif "odometry_publisher" in told or "odometrypublisher" in told:
            draft.use(plugin)
            topics |= given(odom=_topic(plugin, "odom", "odom_topic"), odom_frame=_first(plugin, "odom_frame") or None)
        else:
            names = next((names for pattern, names in _PLUGINS.items() if re.search(pattern, told)), None)
            if names is None or base is not None:
                continue
            read = names.read(partial(_texts, plugin), partial(_number, plugin))
            read = read.of_source(_source(plugin), plugin.span, _topics(plugin))
            draft.use(plugin)
            if reason := _flaw(draft, read):
                draft.lose(f"{read.source}: {reason}", plugin.span)
            else:
                base = read
    return base.with_parameters(topics) if base is not None else None


def topics_of_plugins(draft: Draft) -> dict[str, float | str]:
    """Return the topics to which Gazebo's ros2_control plugin remaps, as parameters of the base's graph."""
    found: dict[str, float | str] = {}
    for plugin, told in _plugins(draft):
        if "ros2_control" in told or "ros2control" in told:
            command = [_remapped(plugin, f"~/{name}") for name in ("cmd_vel_unstamped", "cmd_vel", "reference")]
            odometry = [_remapped(plugin, f"~/{name}") for name in ("odom", "odometry")]
            found |= given(
                cmd_vel=legal(next(filter(None, command), "")) or None,
                odom=legal(next(filter(None, odometry), "")) or None,
                joint_states=legal(_remapped(plugin, "joint_states")) or None,
            )
    return found


def _plugins(draft: Draft) -> Iterator[tuple[Element, str]]:
    """Yield each plugin, and a text with its file name and its name in lower case."""
    for plugin in (element for element in draft.description.element.walk() if element.tag == "plugin"):
        told = f"{plugin.get('filename')} {plugin.get('name')}".lower()
        yield plugin, told.replace("-publisher", "_publisher")


def _source(plugin: Element) -> str:
    name = plugin.get("name").rpartition("::")[2] or plugin.get("filename")
    return printable(f"Gazebo's plugin {name}")


def _texts(element: Element, *tags: str) -> tuple[str, ...]:
    return tuple(child.text for tag in tags for child in element.all(tag) if child.text)


def _first(plugin: Element, *tags: str) -> str:
    return next(iter(_texts(plugin, *tags)), "")


def _number(plugin: Element, *tags: str) -> float | None:
    """Return the magnitude of the first nonzero number in the elements with these tags; None without such a number."""
    values = (number(text) for text in _texts(plugin, *tags))
    return next((abs(value) for value in values if value), None)


def _topics(plugin: Element) -> dict[str, float | str]:
    return given(
        cmd_vel=_topic(plugin, "cmd_vel", "topic", "command_topic", "commandTopic"),
        odom=_topic(plugin, "odom", "odom_topic", "odometry_topic", "odometryTopic"),
        odom_frame=_first(plugin, "frame_id", "odometry_frame", "odometryFrame").rpartition("/")[2] or None,
    )


def _topic(plugin: Element, name: str, *tags: str) -> str | None:
    """Return the topic in the first of some tags of a plugin, else the name to which the plugin remaps `name`; else None.

    Each name that does not begin with `/` gets the namespace that a plugin of Gazebo classic may have.
    """
    written = _first(plugin, *tags) or _remapped(plugin, name)
    spaces = [text for ros in plugin.all("ros") for text in _texts(ros, "namespace")]
    space = legal(next(iter(spaces), "") or _first(plugin, "robotNamespace"))
    if space and not written.startswith("/"):
        written = f"{space}/{written or name}"
    return legal(written) or None


def _remapped(plugin: Element, name: str) -> str:
    """Return the new name of `name` in a `<remapping>` of a plugin; empty if the plugin does not remap this name."""
    elements = (each for ros in plugin.all("ros") for tag in ("remapping", "argument") for each in ros.all(tag))
    remappings = (element.text.partition(":=") for element in elements)
    return next((new.strip() for old, _, new in remappings if old.strip() == name), "")


def _flaw(draft: Draft, base: Base) -> str:
    """Return the reason why the joints of a base cannot drive the base; empty if they can."""
    joints = draft.description.joints
    for name in (*base.driven, *base.steering):
        if name not in joints:
            return no_joint(draft.description, name)
        if not joints[name].moves:
            return f"joint {printable(name)!r} is fixed"
    return "" if base.driven else "it names no wheels"
