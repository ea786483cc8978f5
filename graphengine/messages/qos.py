"""QoS profiles: presets, conversion from and to JSON, actual values of "system default", and compatibility."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any, get_args, get_type_hints

from graphengine.format import bounded_json
from graphengine.format.errors import TopicError
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.endpoints import QoS

LATCHED = QoS(depth=1, durability="transientLocal")
"""Profile of latched topics, such as those of nodes with `staticPublisher`: a late subscriber gets the last message."""
ROSOUT = QoS(depth=1000, durability="transientLocal", lifespan=10.0)
"""Profile of the log topic `/rosout`."""
PARAMETER_EVENTS = QoS(depth=1000)
"""Profile of the topic `/parameter_events`."""

PRESETS: Mapping[str, QoS] = {
    "Default for publishers/subscribers": QoS(),
    "Services": QoS(),
    "Sensor Data": QoS(depth=5, reliability="bestEffort"),
    "System Default": QoS("systemDefault", 0, "systemDefault", "systemDefault"),
}
"""A dict from preset names of ROS2QoSProfile to profiles; without `Custom`, which has no fixed profile."""

_SYSTEM_DEFAULT = QoS(liveliness="automatic")
"""Values that replace the policy `systemDefault`, the same as in `rmw_cyclonedds_cpp`."""
_MAX_DEPTH = 2**31 - 1
"""Maximum depth of a queue in a QoS profile."""
_KEYS = {"lease_duration": "leaseDuration"}
_FIELDS: dict[str, str] = {_KEYS.get(field.name, field.name): field.name for field in fields(QoS)}
_CHOICES = {name: legal for name, kind in get_type_hints(QoS).items() if (legal := get_args(kind))}
"""A dict from each policy that is not a number to its legal values."""


def parse_qos(qos_profile: str, queue_size: int = 10, latched: bool = False) -> QoS:
    """Return the QoS that the inputs of a node specify.

    Args:
        qos_profile: JSON text from a ROS2QoSProfile.
        queue_size: history depth if `qos_profile` is empty; the other policies then have their defaults.
        latched: if true, the other arguments are ignored and LATCHED is returned.

    Raises:
        TopicError: the text is not a legal profile.
    """
    if latched:
        return LATCHED
    if not qos_profile.strip():
        return QoS(depth=_depth(queue_size, "queue size", queue_size))
    try:
        profile = bounded_json.parse(qos_profile)
    except ValueError as error:
        legal = _preset_advice(qos_profile) or f"keys: {', '.join(_FIELDS)}"
        raise TopicError(f"QoS profile is not JSON: {error}", qos_profile, legal) from None
    if not isinstance(profile, dict):
        raise TopicError("QoS profile is not a JSON object", qos_profile, f"keys: {', '.join(_FIELDS)}")
    values: dict[str, Any] = {}
    for key, value in profile.items():
        if key not in _FIELDS:
            near = did_you_mean(key, _FIELDS)
            raise TopicError(f"QoS profile has no key {key!r}", qos_profile, near, listing(_FIELDS, "keys"))
        values[_FIELDS[key]] = _value(key, value, qos_profile)
    return QoS(**values)


def _preset_advice(text: str) -> str:
    """Return advice for the preset that a text such as `SensorData` or `qos_profile_sensor_data` names, or an empty string."""
    plain = "".join(filter(str.isalnum, text.lower()))
    found = next((name for name in PRESETS if plain.endswith("".join(filter(str.isalnum, name.lower())))), "")
    return found and f"for the preset {found!r}, wire qosProfile of a ROS2QoSProfile with createProfile: {found}"


def qos_json(qos: QoS) -> str:
    """Return a profile as the JSON text that `parse_qos` reads."""
    return json.dumps({_KEYS.get(name, name): value for name, value in asdict(qos).items()})


def settled(qos: QoS) -> QoS:
    """Return a profile with actual values in place of a depth of 0 and of each policy `systemDefault`."""
    chosen = {name: getattr(_SYSTEM_DEFAULT, name) for name in _CHOICES if getattr(qos, name) == "systemDefault"}
    return replace(qos, depth=qos.depth or 1, **chosen)


def short_of(offered: QoS, requested: QoS) -> tuple[str, ...]:
    """Return the policies in which a publisher offers less than a subscription requests; each of them prevents a connection."""
    offered, requested = settled(offered), settled(requested)
    less = {
        "reliability": (offered.reliability, requested.reliability) == ("bestEffort", "reliable"),
        "durability": (offered.durability, requested.durability) == ("volatile", "transientLocal"),
        "deadline": _seconds(offered.deadline) > _seconds(requested.deadline),
        "liveliness": (offered.liveliness, requested.liveliness) == ("automatic", "manualByTopic"),
        "leaseDuration": _seconds(offered.lease_duration) > _seconds(requested.lease_duration),
    }
    return tuple(policy for policy, is_less in less.items() if is_less)


@functools.lru_cache(maxsize=1024)  # a network has few pairs of profiles, but compares them for each message
def mismatch(offered: QoS, requested: QoS, writer: str = "the writer", reader: str = "the reader") -> str:
    """Return the reason why two profiles are incompatible; empty if they are compatible.

    Args:
        offered: profile of the publisher.
        requested: profile of the subscription.
        writer: name of the publisher in the text.
        reader: name of the subscription in the text.
    """
    policies = short_of(offered, requested)
    if not policies:
        return ""
    asked, given = (" and ".join(_words(qos, policy) for policy in policies) for qos in (requested, offered))
    return f"{reader} asks for {asked}, {writer} offers {given}"


def policy_json(qos: QoS, policy: str) -> str:
    """Return one policy of a profile as JSON text, such as `"reliability": "reliable"`."""
    return f"{json.dumps(policy)}: {json.dumps(getattr(settled(qos), _FIELDS[policy]))}"


def _words(qos: QoS, policy: str) -> str:
    value = getattr(settled(qos), _FIELDS[policy])
    match policy:
        case "reliability" | "durability":
            return str(value)
        case "liveliness":
            return f"liveliness {value}"
        case _:
            what = "deadline" if policy == "deadline" else "lease"
            return f"a {what} of {value:g} s" if value else f"no {what}"


def _seconds(time: float) -> float:
    return time or math.inf


def _value(key: str, value: Any, text: str) -> Any:
    if key in _CHOICES:
        if value not in _CHOICES[key]:
            near = did_you_mean(value, _CHOICES[key]) if isinstance(value, str) else ""
            raise TopicError(f"QoS {key} cannot be {value!r}", text, near, listing(_CHOICES[key]))
        return value
    if key == "depth":
        return _depth(value, "QoS depth", text)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < math.inf:
        raise TopicError(f"QoS {key} cannot be {value!r}", text, "legal: seconds, 0 for unlimited")
    return float(value)


def _depth(value: Any, what: str, written: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MAX_DEPTH:
        raise TopicError(f"{what} cannot be {value!r}", written, f"legal: a whole number from 0 to {_MAX_DEPTH}")
    return value
