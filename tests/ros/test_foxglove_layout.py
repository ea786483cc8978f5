"""The layout for Foxglove that the topics of a scene make."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from foxglove import layouts

from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros.foxglove.foxglove_layout import MOST, foxglove_layout
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def layout_of(scene: str, **options: Any) -> dict[str, Any]:
    return foxglove_layout(build.load(SCENES / f"{scene}.yaml", Options(**options)).claims)


def claim(topic: str, kind: str, direction: str = "publish", **facts: Any) -> EndpointClaim:
    return EndpointClaim("/node", "graph", topic, kind, direction, QoS(), **facts)


def panels(node: Any) -> Iterator[str]:
    """Names of the panels in a layout, in order."""
    if isinstance(node, str):
        yield node
    else:
        yield from panels(node["first"])
        yield from panels(node["second"])


def test_a_scene_with_a_robot_has_a_3d_view_its_speeds_and_buttons() -> None:
    layout = layout_of("dd100_warehouse", robot_state=True)
    configs = layout["configById"]
    assert [*panels(layout["layout"])] == [*configs] == ["3D!scene", "Plot!0", "Teleop!0"]
    space = configs["3D!scene"]
    assert space["followTf"] == "odom"
    assert space["topics"] == {"/dd100_0000/odom": {"visible": True}, "/dd100_0000/sim_lidar/scan": {"visible": True}}
    assert space["layers"]["/dd100_0000/robot_description"]["label"] == "dd100_0000"
    assert configs["Teleop!0"]["topic"] == "/dd100_0000/cmd_vel"
    assert [path["value"] for path in configs["Plot!0"]["paths"]] == [
        "/dd100_0000/odom.twist.twist.linear.x",
        "/dd100_0000/odom.twist.twist.angular.z",
    ]


def test_each_camera_has_a_panel_up_to_a_maximum() -> None:
    image, info = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
    claims = [claim(f"/cam{number}/rgb", image) for number in range(MOST + 1)]
    configs = foxglove_layout([*claims, claim("/cam0/camera_info", info)])["configById"]
    assert [*configs] == ["3D!scene", *(f"Image!{number}" for number in range(MOST))]
    assert configs["Image!0"] == {"imageMode": {"imageTopic": "/cam0/rgb", "calibrationTopic": "/cam0/camera_info"}}
    assert configs["Image!1"] == {"imageMode": {"imageTopic": "/cam1/rgb"}}


def test_a_robot_with_stamped_or_plain_twists_has_buttons() -> None:
    stamped, plain = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"
    claims = [
        claim("/a/cmd_vel", stamped, "subscribe", alternatives=(plain,)),
        claim("/b/cmd_vel", stamped, "subscribe"),
        claim("/c/cmd_vel", plain, "publish"),
    ]
    assert [*foxglove_layout(claims)["configById"]] == ["3D!scene", "Teleop!0"]


def test_a_scene_without_topics_has_only_a_3d_view() -> None:
    layout = foxglove_layout([])
    assert layout["layout"] == "3D!scene"
    assert "followTf" not in layout["configById"]["3D!scene"]


def test_the_order_of_topics_does_not_matter() -> None:
    claims = build.load(SCENES / "tutorial" / "navigation.yaml", Options()).claims
    assert json.dumps(foxglove_layout(claims)) == json.dumps(foxglove_layout(claims[::-1]))


@pytest.mark.parametrize(
    ("panel", "config"),
    [
        ("3D", layouts.ThreeDeeConfig()),
        ("Image", layouts.ImageConfig()),
        ("Plot", layouts.PlotConfig()),
        ("Teleop", layouts.TeleopConfig()),
    ],
)
def test_panels_have_settings_that_foxglove_knows(panel: str, config: Any) -> None:
    camera = claim("/cam/rgb", "sensor_msgs/msg/Image")
    claims = [*build.load(SCENES / "dd100_warehouse.yaml", Options(robot_state=True)).claims, camera]
    used = {key for name, one in foxglove_layout(claims)["configById"].items() if name.startswith(panel) for key in one}
    assert used
    assert used <= config._to_dict().keys()
