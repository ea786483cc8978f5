"""What looking at peers costs the thread of the ticks.

`python tests/bench/watch.py [SECONDS]` first ticks networks without a world, whose peers are played: 100 robots with 400 ends of
peers, the same where the peers' graph holds the robots' own ends too, and 100 publishers with 100 readers on one topic, all alike
and none of them fitting. Then it runs 100 robots in the full warehouse, over memory and over DDS with 400 readers in another
process, for so many seconds of the wall's clock each (60). It prints milliseconds a tick; nothing is asserted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean, median

from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.network_graph import Endpoint, NetworkGraph
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

ROBOTS = 100
PUBLISHED = ("odom", "scan", "joint_states", "imu", "rgb", "depth", "info", "pose", "state", "battery", "points")
TWIST, ODOMETRY = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry"
BEST_EFFORT = QoS(reliability="bestEffort")
DOMAIN = Domain(200 + os.getpid() % 30, "LOCALHOST")
SCENE = f"""scene: fleet
world: worlds/full_warehouse.xml
settle: true
robots:
  dd100: {{use: robots/dd100.yaml, count: {ROBOTS}, per_row: 13, spacing: [1.2, 1.2], position: [-25.0, -12.6, 0.025]}}
graphs:
  clock: {{use: graphs/clock.yaml, at: /World/clock}}
"""


class Played(MemoryTransport):
    """A network on which those are present who are written down, and after each look one of them is another one."""

    node = "/session"

    def __init__(self, present: Sequence[Endpoint]) -> None:
        super().__init__()
        self.present = list(present)

    def graph(self, asked: object = None) -> NetworkGraph:
        """All that are present."""
        return NetworkGraph(self.present)


def ignore(_: bytes) -> None:
    """Read a message."""


def robots() -> list[EndpointClaim]:
    """What a fleet publishes and subscribes."""
    stamped = ("geometry_msgs/msg/TwistStamped",)
    ends = [
        *((name, ODOMETRY, "publish", ()) for name in PUBLISHED),
        ("cmd_vel", TWIST, "subscribe", stamped),
        ("stop", TWIST, "subscribe", ()),
    ]
    return [
        EndpointClaim(
            f"/World/r{number}/{name}", "g", f"/r{number}/{name}", kind, direction, QoS(), alternatives=others
        )
        for number in range(ROBOTS)
        for name, kind, direction, others in ends
    ]


def described(claim: EndpointClaim, number: int, node: str) -> Endpoint:
    """A claim as an end of a node."""
    gid = number.to_bytes(16, "big")
    return Endpoint(gid, claim.direction, claim.topic, claim.message_type, claim.qos, "", node, "/")  # type: ignore[arg-type]


def opposite(claim: EndpointClaim, number: int) -> Endpoint:
    """The end of a peer for a claim."""
    direction = "subscribe" if claim.direction == "publish" else "publish"
    return described(replace(claim, direction=direction), 10_000 + number, f"peer_{number % 7}")


def play(name: str, claims: Sequence[EndpointClaim], present: Sequence[Endpoint]) -> None:
    """Tick a network without a world for a few looks."""
    network = LiveNetwork(lambda _: Played(present), 0, lambda text: None)
    for claim in claims:
        if claim.direction == "publish":
            network.publisher(claim)
        else:
            network.subscription(claim)
    timed = Timed(network.freeze)
    end = time.monotonic() + 3.0
    while time.monotonic() < end or not timed.cpu:
        timed()
        time.sleep(0.005)
    network.close()
    print(f"{name:46} {timed}", flush=True)


class Timed:
    """A function whose calls are timed."""

    def __init__(self, function: Callable[[], None]) -> None:
        self.function = function
        self.wall: list[float] = []
        """s a call, other processes and threads included."""
        self.cpu: list[float] = []
        """s of the processor a call, in the caller's thread."""

    def __call__(self) -> None:
        """Call it."""
        wall, cpu = time.perf_counter(), time.thread_time()
        self.function()
        self.cpu.append(time.thread_time() - cpu)
        self.wall.append(time.perf_counter() - wall)

    def __str__(self) -> str:
        parts = [f"mean {fmean(self.cpu) * 1e3:8.3f} ms, longest {max(self.cpu) * 1e3:9.3f} ms of the processor"]
        return ", ".join([*parts, f"longest {max(self.wall) * 1e3:9.3f} ms of the clock"])


def run(name: str, folder: Path, transport: Transport, seconds: float, peers: bool) -> None:
    """Run robots for a time, and print what part of a tick goes to looking at peers."""
    path = folder / "fleet.yaml"
    path.write_text(SCENE, encoding="utf-8")
    assembly = build.load(path, Options({"SubscribeTwist.timeout": 0.0}))
    network = LiveNetwork(lambda _: transport, 0, lambda text: None)
    follow, look = Timed(network._follow), Timed(network.look)
    network._follow, network.look = follow, look  # type: ignore[method-assign]
    with build.start(assembly, network) as session:
        topics = [claim for claim in assembly.claims if claim.direction == "publish" and claim.topic.count("/") > 1]
        listening = (
            subprocess.Popen(
                [
                    sys.executable,
                    __file__,
                    "--peers",
                    *(f"{claim.topic}={claim.message_type}" for claim in topics[: 4 * ROBOTS]),
                ],
                stdin=subprocess.PIPE,
                env={**os.environ, "DOMAIN": str(DOMAIN.id)},
            )
            if peers
            else None
        )
        tick = Timed(lambda: session.step(1))
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            tick()
        if listening is not None:
            listening.communicate()
    usual = median(tick.cpu)
    print(
        f"{name}: {ROBOTS} robots, {len(assembly.claims)} ends, "
        f"{len(tick.cpu)} ticks of {usual * 1e3:.2f} ms of the processor (median)"
    )
    for what, timed in (("looking at peers", look), ("following their types", follow)):
        mean = sum(timed.cpu) / len(tick.cpu)
        print(f"  {what:22} {timed}: {mean / usual:7.3%} of a tick, at most {max(timed.cpu) / usual:6.2%}", flush=True)


def listen(topics: Sequence[str]) -> None:
    """Read topics over DDS until the input ends."""
    transport = DdsTransport(JoinOptions(Domain(int(os.environ["DOMAIN"]), "LOCALHOST"), "rviz"))
    for topic, _, message_type in (text.partition("=") for text in topics):
        transport.reader(topic, message_type, QoS(), ignore)
    sys.stdin.read()
    transport.close()


def main() -> None:
    """Print a line for each network."""
    claims = robots()
    peers = [opposite(claim, number) for number, claim in enumerate(claims[:400])]
    own = [described(claim, number, "session") for number, claim in enumerate(claims)]
    play("100 robots, 400 ends of peers", claims, peers)
    play("100 robots, 400 ends of peers and their own", claims, own + peers)
    for name, qos in (("all fit", QoS()), ("none fits", BEST_EFFORT)):
        crowd = [
            EndpointClaim(f"/World/r{number}/odom", "g", "/odom", ODOMETRY, "publish", qos) for number in range(100)
        ]
        readers = [opposite(replace(claim, qos=QoS()), number) for number, claim in enumerate(crowd)]
        readers = [replace(reader, node=f"rviz_{number}") for number, reader in enumerate(readers)]
        play(
            f"100 x 100 on one topic, {name}",
            crowd,
            readers + [described(c, n, "session") for n, c in enumerate(crowd)],
        )
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    with tempfile.TemporaryDirectory() as folder:
        run("memory", Path(folder), MemoryTransport(wants_all=True, keeps=False), seconds, peers=False)
        run("dds", Path(folder), DdsTransport(JoinOptions(DOMAIN, "session")), seconds, peers=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peers"]:
        listen(sys.argv[2:])
    else:
        main()
