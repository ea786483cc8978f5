"""Limits of the rooms runtime, scene, control and recording."""

from __future__ import annotations

from collections import deque
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from mcap.records import Chunk, Metadata
from pydantic import ValidationError

from graphengine.api.value_table import ValueTable
from graphengine.control import parameter_services, runs
from graphengine.control.channel import Channel
from graphengine.control.simulation_interfaces import entities, filters, resources, results
from graphengine.control.simulation_interfaces.results import RefusedError
from graphengine.control.simulation_interfaces.spawning import Spawning
from graphengine.control.simulation_interfaces.states import run_steps
from graphengine.format.errors import RecordingError, StateError, UsageError
from graphengine.format.files import Files
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.recording import manifest, mcap_schema, records, replay
from graphengine.recording.manifest import Manifest
from graphengine.recording.marks import Marks
from graphengine.recording.player import RecordingPlayer
from graphengine.recording.reader import Recording, Tick
from graphengine.recording.sources import Workspace
from graphengine.recording.writer import RecordingWriter
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime import parameter_table, port_values, reloading
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.commands import Rate, Step
from graphengine.runtime.fault_commands import Fault
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.value_edits import Change, ValueEdits
from tests.limits.table import accepts, limit, repeat

# runtime


@limit("runtime.command_queue.MAX_WAITING", at=3)
def _(commands: int) -> bool:
    queue = CommandQueue()
    return True not in [queue.ask(lambda session: None).done() for _ in range(commands)]


@limit("runtime.fault_commands.MAX_DELAY")
def _(delay: float) -> bool:
    return accepts(lambda: Fault(topic="/odom", delay=delay), ValidationError)


@limit("runtime.commands.MAX_TICKS")
def _(ticks: int) -> bool:
    return accepts(lambda: Step(ticks=ticks), ValidationError)


@limit("runtime.commands.MAX_TICKS")
def _(ticks: int) -> bool:
    session = SimpleNamespace(state="paused", step=lambda count: None)
    try:
        run_steps(session, ticks)  # type: ignore[arg-type]
    except RefusedError as error:
        return "legal" not in str(error)
    except AttributeError:
        pass
    return True


@limit("runtime.pacer.SLOWEST", lower=True)
def _(factor: float) -> bool:
    return accepts(lambda: Rate(factor=factor), ValidationError)


@limit("runtime.pacer.SLOWEST", lower=True)
def _(factor: float) -> bool:
    return accepts(lambda: parameter_table._rate(factor), UsageError)


@limit("runtime.parameter_table.FASTEST")
def _(factor: float) -> bool:
    return accepts(lambda: parameter_table._rate(factor), UsageError)


@limit("runtime.reloading.MOST_NAMES")
def _(names: int) -> bool:
    return "more" not in reloading._listed(["g"] * names)


@limit("runtime.session_core.MAX_HELD", at=3)
def _(checkpoints: int) -> bool:
    session = SessionCore.__new__(SessionCore)
    session.held = {}
    for number in range(checkpoints):
        session.hold(SimpleNamespace(name=str(number)))  # type: ignore[arg-type]
    return len(session.held) == checkpoints


@limit("scene.hot_reload.MAX_READINGS")
def _(readings: int, folder: Path) -> bool:
    """The files change during each reading but the last."""
    path = folder / "a.yaml"
    path.write_text("graph: a\nnodes: {T: OnPlaybackTick}\n", encoding="utf-8")
    changes = [True] * (readings - 1)
    with (
        pytest.MonkeyPatch.context() as patch,
        build.start(build.load(path), LiveNetwork(lambda _: MemoryTransport(), 0, print)) as session,
    ):
        patch.setattr(Files, "changed", lambda files: bool(changes) and changes.pop())
        return accepts(session.reload, UsageError)


# control


@limit("control.runs.MAX_NAME")
def _(letters: int) -> bool:
    return runs.entry_name("a" * letters, 1) == f"{'a' * letters}.1"


@limit("control.parameter_services.MAX_REQUEST")
def _(parameters: int) -> bool:
    return parameter_services._too_many([None] * parameters) is None


@limit("control.parameter_services.MAX_REQUEST")
def _(names: int) -> bool:
    services = parameter_services.ParameterServices.__new__(parameter_services.ParameterServices)
    services.table = {}
    answered: list[Any] = []
    services._reading("names", lambda request, _: answered.append(request))(SimpleNamespace(names=["a"] * names), None)
    return bool(answered)


@limit("control.channel.MAX_CLIENTS", at=2)
def _(clients: int) -> bool:
    channel = Channel.__new__(Channel)
    others: Any = dict.fromkeys(range(clients - 1))
    channel._clients, channel._idle = others, {}
    return channel._has_room()


@limit("control.simulation_interfaces.entities.FARTHEST")
def _(metres: float) -> bool:
    pose = messages.Pose(messages.Point(0.0, -metres, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    return accepts(lambda: entities.plain_pose(pose, 1), RefusedError)


@limit("control.simulation_interfaces.filters.MAX_PATTERN")
def _(characters: int) -> bool:
    return accepts(lambda: filters.name_filter("a" * characters, ["a"]), RefusedError)


@limit("control.simulation_interfaces.filters.MAX_UNROLLED", at=50)
def _(characters: int) -> bool:
    """A pattern of five characters with ten repetitions, or of one that is as long as it is."""
    pattern = "a{10}" if characters % 5 == 0 else "a" * characters
    return accepts(lambda: filters.name_filter(pattern, ["a"]), RefusedError)


@limit("control.simulation_interfaces.results.MAX_TEXT", at=20)
def _(letters: int) -> bool:
    return results.text_of(UsageError("x" * letters)) == "x" * letters


@limit("control.simulation_interfaces.spawning.MAX_AT_ONCE", at=3)
def _(requests: int) -> bool:
    resource = SimpleNamespace(uri="", resource_string="")
    request = SimpleNamespace(spawn_requests=[SimpleNamespace(entity_resource=resource)] * requests)

    class Spawned(Spawning):
        def _spawn(self, *_: Any) -> tuple[str, str]:
            return "bot", ""

    response = DEFINITIONS.initial("simulation_interfaces/srv/SpawnEntities_Response")
    return accepts(lambda: Spawned(None).spawn_entities(None, request, response), RefusedError)  # type: ignore[arg-type]


@limit("control.simulation_interfaces.resources.MAX_LISTED", at=3)
def _(robots: int, folder: Path) -> bool:
    for number in range(robots):
        (folder / f"{number}.urdf").touch()
    files = SimpleNamespace(may_read=lambda path: True, base=folder / "package")
    return len(resources.spawnables(files, folder, [])[0]) == robots  # type: ignore[arg-type]


# recording


@limit("recording.marks.MAX_MARKS", at=3)
def _(number: int) -> bool:
    made = Marks()
    made.tick = 1
    for _ in range(number):
        made.add("command", "play")
    return [mark.text for mark in made.all] == ["play"] * number


@limit("recording.marks.LONGEST")
def _(letters: int) -> bool:
    made = Marks()
    made.tick = 1
    made.add("command", "x" * letters)
    return made.all[0].text == "x" * letters


@limit("recording.player.MAX_CHECKPOINTS", at=4)
def _(checkpoints: int) -> bool:
    player = RecordingPlayer.__new__(RecordingPlayer)
    player._checkpoints, player._spacing, player.built = [], 1, 0
    player._keep = lambda tick: tick  # type: ignore[assignment,method-assign,return-value]
    for _ in range(checkpoints):
        player._add_checkpoint()
    return len(player._checkpoints) == checkpoints


@limit("recording.reader.MAX_MESSAGES", at=3)
def _(number: int) -> bool:
    found, tick = Recording.__new__(Recording), Tick(1)
    found.path = Path("a.mcap")
    stream: Any = SimpleNamespace(topic="/a", message_type="std_msgs/msg/String")
    return accepts(lambda: repeat(number, lambda: found._add(tick, stream, b"")), RecordingError)


@limit("recording.reader.MAX_INPUTS", at=50)
def _(size: int) -> bool:
    found = Recording.__new__(Recording)
    found.path = Path("a.mcap")
    data = messages.encode(messages.String("{}".ljust(size)))
    return accepts(lambda: found._add_outside(Tick(1), data), RecordingError)


@limit("recording.manifest.MAX_BYTES", at=50)
def _(size: int) -> bool:
    """A text within the limit is read; it is not the version of a manifest."""
    with pytest.raises(RecordingError) as error:
        Manifest.from_metadata({"format": str(manifest.FORMAT), "version": "{}".ljust(size)})
    return "cannot be read" not in str(error.value)


@limit("api.value_table.MAX_COLUMNS", at=3)
def _(columns: int) -> bool:
    with closing(ValueTable()) as table:
        return accepts(lambda: table.add(1, "a", [0.0] * columns), UsageError)


@limit("api.value_table.MAX_ELEMENTS", at=3)
def _(elements: int) -> bool:
    with closing(ValueTable()) as table:
        table.add(1, "a", [0.0] * elements)
        return not table.omitted


@limit("runtime.port_values.MAX_ELEMENTS", at=3)
def _(elements: int) -> bool:
    return port_values._kind((0.0,) * elements) is not None


@limit("runtime.port_values.MAX_PORTS", at=3)
def _(ports: int, folder: Path) -> bool:
    nodes = "".join(f"  N{number}: {{type: ConstantDouble}}\n" for number in range(ports))
    (folder / "g.yaml").write_text(f"graph: g\nnodes:\n{nodes}", encoding="utf-8")
    network = LiveNetwork(lambda _: MemoryTransport(), 0, print)
    with build.start(build.load(folder / "g.yaml"), network) as session:
        return accepts(lambda: port_values.PortValues(session, ["N*.value"]), UsageError)


@limit("scene.value_edits.MOST_CHANGES", at=3)
def _(changes: int, folder: Path) -> bool:
    path, edits = folder / "g.yaml", ValueEdits(lambda: None)
    path.write_bytes(b"")
    for number in range(changes):
        edits.write(Change(path, b"#" * number, b"#" * (number + 1), ""))
    return accepts(lambda: repeat(changes, edits.undo), StateError)


@limit("recording.reader.MAX_SILENCE", at=3)
def _(ticks: int) -> bool:
    found = Recording.__new__(Recording)
    found.path, found._records, found.cut_off, found._ended = Path("a.mcap"), iter(()), False, 1 + ticks
    return accepts(lambda: list(found.ticks()), RecordingError)


@limit("recording.reader.MAX_DIGITS")
def _(digits: int) -> bool:
    found = Recording.__new__(Recording)
    found.path = Path("a.mcap")
    record = Metadata(metadata={"ticks": "1" * digits}, name=mcap_schema.END)
    return accepts(lambda: found._take(record), RecordingError)


@limit("recording.records.MAX_CHUNK_BYTES", at=10)
def _(size: int) -> bool:
    chunk = Chunk("", bytes(size), 0, 0, 0, size)
    return accepts(lambda: records._unpacked(chunk), ValueError)


@limit("recording.replay.MAX_FIELDS", at=3)
def _(fields: int) -> bool:
    one, other = (
        messages.encode(messages.Twist(messages.Vector3(*values[:3]), messages.Vector3(*values[3:])))
        for values in ([0.0] * 6, [1.0] * fields + [0.0] * (6 - fields))
    )
    found = replay.Replay.__new__(replay.Replay)
    found.network = SimpleNamespace(definitions=DEFINITIONS)  # type: ignore[assignment]
    return "more fields" not in str(found._fields(one, other, "geometry_msgs/msg/Twist"))


@limit("recording.sources.MAX_FILES", at=3)
def _(files: int, folder: Path) -> bool:
    workspace, names = Workspace(folder), map(str, range(files))
    return accepts(lambda: repeat(files, lambda: workspace.add(f"project/{next(names)}", b"")), RecordingError)


@limit("recording.sources.MAX_BYTES", at=10)
def _(size: int, folder: Path) -> bool:
    workspace = Workspace(folder)
    workspace.add("project/a", bytes(5))
    return accepts(lambda: workspace.add("project/b", bytes(size - 5)), RecordingError)


@limit("recording.sources.MAX_PARTS", at=5)
def _(parts: int, folder: Path) -> bool:
    return accepts(lambda: Workspace(folder).path(f"project{'/a' * (parts - 1)}"), RecordingError)


@limit("recording.writer.MAX_WAITING", at=10)
def _(size: int) -> bool:
    """Bytes that are queued without a wait for the thread that writes."""
    waits: list[bool] = []
    job = SimpleNamespace(done=lambda: False, result=lambda: waits.append(True))
    writer = RecordingWriter.__new__(RecordingWriter)
    writer._thread = SimpleNamespace(submit=lambda *_: job)  # type: ignore[assignment]
    writer._waiting, writer._waiting_bytes = deque(), 0
    writer._hand_over(lambda: None, size)
    return not waits
