"""Suggests replacements for unavailable node types, and upgrades nodes of older versions of Isaac Sim."""

from __future__ import annotations

import json
from pathlib import Path

from graphengine.compiler.registry import Registry
from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded_graph import RecordedNode, RecordedValue

_TABLES = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
REPLACEMENTS: dict[str, str] = _TABLES["replacements"]
"""Advice for node types of Isaac Sim that graphengine does not have, by the last part of the type name."""
FAMILIES: dict[str, str] = _TABLES["families"]
"""Advice for unavailable node types that are not in `REPLACEMENTS`, by prefix of the type name."""
GONE: dict[str, str] = _TABLES["gone_ports"]
"""Ports that only older versions of Isaac Sim have, as `TYPE.port`, each with advice for the user."""
_CAMERA_HELPER = "isaacsim.ros2.bridge.ROS2CameraHelper"
_INFO_HELPER = "isaacsim.ros2.bridge.ROS2CameraInfoHelper"
_VERSIONS: dict[str, int] = _TABLES["versions"]
"""Versions of the node types of Isaac Sim 6.0.1 by registered name; types that are missing here have version 1."""

_CONTEXT = "isaacsim.ros2.bridge.ROS2Context"
_USE_DOMAIN = "inputs:useDomainIDEnvVar"


def replacement(type: str) -> str:
    """Return advice on how to replace a node of an unavailable type; empty if there is none."""
    families = (advice for prefix, advice in FAMILIES.items() if type.startswith(prefix))
    advice = REPLACEMENTS.get(type.rpartition(".")[2]) or next(families, "")
    return f"instead: {advice}" if advice else ""


def modernize(node: RecordedNode, registry: Registry, findings: Findings) -> None:
    """Convert a ROS2CameraHelper of type camera_info, which Isaac Sim before 4.5 has, to a ROS2CameraInfoHelper."""
    found, kind = registry.find(node.type), node.values.get("inputs:type")
    if found is None or found.cls.type_name != _CAMERA_HELPER or kind is None or kind.data != "camera_info":
        return
    del node.values["inputs:type"]
    node.type = _INFO_HELPER
    what = f"{node.name}: a ROS2CameraHelper of type camera_info is converted to a ROS2CameraInfoHelper"
    topic = "" if "inputs:topicName" in node.values else "its topic is camera_info, because topicName is not set"
    findings.add("N301", what, kind.span or node.span, topic)


def upgrade(node: RecordedNode, type: str, version: object, where: str, findings: Findings) -> None:
    """Upgrade a node that was saved with an old version of its type, as Isaac Sim does, and report the upgrade.

    Args:
        node: the node, whose values may be changed.
        type: current name of the node type.
        version: version of the node type in the stage.
        where: prim path of the node.
        findings: receives a note if the version is old.
    """
    current = _VERSIONS.get(type, 1)
    if not isinstance(version, int) or version >= current:
        return
    old = f"{where} was saved as version {version} of {type}, whose current version is {current}"
    if type == _CONTEXT and _USE_DOMAIN not in node.values:
        node.values[_USE_DOMAIN] = RecordedValue(False, "bool", node.span)
        findings.add("N301", f"{old}: useDomainIDEnvVar is set to false, the behaviour of the old version", node.span)
    else:
        findings.add("N301", f"{old}: check its input values, because their meaning may have changed", node.span)
