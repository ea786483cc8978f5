"""Command-line options for the quality of service, with the names of ros2cli."""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from graphengine.cli.options import add_value
from graphengine.cli.quantities import count, seconds
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED, PARAMETER_EVENTS, PRESETS, mismatch
from graphengine.ros.network_graph import Endpoint

if TYPE_CHECKING:
    from collections.abc import Sequence

_PROFILES = {
    "default": QoS(),
    "sensor_data": PRESETS["Sensor Data"],
    "system_default": PRESETS["System Default"],
    "services_default": PRESETS["Services"],
    "parameters": QoS(depth=1000),
    "parameter_events": PARAMETER_EVENTS,
    "action_status_default": LATCHED,
}
_KINDS = {
    "history": {"keep_last": "keepLast", "keep_all": "keepAll", "system_default": "systemDefault"},
    "reliability": {"reliable": "reliable", "best_effort": "bestEffort", "system_default": "systemDefault"},
    "durability": {"volatile": "volatile", "transient_local": "transientLocal", "system_default": "systemDefault"},
    "liveliness": {"automatic": "automatic", "manual_by_topic": "manualByTopic", "system_default": "systemDefault"},
}


def add_quality_arguments(parser: argparse.ArgumentParser, default: str) -> None:
    """Add options for a named profile (`default` if not given) and for single policies, which replace those of the profile."""
    group = parser.add_argument_group("quality of service")
    group.add_argument("--qos-profile", choices=_PROFILES, default=default, help=f"named profile (default {default})")
    add_value(group, "--qos-depth", "N", "queue depth, messages (default: that of the profile)", type=count)
    for policy, kinds in _KINDS.items():
        group.add_argument(f"--qos-{policy}", choices=kinds, help=f"{policy} (default: that of the profile)")
    lease = "liveliness lease duration (default: that of the profile)"
    add_value(group, "--qos-liveliness-lease-duration-seconds", "SECONDS", lease, type=seconds)


def quality(arguments: argparse.Namespace) -> QoS:
    """Return the quality of service given on the command line."""
    given = vars(arguments)
    changes: dict[str, Any] = {policy: kinds.get(given[f"qos_{policy}"]) for policy, kinds in _KINDS.items()}
    changes["depth"] = arguments.qos_depth
    changes["lease_duration"] = arguments.qos_liveliness_lease_duration_seconds
    changes = {policy: value for policy, value in changes.items() if value is not None}
    return replace(_PROFILES[arguments.qos_profile], **changes)


def quality_for(arguments: argparse.Namespace, publishers: Sequence[Endpoint]) -> QoS:
    """Return the quality of service for a subscription: the strictest one that all publishers offer.

    If the command line sets a policy, or if there are no publishers, return the quality of service from the command line, and
    print a warning for each publisher that does not match it.
    """
    asked = quality(arguments)
    overridden = [name for name, value in vars(arguments).items() if name.startswith("qos_") and value is not None]
    if overridden != ["qos_profile"] or not publishers:
        for end in publishers:
            if why := mismatch(end.qos, asked, end.full_node or "a publisher", "this subscription"):
                print(f"WARNING: {why}: no messages arrive from it", file=sys.stderr)
        return asked
    for policy, more, less in (("reliability", "reliable", "bestEffort"), ("durability", "transientLocal", "volatile")):
        offers = [getattr(end.qos, policy) == more for end in publishers]
        if any(offers) and not all(offers):
            what = f"only some publishers offer {shouted(more)}; subscribing with {shouted(less)}, which matches all"
            print(f"WARNING: {what}", file=sys.stderr)
        changes: dict[str, Any] = {policy: more if all(offers) else less}
        asked = replace(asked, **changes)
    return asked


def shouted(kind: str) -> str:
    """Return the value of a policy as ros2cli prints it, such as `BEST_EFFORT` for `bestEffort`."""
    return "UNKNOWN" if kind == "systemDefault" else re.sub(r"(?=[A-Z])", "_", kind).upper()
