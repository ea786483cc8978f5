"""A second process of the tests: joins the domain that its environment names and tells which robots come and go."""

from __future__ import annotations

import os
import sys
import time
from functools import partial

from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport

TWIST, ODOMETRY = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry"


def tell(*words: str) -> None:
    """Say a line."""
    sys.stdout.write(f"{' '.join(words)}\n")
    sys.stdout.flush()


def look(transport: DdsTransport, robots: list[str]) -> None:
    """Tell `ROBOT listens` and `ROBOT is deaf` as its subscription comes and goes, and `ROBOT talks` at its first message."""
    talked: set[str] = set()

    def hear(robot: str, _: bytes) -> None:
        if robot not in talked:
            talked.add(robot)
            tell(robot, "talks")

    for robot in robots:
        transport.reader(f"/{robot}/odom", ODOMETRY, QoS(), partial(hear, robot))
    writers = {robot: transport.writer(f"/{robot}/cmd_vel", TWIST, QoS()) for robot in robots}
    listening = dict.fromkeys(robots, False)
    while True:
        for robot, writer in writers.items():
            if writer.matched != listening[robot]:
                listening[robot] = not listening[robot]
                tell(robot, "listens" if listening[robot] else "is deaf")
        time.sleep(0.02)


if __name__ == "__main__":
    look(DdsTransport(JoinOptions(Domain.from_environment(os.environ), "onlooker")), sys.argv[1:])
