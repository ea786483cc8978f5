"""Converts the Gazebo sensors of a description to sensors of the robot file and graphs that publish them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from graphengine.bringup.robots import gazebo_profiles, gazebo_topics
from graphengine.bringup.robots.gazebo_values import GAZEBO_NAMES, Figures, Subject, UnusableError, Values
from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.robot_files.draft import Claim, Draft, graph_defaults
from graphengine.descriptions.robot_files.entries import Entry, SensorKeys
from graphengine.devices.camera import LOOKING_FORWARD
from graphengine.devices.device import Device
from graphengine.devices.rotation import IDENTITY, NOWHERE, Pose, compose, from_rpy, multiply, relative
from graphengine.format.kinds import DEVICES
from graphengine.format.prim_paths import prim_name
from graphengine.format.wording import printable
from graphengine.physics.implementations import IMPLEMENTATIONS

MAX_SENSORS = 200
"""Maximum number of sensors that are imported from one description."""
_IMU_PLUGINS = ("gazebo_ros_imu", "hector_gazebo_ros_imu")
MAX_DISTANCE = 1e6
"""Maximum distance (m) of a sensor from its link."""
_OPTICAL = multiply(LOOKING_FORWARD, (1.0, 0.0, 0.0, 0.0))
"""Orientation of an optical frame (z forward, x right) in the frame of a camera that looks along its x axis."""
_SAME = 1e-3
"""Tolerance of equal poses: coordinates differ by less, m, and the product of the quaternions exceeds 1 minus its square."""
_NO_EFFECT = GAZEBO_NAMES["sensor_settings_without_effect"]
"""Tags without effect, which are not reported as lost. A plugin's rate is among them: it counts only if the sensor has none."""


@dataclass(frozen=True, slots=True)
class _Found:
    """A convertible Gazebo sensor: its prim name, link, pose on the link, conversion and topics."""

    name: str
    link: str
    pose: Pose
    values: Values
    figures: Figures
    subject: Subject
    topics: dict[str, str]


def add_sensors(draft: Draft) -> None:
    """Add a sensor and a graph that publishes it for each Gazebo sensor; types without an equivalent are reported as lost."""
    found = list(_sensors(draft))
    unnamed = Counter(sensor.figures.graph for sensor in found if not sensor.topics)
    for sensor in found:
        _mount(draft, sensor)
        _publish(draft, sensor, alone=unnamed[sensor.figures.graph] == 1)
        if left := dict.fromkeys(part.tag for part in sensor.values.unread() if part.tag not in _NO_EFFECT):
            sensor.subject.lost(f"not used: {', '.join(printable(tag[:40]) for tag in list(left)[:10])}")


def _sensors(draft: Draft) -> Iterator[_Found]:
    """Yield the convertible sensors in order of the file, with unique prim names; report the others as lost."""
    description = draft.description
    taken = {prim_name(name) for name in (*description.links, *description.joints)}
    elements = [each for gazebo in description.element.all("gazebo") for each in _elements(gazebo)]
    if len(elements) > MAX_SENSORS:
        draft.lose(f"sensors after the first {MAX_SENSORS}", elements[MAX_SENSORS][1].span)
    for link, element in elements[:MAX_SENSORS]:
        draft.use(element)
        if (found := _read(draft, element, link, taken)) is not None:
            taken.add(found.name)
            yield found


def _elements(gazebo: Element) -> Iterator[tuple[str, Element]]:
    """Yield the link name and the element of each sensor; also of IMUs that are plugins outside of a sensor in Gazebo classic."""
    for sensor in gazebo.all("sensor"):
        yield gazebo.get("reference"), sensor
    for plugin in gazebo.all("plugin"):
        if plugin.get("filename").removeprefix("lib").removesuffix(".so") in _IMU_PLUGINS:
            values = Values(plugin)
            link = values.text("bodyName|body_name") or gazebo.get("reference")
            attributes = {"type": "imu", "name": plugin.get("name") or "imu"}
            yield link, Element("sensor", attributes, plugin.span, [plugin])


def _read(draft: Draft, element: Element, link: str, taken: set[str]) -> _Found | None:
    kind, given, values = element.get("type"), element.get("name") or element.get("type"), Values(element)
    subject = Subject(draft, "sensor", given, element.span)
    joint = draft.description.joints.get(link)
    if joint is not None and (kind == "force_torque" or link not in draft.description.links):
        link = joint.child
    if kind not in gazebo_profiles.READERS:
        like = gazebo_profiles.NO_LIKE.get(kind, f"a sensor of type {printable(kind[:40])!r}")
        subject.lost(f"there is nothing like {like}", element.place("type"))
    elif link not in draft.description.links:
        subject.lost(f"the robot has no link {printable(link[:60])!r}" if link else "its <gazebo> names no link")
    elif kind == "contact" and not draft.description.links[link].colliders:
        subject.lost(f"link {printable(link)!r} has no collider to feel contacts")
    elif kind == "force_torque" and draft.description.links[link].carrier is None:
        subject.lost(f"link {printable(link)!r} has no joint at which to measure")
    else:
        try:
            figures = gazebo_profiles.READERS[kind](values, subject)
            IMPLEMENTATIONS.all[figures.type].profile.model_validate(figures.profile)
            position, orientation = _pose(values, subject)
            pose = position, orientation if figures.turned else IDENTITY
        except UnusableError as error:
            subject.lost(error.reason, error.span)
        except ValidationError as errors:
            first = errors.errors(include_url=False, include_context=False)[0]
            where = ".".join(map(str, first["loc"]))
            subject.lost(": ".join(text for text in (where, first["msg"].removeprefix("Value error, ")) if text))
        else:
            name = _unused(prim_name(given)[:60] or kind, figures.type, taken)
            return _Found(name, link, pose, values, figures, subject, gazebo_topics.topics(figures.graph, values))
    return None


def _unused(name: str, suffix: str, taken: set[str]) -> str:
    """Return a name that is not taken: the given name, or one derived from it and the suffix."""
    if name not in taken:
        return name
    longer = f"{name}_{'sensor' if name.endswith(suffix) else suffix}"
    candidate, number = longer, 2
    while candidate in taken:
        candidate, number = f"{longer}_{number}", number + 1
    return candidate


def _pose(values: Values, sensor: Subject) -> Pose:
    """Return the pose of a sensor on its link; Gazebo classic adds the pose of `<camera>`, Gazebo Sim does not.

    Raises:
        UnusableError: a pose is not six numbers, or too far away.
    """
    pose = _one_pose(values, sensor, "pose")
    return pose if values.find("topic") is not None else compose(pose, _one_pose(values, sensor, "camera", "pose"))


def _one_pose(values: Values, sensor: Subject, *path: str) -> Pose:
    text, element = values.text(*path), values.find(*path)
    if element is None or not text:
        return NOWHERE
    given = numbers(text, 6)
    if given is None or max(map(abs, given)) > MAX_DISTANCE:
        raise UnusableError(f"pose {printable(text[:60])!r} is not six valid numbers in m and rad", element.span)
    if other := element.get("relative_to") or element.get("frame"):
        sensor.lost(f"pose relative to {printable(other[:60])!r}; taken as relative to its link", element.span)
    x, y, z, roll, pitch, yaw = given
    return (x, y, z), from_rpy(roll, pitch, yaw)


def _mount(draft: Draft, sensor: _Found) -> None:
    value: SensorKeys = {"type": sensor.figures.type, "parent": _prim(draft.description, sensor.link)}
    position, orientation = sensor.pose
    if any(position):
        value["position"] = list(position)
    if not _close(orientation, IDENTITY):
        value["orientation"] = {"quaternion_xyzw": [round(part, 9) for part in orientation]}
    if sensor.figures.profile:
        value["profile"] = sensor.figures.profile
    draft.sensors[sensor.name] = Entry(value)


def _publish(draft: Draft, sensor: _Found, *, alone: bool) -> None:
    """Add a graph that publishes a sensor; if the frame of its messages is not a link, also a graph that publishes the frame.

    `alone` is True if no other sensor without topics uses the same graph; else the sensor's name is put before default topics.
    """
    figures, kind = sensor.figures, sensor.figures.type
    device: Device = DEVICES.all[kind]
    path = "/".join(part for part in (_path(draft.description, sensor.link), sensor.name, device.child) if part)
    names, customary = sensor.topics, gazebo_topics.customary(figures.graph)
    if not names:
        owner = gazebo_topics.legal(sensor.subject.name)
        names = customary if alone else {name: f"{owner}/{topic}" for name, topic in customary.items()}
        below = "" if alone else ", below its name"
        sensor.subject.guessed(f"no topic: published on {', '.join(customary.values())}{below}")
    use = f"graphs/publishers/{figures.graph}.yaml"
    declared = graph_defaults(use)
    parameters: dict[str, Any] = {kind if kind in declared else "sensor": path, **names}
    if "frame" in declared:
        parameters["frame"] = _frame(draft, sensor)
    if "width" in declared:
        parameters |= dict(zip(("width", "height"), figures.profile["size"], strict=True))
    graph = _use(draft, sensor.name, use, parameters)
    rate = f" at {figures.profile['rate']:g} Hz" if "rate" in figures.profile else ""
    text = f"{figures.told} on {printable(sensor.link)}{rate}, published on {', '.join(names.values())}"
    claim: Claim = {
        ("sensors", sensor.name, "profile"): figures.profile or None,
        ("graphs", graph, "parameters"): parameters,
    }
    sensor.subject.carried(text, claim)


def _use(draft: Draft, name: str, graph: str, parameters: dict[str, Any]) -> str:
    """Add a graph, and return its name in the robot file."""
    name = _unused(name, "graph", set(draft.graphs))
    draft.graphs[name] = Entry({"use": graph, "parameters": parameters})
    return name


def _frame(draft: Draft, sensor: _Found) -> str:
    """Return the frame of a sensor's messages; if this frame is not a link, add a graph that publishes it on tf_static."""
    links, link = draft.description.links, sensor.link
    if sensor.figures.profile.get("axes") == "parent" and (joint := links[link].carrier) is not None:
        return joint.parent
    written = gazebo_topics.frame(sensor.values)
    camera = sensor.figures.type == "camera"
    if written in links and not (camera and written == link):
        return written
    pose = compose(sensor.pose, ((0.0, 0.0, 0.0), _OPTICAL)) if camera else sensor.pose
    if camera and (optical := _optical_link(draft.description, link, pose)):
        sensor.subject.guessed(f"its images are in the frame {printable(optical)}, whose z axis points forward")
        return optical
    if not camera and not written and _same(pose, NOWHERE):
        return link
    name = written if written and written != link else f"{sensor.name}_{'optical_frame' if camera else 'frame'}"
    position, orientation = ([round(part, 9) for part in parts] for parts in pose)
    parameters: dict[str, Any] = {"parent": link, "child": name} | ({"position": position} if any(position) else {})
    parameters |= {"orientation": orientation} if not _close(pose[1], IDENTITY) else {}
    sensor.subject.guessed(f"its frame {name} is not a link: a graph publishes it on tf_static")
    _use(draft, f"{sensor.name}_frame", "graphs/publishers/frame.yaml", parameters)
    return name


def _optical_link(description: RobotDescription, link: str, pose: Pose) -> str:
    """Return the name of a link that is rigidly connected to the given link and has the given pose relative to it.

    Return an empty string if there is none.
    """
    pending: list[tuple[str, str, Pose]] = [(link, "", NOWHERE)]
    while pending:
        at, came_from, place = pending.pop()
        if at != link and _same(place, pose):
            return at
        carrier = description.links[at].carrier
        if carrier is not None and not carrier.moves and carrier.parent != came_from:
            pending.append((carrier.parent, at, compose(place, relative(carrier.pose, NOWHERE))))
        fixed = [joint for joint in description.links[at].below if not joint.moves and joint.child != came_from]
        pending += [(joint.child, at, compose(place, joint.pose)) for joint in reversed(fixed)]
    return ""


def _prim(description: RobotDescription, link: str) -> str:
    """Return the prim of a link for a robot file: the prim name, or the path if a joint has the same prim name."""
    name = prim_name(link)
    return _path(description, link) if name in map(prim_name, description.joints) else name


def _path(description: RobotDescription, link: str) -> str:
    """Return the path of a link's prim from the root link."""
    names = [link, *(carrier.parent for carrier in description.carriers(link))]
    return "/".join(map(prim_name, reversed(names)))


def _same(first: Pose, second: Pose) -> bool:
    apart = max(abs(a - b) for a, b in zip(first[0], second[0], strict=True))
    return apart < _SAME and _close(first[1], second[1])


def _close(first: tuple[float, ...], second: tuple[float, ...]) -> bool:
    """Return whether two quaternions are nearly the same rotation; both signs of a quaternion are equal."""
    return abs(sum(a * b for a, b in zip(first, second, strict=True))) > 1.0 - _SAME**2
