"""What robots cost by their number, each with all its graphs and a lidar of 2751 beams at 20 Hz, in the full warehouse.

`python tests/bench/fleet.py [SECONDS]` runs 1, 5, 10, 20 and 50 robots that drive in circles, over memory, with a reader on every
topic, once for each way to cast rays. It prints real-time factors and what a robot costs as a ratio to what one alone costs, both
in the same run; nothing is asserted.
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
import time
from pathlib import Path

from graphengine.format.distribution import install_command
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

NUMBERS = (1, 5, 10, 20, 50)
SCENE = """scene: fleet
world: worlds/full_warehouse.xml
settle: true
robots:
  dd100: {{use: robots/dd100.yaml, count: {count}, per_row: 13, spacing: [1.2, 1.2], position: [-25.0, -12.6, 0.025]}}
graphs:
  clock: {{use: graphs/clock.yaml, at: /World/clock}}
"""
CIRCLE = messages.Twist(messages.Vector3(0.2, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.8))
WARM_UP = 1.0  # s of simulation


def ignore(_: bytes) -> None:
    """Read a message."""


def run(folder: Path, count: int, rays: RaysChoice, seconds: float) -> tuple[float, int]:
    """Wall time for a second of simulation, and how many messages were sent in all."""
    path = folder / f"fleet_{count}.yaml"
    path.write_text(SCENE.format(count=count), encoding="utf-8")
    transport = MemoryTransport()
    overrides = {"SubscribeTwist.timeout": 0.0}
    assembly = build.load(path, Options(overrides, rays=rays))
    network = LiveNetwork(lambda _: transport, 0, print)
    with build.start(assembly, network) as session:
        for claim in assembly.claims:
            if claim.direction == "publish":
                transport.reader(claim.topic, claim.message_type, QoS(), ignore)
            elif claim.message_type == "geometry_msgs/msg/Twist":
                transport.inject(claim.topic, CIRCLE)
        session.run(WARM_UP)
        start = time.perf_counter()
        session.run(seconds)
        return (time.perf_counter() - start) / seconds, network.sent


def main() -> None:
    """Print one line for each number of robots."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    ways: list[RaysChoice] = ["mujoco"] if importlib.util.find_spec("numba") is None else ["fast", "mujoco"]
    if len(ways) == 1:
        print(f"numba is not installed: {install_command('fast')}")
    with tempfile.TemporaryDirectory() as folder:
        for rays in ways:
            alone = 0.0
            for count in NUMBERS:
                wall, sent = run(Path(folder), count, rays, seconds)
                each = wall / count
                alone = alone or each
                print(
                    f"rays {rays:6}  {count:2} robots: real time x{1 / wall:6.2f}   {each * 1e3:6.2f} ms a robot and second, "
                    f"x{each / alone:4.2f} of one alone   {sent} messages",
                    flush=True,
                )


if __name__ == "__main__":
    main()
