"""ROS2SubscribeTwist against peers on the network, who publish Twist or TwistStamped."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
from tests.ros.contract import FAITHFUL, Join
from tests.waiting import eventually

GRAPH = """
graph: drive
nodes:
  Tick: OnPlaybackTick
  Twist: {type: SubscribeTwist, inputs: {timeout: 0.5}}
connections: [Tick.tick -> Twist.execIn]
"""
STILL = (0.0, 0.0, 0.0)


@pytest.fixture(params=["memory", *FAITHFUL])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_a_subscription_follows_the_published_type_and_notices_silence_in_simulation_time(
    join: Join, domain_id: int, tmp_path: Path
) -> None:
    path = tmp_path / "drive.yaml"
    path.write_text(GRAPH)
    assembly, complaints = build.load(path), list[str]()
    session = build.start(assembly, LiveNetwork(lambda _: join("alice"), domain_id, complaints.append))
    node: Any = session.graphs[0].executor.node("Twist")
    still = messages.Vector3(*STILL)
    for speed, stamped in enumerate((True, False, True), 1):
        twist = messages.Twist(messages.Vector3(float(speed), 0.0, 0.0), still)
        message = messages.TwistStamped(messages.header(1e6, "map"), twist) if stamped else twist
        peer = join(f"bob_{speed}")  # in one process, a topic of Fast DDS keeps its type
        writer = peer.writer("/cmd_vel", messages.message_type(message), QoS())
        data = messages.encode(message)

        def is_driven(speed: int = speed, write: Callable[[bytes], None] = writer.write, data: bytes = data) -> bool:
            write(data)
            session.step()
            return bool(node.linear_velocity == (speed, 0.0, 0.0))

        assert eventually(is_driven), speed
        writer.close()
        if not isinstance(peer, MemoryTransport):
            peer.close()
        half_a_second = partial(session.step, 30)  # of simulation
        assert eventually(lambda: node.linear_velocity == STILL, half_a_second), speed
    session.close()
    assert complaints == []
