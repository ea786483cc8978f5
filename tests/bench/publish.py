"""What publishing over DDS costs, beside others who send the same message, in one run.

`python tests/bench/publish.py [TURNS]` first lets twenty robots' nodes send five topics at 60 Hz to a reader of all. The share of
a core is that of the whole process, with the threads of Cyclone DDS; it does nothing besides: no physics, no rays, no graphs.

Then it sends Odometry, LaserScan and Image in turns, in four ways: a node makes and publishes the message; it was made
beforehand, and is published; rosbags' encoder and the same DDS writer; and rclpy, which gets the message made beforehand, on the
RMW that the environment names, where it is installed. A reader in another process gets all of them. Ratios, of the processor
and of the clock, are those of the first two ways to the last. Nothing is asserted.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.devices.lidar import Scan, beam_directions
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.nodes.ros2.image import ROS2PublishImage
from graphengine.nodes.ros2.lidar import ROS2RtxLidarHelper
from graphengine.nodes.ros2.state import ROS2PublishClock, ROS2PublishJointState, ROS2PublishOdometry
from graphengine.nodes.ros2.transforms import ROS2PublishRawTransformTree
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.rcl.installation import missing
from graphengine.ros.transports.rcl.rcl import RclTransport
from graphengine.ros.transports.rcl.rcl_profiles import ros_class

DOMAIN = Domain(86, "LOCALHOST")
BEAMS = 2751
BURSTS = {"Odometry": 5, "LaserScan": 5, "Image": 1}
"""Messages that are sent one after another, as in a tick: the first finds cold caches and a reader that sleeps."""
PAUSE = 0.008  # s, in which the reader takes what was sent
BALLAST = np.zeros(1_000_000)
"""The rest of a tick: a millisecond's work over more memory than nearby caches hold, from which on the core is awake."""
BARS = {"Odometry": 0.7, "LaserScan": 0.7, "Image": 1.0}
ROBOTS, RATE, STRETCH = 20, 60, 10.0  # Hz, s
TURNED = (0.0, 0.0, 0.6, 0.8)  # (x, y, z, w)
Send = Callable[[], object]


class Room:
    """What a lidar's helper asks of a lidar: a SICK microScan3 in a room, due at any time."""

    prim_path, due, index, rate = "/bench/lidar", True, 0, 20.0
    angles, ranges = (-2.4, 2.4, 4.8 / (BEAMS - 1)), (0.05, 9.0)

    def __init__(self) -> None:
        self.seen = np.linspace(0.5, 9.0, BEAMS, dtype=np.float32), np.full(BEAMS, 200.0, np.float32)
        self.cast(0.0)

    def cast(self, time: float) -> None:
        """See the walls at that time."""
        self.sample = Scan(time, 0, *self.seen, beam_directions(self.angles, np.zeros(1)))

    def scan(self) -> Scan:
        """What was seen last."""
        return self.sample


def odometry() -> ROS2PublishOdometry:
    """A robot on its way."""
    return ROS2PublishOdometry(
        position=(1.0, 2.0, 0.0), orientation=TURNED, linear_velocity=(0.5, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.1)
    )


def laser_scan() -> Any:
    """The node that publishes a lidar, with all of its beams."""
    node: Any = ROS2RtxLidarHelper(render_product_path=Room.prim_path, selected_metadata=())
    node.lidar, node.level = Room(), None
    return node


def image() -> ROS2PublishImage:
    """A colour camera's picture."""
    pixels = np.arange(640 * 480 * 3).astype(np.uint8)
    return ROS2PublishImage(width=640, height=480, encoding="rgb8", data=pixels)


def transform() -> ROS2PublishRawTransformTree:
    """odom -> base_link."""
    return ROS2PublishRawTransformTree(translation=(1.0, 2.0, 0.0), rotation_in=TURNED)


def joint_state() -> ROS2PublishJointState:
    """Two wheels."""
    names, values = ("front_left_wheel_joint", "front_right_wheel_joint"), np.array([0.1, 0.2])
    return ROS2PublishJointState(
        target_prim=(),
        joint_names=names,
        joint_positions=values,
        joint_velocities=values,
        joint_efforts=values,
        joint_dof_types=np.zeros(2, np.uint8),
        stage_meters_per_unit=1.0,
    )


CASES: dict[str, Callable[[], Any]] = {"Odometry": odometry, "LaserScan": laser_scan, "Image": image}
FLEET = {"odom": odometry, "tf": transform, "joint_states": joint_state, "scan": laser_scan}


def connect(network: LiveNetwork, node: Any, topic: str) -> EndpointClaim:
    """Give a node its endpoint."""
    kind = "sensor_msgs/msg/LaserScan" if isinstance(node, ROS2RtxLidarHelper) else node.message_type
    claim = EndpointClaim("bench", "bench", topic, kind, "publish", QoS())
    node.publisher = network.publisher(claim)
    return claim


def set_time(node: Any, time: float) -> None:
    """What a tick does before a node's turn comes: the clock, and a lidar's rays."""
    if hasattr(node, "lidar"):
        node.lidar.cast(time)
    else:
        node.time_stamp = time


def publish(node: Any) -> None:
    """A node's turn."""
    if isinstance(node, ROS2RtxLidarHelper):
        node.update()
    else:
        node.compute()


class Recorder:
    """A sink, for which messages are made that nobody reads; it keeps the last one."""

    def __init__(self) -> None:
        self.last: dict[str, bytes] = {}

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Take one."""
        self.last[claim.topic] = data

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Nothing is read."""


def keep_to(core: int) -> None:
    """Let this thread, and those that it begins, run on one core: a reader that is woken else stops the writer that woke it."""
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[core]})


def join(name: str) -> Transport:
    """What the reader reads with: rclpy where it is installed."""
    return DdsTransport(JoinOptions(DOMAIN, name)) if missing() else RclTransport(JoinOptions(DOMAIN, name))


def read_everything(topics: Sequence[str]) -> None:
    """The other process: reads each `topic=type` until its input ends."""
    keep_to(-1)
    transport: Transport = DdsTransport(JoinOptions(DOMAIN, "reader")) if topics[0] == "dds" else join("reader")
    for entry in topics[1:]:
        topic, message_type = entry.split("=")
        transport.reader(topic, message_type, QoS(), lambda data: None)
    print("ready", flush=True)
    sys.stdin.read()
    transport.close()


@contextlib.contextmanager
def reading(how: str, topics: Sequence[str], matched: Callable[[], bool]) -> Iterator[None]:
    """A process reads topics."""
    command = [sys.executable, __file__, "--read", how, *topics]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdout.readline()
    deadline = time.monotonic() + 20
    while not matched():
        if time.monotonic() > deadline:
            raise SystemExit("the reader was not found")
        time.sleep(0.05)
    time.sleep(0.5)
    try:
        yield
    finally:
        process.stdin.close()
        process.wait()


def compare(turns: int) -> None:
    """The ways in turns, without a reader and with one."""
    network = LiveNetwork(lambda _: DdsTransport(JoinOptions(DOMAIN, "ours")), DOMAIN.id, print)
    theirs = None if missing() else RclTransport(JoinOptions(DOMAIN, "theirs"))
    keep_to(0)
    print(
        f"us of processor and clock for a message, medians of {turns}; {theirs.description if theirs else 'no rclpy'}"
    )
    for reader in (False, True):
        for name, make in CASES.items():
            node = make()
            sides, topics, matched = ways(network, theirs, name, node)
            network.sinks = [] if reader else [Recorder()]
            with reading("best", topics, matched) if reader else contextlib.nullcontext():
                report(name, "one reader" if reader else "no reader", measure(node, sides, turns, BURSTS[name]))
    if theirs is not None:
        theirs.close()
    network.close()


def ways(
    network: LiveNetwork, theirs: RclTransport | None, name: str, node: Any
) -> tuple[dict[str, Send], list[str], Callable[[], bool]]:
    """How to send a message in each way; what a reader is to read; whether it is there."""
    claim, recorder = connect(network, node, f"/ours/{name}"), Recorder()
    kind, transport = claim.message_type, network.transport(0)
    network.sinks.append(recorder)

    def ours() -> None:
        publish(node)
        network.flush()

    def made_beforehand() -> None:
        publisher.publish(message)
        network.flush()

    ours()
    network.sinks.clear()
    data = recorder.last[claim.topic]
    message, store = messages.decode(data, kind), DEFINITIONS.store
    publisher = network.publisher(replace(claim, topic=f"/message/{name}"))
    writer = transport.writer(f"/rosbags/{name}", kind, QoS())
    sides: dict[str, Send] = {
        "node": ours,
        "message": made_beforehand,
        "rosbags": lambda: writer.write(bytes(store.serialize_cdr(message, kind))),
    }
    ends = [node.publisher._end, publisher._end, writer]
    if theirs is not None:
        from rclpy.serialization import deserialize_message

        foreign = theirs.writer(f"/rclpy/{name}", kind, QoS())
        built = deserialize_message(data, ros_class(kind, service=False))
        sides["rclpy"] = lambda: foreign.entity.publish(built)
        ends.append(foreign)
    return sides, [f"{end.topic}={kind}" for end in ends], lambda: all(end.matched for end in ends)


def measure(node: Any, sides: dict[str, Send], turns: int, burst: int) -> dict[str, list[tuple[float, float]]]:
    """Median microseconds of processor and clock for each message of a burst; the ways take turns."""
    times: dict[str, list[list[tuple[float, float]]]] = {name: [] for name in sides}
    for turn in range(turns):
        set_time(node, turn / RATE)
        for name, send in sides.items():
            time.sleep(PAUSE)
            BALLAST.sum()
            times[name].append([timed(send) for _ in range(burst)])
    return {name: [medians(column) for column in zip(*bursts, strict=True)] for name, bursts in times.items()}


def timed(send: Send) -> tuple[float, float]:
    """Seconds of this thread and of the clock."""
    start, cpu = time.perf_counter(), time.thread_time()
    send()
    return time.thread_time() - cpu, time.perf_counter() - start


def medians(times: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """In microseconds."""
    cpu, wall = (1e6 * statistics.median(column) for column in zip(*times, strict=True))
    return cpu, wall


def report(name: str, reader: str, found: dict[str, list[tuple[float, float]]]) -> None:
    """A line for the first message of a burst, and one for the last."""
    *_, reference = found
    for title, index in (("first", 0), ("last", -1))[: len(found[reference])]:
        ways = "".join(
            f"   {way} {cpu:4.0f} {wall:4.0f}" for way, (cpu, wall) in ((w, t[index]) for w, t in found.items())
        )
        cpu, wall = found[reference][index]
        ratios = [f"{found[way][index][0] / cpu:.2f} {found[way][index][1] / wall:.2f}" for way in ("node", "message")]
        print(f"  {name:9} {reader:10} {title:5}{ways}   ratios {', '.join(ratios)} (bar {BARS[name]})", flush=True)


def fleet() -> None:
    """Twenty robots' topics at 60 Hz: all that this process uses of the processor, which does nothing besides."""
    network = LiveNetwork(lambda _: DdsTransport(JoinOptions(DOMAIN, "fleet")), DOMAIN.id, print)
    every: list[Any] = [ROS2PublishClock()]
    claims = [connect(network, every[0], "/clock")]
    for number in range(ROBOTS):
        for topic, make in FLEET.items():
            every.append(make())
            claims.append(connect(network, every[-1], f"/robot_{number:02}/{topic}"))
    topics = [f"{claim.topic}={claim.message_type}" for claim in claims]
    with reading("dds", topics, lambda: all(node.publisher.wanted for node in every)):
        for scan_every in (1, 3):
            share = paced(network, every, scan_every)
            print(f"  scans at {RATE / scan_every:g} Hz: {100 * share:.1f} % of a core", flush=True)
    network.close()


def paced(network: LiveNetwork, every: Sequence[Any], scan_every: int) -> float:
    """Processor time of the process for a second of the clock, at 60 ticks a second."""
    start, cpu = time.perf_counter(), time.process_time()
    for tick in range(round(STRETCH * RATE)):
        for node in every:
            if tick % scan_every == 0 or not isinstance(node, ROS2RtxLidarHelper):
                set_time(node, tick / RATE)
                publish(node)
        network.flush()
        time.sleep(max(0.0, start + (tick + 1) / RATE - time.perf_counter()))
    return (time.process_time() - cpu) / (time.perf_counter() - start)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--read"]:
        read_everything(sys.argv[2:])
    else:
        print(f"{ROBOTS} robots' five topics at {RATE} Hz, one reader of all (bar 25 %)")
        fleet()
        compare(int(sys.argv[1]) if sys.argv[1:] else 200)
