"""The transforms of a run in a buffer of tf2 that follows /clock: both shapes of the tree, and jumps of the time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from tests.ros import needs
from tests.waiting import eventually

pytestmark = pytest.mark.ros(needs.module("tf2_ros"))

SCENE = """scene: shared
world: worlds/flat_grid.xml
tf: global
robots:
  bot: {use: robots/dd100.yaml, count: 2, per_row: 2, spacing: [3, 3], position: [0, 0, 0.025]}
graphs:
  clock: {use: graphs/clock.yaml, at: /World/clock}
"""


@pytest.fixture
def buffer(domain_id: int) -> Iterator[Any]:
    """A tf2 buffer of a node with use_sim_time, filled by a listener that another thread spins."""
    tf2_ros = import_module("tf2_ros")
    rclpy, parameter = import_module("rclpy"), import_module("rclpy.parameter").Parameter
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    simulated = [parameter("use_sim_time", parameter.Type.BOOL, True)]
    node = rclpy.create_node("listener", context=context, parameter_overrides=simulated)
    executor = import_module("rclpy.executors").SingleThreadedExecutor(context=context)
    executor.add_node(node)
    made = tf2_ros.Buffer(node=node)
    listener = tf2_ros.TransformListener(made, node)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    try:
        yield made
    finally:
        executor.shutdown()
        rclpy.shutdown(context=context)
        spinning.join()
        listener.unregister()


@pytest.mark.parametrize("transport", ["dds", "rclpy"])
def test_after_a_reset_tf2_has_only_static_transforms(
    tmp_path: Path, domain_id: int, buffer: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))  # which graphs read
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    latest = import_module("rclpy.time").Time()

    def stamp(robot: str) -> float:
        """Time of the newest transform of a robot's base, s; -1 without one."""
        if not buffer.can_transform(f"{robot}/odom", f"{robot}/base_link", latest):
            return -1.0
        at = buffer.lookup_transform(f"{robot}/odom", f"{robot}/base_link", latest).header.stamp
        return float(at.sec + at.nanosec * 1e-9)

    scene = ge.load(tmp_path / "scene.yaml")
    robots = ("bot_0000", "bot_0001")
    with scene.session(transport=transport, domain=domain_id) as sim:
        sim.run(2.5)
        # Each transform has arrived: one that tf2 takes after the jump would stay, as topics have no common order.
        assert eventually(lambda: all(stamp(robot) >= 2.5 - 1e-6 for robot in robots))
        assert all(buffer.can_transform(f"{robot}/base_link", f"{robot}/sim_lidar", latest) for robot in robots)
        kept = sim.checkpoint()
        sim.reset()
        assert eventually(lambda: all(stamp(robot) == -1.0 for robot in robots))
        assert all(buffer.can_transform(f"{robot}/base_link", f"{robot}/sim_lidar", latest) for robot in robots)
        sim.run(0.3)
        assert eventually(lambda: all(0.0 < stamp(robot) < 0.5 for robot in robots))
        assert all(buffer.can_transform(f"{robot}/odom", f"{robot}/sim_lidar", latest) for robot in robots)
        sim.restore(kept)
        sim.run(0.1)
        assert eventually(lambda: all(stamp(robot) > 2.5 for robot in robots))
        assert all(buffer.can_transform(f"{robot}/odom", f"{robot}/sim_lidar", latest) for robot in robots)
