"""Makes a Foxglove layout for the topics of a scene: a 3D view, camera images, a plot of speeds, and drive buttons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from graphengine.messages.endpoints import EndpointClaim

MOST = 4
"""Maximum number of panels of the same type."""
SPEED, TURN, RATE = 0.5, 0.5, 10.0
"""Forward speed (m/s), turn rate (rad/s) and publishing rate (Hz) of the drive buttons."""

_IN_SPACE = frozenset(
    f"{package}/msg/{name}"
    for package, names in {
        "geometry_msgs": ("PointStamped", "PolygonStamped", "PoseArray", "PoseStamped", "PoseWithCovarianceStamped"),
        "nav_msgs": ("GridCells", "OccupancyGrid", "Odometry", "Path"),
        "sensor_msgs": ("LaserScan", "NavSatFix", "PointCloud2", "Range"),
        "visualization_msgs": ("Marker", "MarkerArray"),
    }.items()
    for name in names
)
"""Message types that the 3D panel draws in addition to transforms."""
_PICTURES = frozenset({"sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"})
_CALIBRATION, _ODOMETRY, _TWIST = "sensor_msgs/msg/CameraInfo", "nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist"
_DESCRIPTION = "/robot_description"
"""Suffix of the name of a topic on which a robot publishes its URDF."""


def foxglove_layout(claims: Iterable[EndpointClaim]) -> dict[str, Any]:
    """Return a layout for Foxglove, which imports it as a JSON file.

    Args:
        claims: topics and services of a scene, in any order.
    """
    ordered = sorted(claims, key=lambda claim: (claim.topic, claim.node))
    published = [claim for claim in ordered if claim.direction == "publish"]
    driven = [
        claim.topic
        for claim in ordered
        if claim.direction == "subscribe" and _TWIST in (claim.message_type, *claim.alternatives)
    ]
    beside = {
        **{f"Image!{number}": panel for number, panel in enumerate(_pictures(published)[:MOST])},
        **{f"Plot!{number}": panel for number, panel in enumerate(_speeds(published))},
        **{f"Teleop!{number}": _buttons(topic) for number, topic in enumerate(_unique(driven)[:MOST])},
    }
    return {
        "configById": {"3D!scene": _space(published), **beside},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("row", "3D!scene", _stack([*beside]), 65.0) if beside else "3D!scene",
    }


def _space(published: Sequence[EndpointClaim]) -> dict[str, Any]:
    """Return a 3D panel with a grid, published URDFs and topics with 3D data; the camera follows the root frame."""
    parents = _unique(parent for claim in published for parent, _ in claim.transforms)
    children = {child for claim in published for _, child in claim.transforms}
    roots = [parent for parent in parents if parent not in children]
    layers = {"grid": {"layerId": "foxglove.Grid", "instanceId": "grid", "label": "Grid", "visible": True}}
    for topic in _unique(claim.topic for claim in published if claim.topic.endswith(_DESCRIPTION)):
        name = topic.removesuffix(_DESCRIPTION).strip("/") or "robot"
        urdf = {"layerId": "foxglove.RobotDescription", "instanceId": topic, "label": name, "visible": True}
        layers[topic] = {**urdf, "sourceType": "topic", "topic": topic}
    drawn = _unique(claim.topic for claim in published if claim.message_type in _IN_SPACE)
    frame = {"followTf": roots[0]} if roots else {}
    return {**frame, "layers": layers, "topics": {topic: {"visible": True} for topic in drawn}}


def _pictures(published: Sequence[EndpointClaim]) -> list[dict[str, Any]]:
    """Return an image panel for each image topic; the CameraInfo topic in the same namespace gives the calibration."""
    calibrations = {_folder(claim.topic): claim.topic for claim in published if claim.message_type == _CALIBRATION}
    topics = _unique(claim.topic for claim in published if claim.message_type in _PICTURES)
    modes = [{"imageTopic": topic, "calibrationTopic": calibrations.get(_folder(topic))} for topic in topics]
    return [{"imageMode": {key: value for key, value in mode.items() if value}} for mode in modes]


def _speeds(published: Sequence[EndpointClaim]) -> list[dict[str, Any]]:
    """Return one plot panel with the speeds of all odometry topics over header stamps; empty without odometry topics."""
    topics = _unique(claim.topic for claim in published if claim.message_type == _ODOMETRY)
    fields = [f"{topic}.twist.twist.{part}" for topic in topics for part in ("linear.x", "angular.z")]
    paths = [{"value": field, "enabled": True, "timestampMethod": "headerStamp"} for field in fields]
    return [{"paths": paths}] if paths else []


def _buttons(topic: str) -> dict[str, Any]:
    """Return a teleop panel that publishes on the Twist topic of one robot."""
    return {
        "topic": topic,
        "publishRate": RATE,
        "upButton": {"field": "linear-x", "value": SPEED},
        "downButton": {"field": "linear-x", "value": -SPEED},
        "leftButton": {"field": "angular-z", "value": TURN},
        "rightButton": {"field": "angular-z", "value": -TURN},
    }


def _stack(panels: Sequence[str]) -> Any:
    """Return the layout of panels of equal height, one below the other."""
    first, *others = panels
    return _split("column", first, _stack(others), 100.0 / len(panels)) if others else first


def _split(direction: str, first: Any, second: Any, percentage: float) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percentage}


def _folder(topic: str) -> str:
    return topic.rpartition("/")[0]


def _unique(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))
