"""A scene that runs over memory and is recorded, commanded by a peer at odd times."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from graphengine.format.files import find_file
from graphengine.messages import messages
from graphengine.recording.marks import Marks
from graphengine.recording.player import RecordingPlayer
from graphengine.recording.reader import Recording
from graphengine.recording.recorder import Recorder
from graphengine.recording.replay import SilentTransport
from graphengine.recording.sources import Workspace
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import BadValues, Options
from tests.jobs import crowd
from tests.jobs.harness import Recorder as Listener
from tests.jobs.harness import twist

CMD_VEL = "/dd100_0000/cmd_vel"
DRIVE: Mapping[int, Sequence[tuple[float, float]]] = {
    7: [(0.5, 0.0)],
    12: [(0.6, 0.3), (0.6, 0.4)],
    13: [(0.7, 0.4)],
    40: [(0.2, -0.8)],
    101: [(0.0, 0.0)],
    110: [(-0.4, 0.1)],
}
"""Velocities (m/s, rad/s) by the number of the tick that sees them first."""
CLOCK = """graph: clock
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Clock: PublishClock
connections:
  - Tick.tick -> Clock.execIn
  - Time.simulationTime -> Clock.timeStamp
"""
GOODBYE = CLOCK.replace(
    "connections:\n",
    """  Stop: {type: OnStageEvent, inputs: {eventName: Simulation Stop Play}}
  Closing: OnClosing
  Stopped: {type: ROS2PublishClock, inputs: {topicName: stopped}}
  Closed: {type: ROS2PublishClock, inputs: {topicName: closed}}
connections:
  - Stop.execOut -> Stopped.execIn
  - Time.simulationTime -> Stopped.timeStamp
  - Closing.execOut -> Closed.execIn
  - Time.simulationTime -> Closed.timeStamp
""",
)
SYSTEM_CLOCK = CLOCK.replace("ReadSimulationTime", "IsaacReadSystemTime").replace("simulationTime", "systemTime")
DIVIDES = """graph: divides
nodes:
  Tick: OnPlaybackTick
  Left: {type: Subtract, inputs: {b: 5}}
  Ratio: {type: Divide, inputs: {a: 12}}
  Say: {type: ROS2Publisher, inputs: {topicName: ratio, messagePackage: std_msgs, messageName: Float64}}
connections:
  - Tick.frame -> Left.a
  - Left.difference -> Ratio.b
  - Ratio.result -> Say.data
  - Tick.tick -> Say.execIn
"""
"""Divides by `frame` - 5, which is zero in one tick."""
NOISY_ROBOT = crowd.ROBOT
NOISY_SCENE = """scene: noisy
world: worlds/full_warehouse.xml
robots:
  dd100: {use: noisy_robot.yaml, position: [-3.0, 6.0, 0.025], namespace: dd100_0000}
"""


class Run:
    """A recorded run, and what a listener heard of it."""

    def __init__(
        self, session: SessionCore, transport: MemoryTransport, recorder: Recorder, listener: Listener
    ) -> None:
        self.session = session
        self.transport = transport
        self.recorder = recorder
        self.heard = listener.stream


Before = Callable[[int, Run], object]
"""What is done before a tick, by its number."""


def at(tick: int, action: Callable[[Run], object]) -> Before:
    """Something that is done before one tick."""
    return lambda number, run: action(run) if number == tick else None


def record(
    path: Path,
    ticks: int,
    scene: str | Path = "dd100_warehouse",
    *,
    commands: Mapping[int, Sequence[tuple[float, float]]] = MappingProxyType({}),
    before: Before = lambda tick, run: None,
    options: Options | None = None,
    bad_values: BadValues = "drop",
    **how: Any,
) -> Run:
    """Record some ticks; `before` is called before each of them."""
    given = scene if isinstance(scene, Path) else find_file(scene).absolute()
    assembly = build.load(given, options)
    transport, listener = MemoryTransport(keeps=False, definitions=assembly.definitions), Listener()
    network = LiveNetwork(lambda domain: transport, 0, lambda complaint: None, assembly.definitions)
    with (
        build.start(assembly, network, bad_values=bad_values) as session,
        Recorder(session, network, assembly, path, **how) as recorder,
    ):
        network.sinks.append(listener)
        run = Run(session, transport, recorder, listener)
        for tick in range(1, ticks + 1):
            for v, w in commands.get(tick, ()):
                transport.inject(CMD_VEL, twist(v, w))
            before(tick, run)
            session.step()
    return run


@contextmanager
def playing(path: Path, options: Options | None = None) -> Iterator[RecordingPlayer]:
    """A player of a recording, of which nothing is built yet."""
    with tempfile.TemporaryDirectory() as folder:
        recording, marks = Recording(path, Workspace(Path(folder))), Marks()
        manifest, files = recording.manifest, recording.workspace
        own = replace(
            options or Options(),
            overrides=manifest.overrides,
            seed=manifest.seed,
            robot_state=manifest.robot_state,
            localization=manifest.localization,
        )
        scene = build.load(files.path(manifest.given), files.options(own, manifest.scene))
        transport = SilentTransport(definitions=scene.definitions)
        network = LiveNetwork(lambda domain: transport, 0, lambda complaint: None, scene.definitions)
        keeps_going = (lambda error: marks.log("error", "", str(error))) if manifest.keep_going else None
        with (
            build.start(scene, network, log=marks.log, fault=keeps_going, bad_values=manifest.bad_values) as session,
            contextlib.closing(RecordingPlayer(session, network, recording, marks, print)) as player,
        ):
            yield player


def put(path: Path, text: str) -> Path:
    """Write a file, in a folder that is made if need be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def rewritten(
    path: Path,
    *,
    manifest: dict[str, str] | None = None,
    end: dict[str, str] | None = None,
    attachments: dict[str, bytes] | None = None,
    types: dict[str, str] | None = None,
    commands: str = "",
    compression: CompressionType = CompressionType.LZ4,
) -> Path:
    """The same recording, with changes, written by another program."""
    target = path.with_name("rewritten.mcap")
    ids: dict[int, int] = {}
    with path.open("rb") as file, target.open("wb") as out:
        writer = Writer(out, compression=compression)
        writer.start("ros2")
        for record in StreamReader(file).records:
            if isinstance(record, Metadata):
                changes = {"graphengine": manifest, "graphengine:end": end}.get(record.name) or {}
                if record.name == "graphengine:end":
                    writer.flush()  # type: ignore[no-untyped-call]
                writer.add_metadata(record.name, {**record.metadata, **changes})
            elif isinstance(record, Attachment):
                data = (attachments or {}).get(record.name, record.data)
                writer.add_attachment(0, 0, record.name, record.media_type, data)
                if commands and record.name.startswith("project/"):
                    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
                    name = "/_graphengine/session"
                    channel = writer.register_channel(name, "cdr", schema, {"topic": name})
                    writer.add_message(channel, 10**9 // 60, messages.encode(messages.String(commands)), 0)
            elif isinstance(record, Schema):
                name = (types or {}).get(record.name, record.name)
                ids[-record.id] = writer.register_schema(name, record.encoding, record.data)
            elif isinstance(record, Channel):
                ids[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, ids[-record.schema_id], record.metadata
                )
            elif isinstance(record, Message):
                writer.add_message(ids[record.channel_id], record.log_time, record.data, record.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]
    return target
