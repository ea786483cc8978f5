"""Graphs and scenes from YAML text to a session over topics in memory, and numbers that come from elsewhere than the engine."""

from __future__ import annotations

import json
import re
import struct
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.backend import World
from graphengine.devices.lidar import LidarStub
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.diagnostics import Findings
from graphengine.format.files import shipped
from graphengine.messages import messages
from graphengine.node import Node
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.commands import parse
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene, Options
from graphengine.testing import RecordingContext, RecordingWorld

HERE = Path(__file__).parent
N = TypeVar("N", bound=Node)
T = TypeVar("T")


def facts(name: str) -> dict[str, Any]:
    """A JSON file of this folder."""
    found: dict[str, Any] = json.loads((HERE / name).read_text("utf-8"))
    return found


def ready(cls: type[N], context: RecordingContext, /, **inputs: Any) -> N:
    """A node with those inputs, set up."""
    node = fed(cls, **inputs)
    node.setup(context)
    return node


def fed(cls: type[N], /, **inputs: Any) -> N:
    """A node with those inputs, out of bounds too, as from wires."""
    node = cls()
    for field, value in inputs.items():
        setattr(node, field, cls.fields[field].check(value, recorded=True))
    return node


def computed(cls: type[N], context: RecordingContext, /, **inputs: Any) -> N:
    """A node with those inputs, set up and computed."""
    node = ready(cls, context, **inputs)
    node.compute()
    return node


class HelperBench:
    """A helper node of a sensor, alone in its context."""

    context: RecordingContext
    node: Any

    def executed(self) -> list[Any]:
        """What is published in a tick in which the helper is executed."""
        before = len(self.sent)
        self.node.compute()
        self.node.update()
        return self.sent[before:]

    @property
    def sent(self) -> list[Any]:
        """Everything that was published on the first topic."""
        return self.context.transport.messages(self.context.services.claims[0].topic)


class Playing:
    """A session, its nodes by `graph/id` or `id`, and its topics."""

    def __init__(
        self,
        scene: LoadedScene,
        *,
        world: World | None = None,
        wanted: bool = True,
        domain_from_environment: int | None = None,
    ) -> None:
        self.definitions, self.findings = scene.definitions, scene.findings
        self.transport = MemoryTransport(wants_all=wanted, definitions=self.definitions)
        self.complaints: list[str] = []
        network = LiveNetwork(lambda _: self.transport, 0, self.complaints.append, self.definitions)
        self.session = build.start(scene, network, domain_from_environment=domain_from_environment, world=world)
        self.topics = {claim.node.rpartition("/")[2]: claim.topic for claim in self.session.services.claims}

    def node(self, node_id: str) -> Any:
        """A node's instance."""
        graph, _, last = node_id.rpartition("/")
        return next(
            node
            for run in self.session.graphs
            if run.name.endswith(graph)
            for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True)
            if instance.id == last
        )

    def set(self, node_id: str, field: str, value: Any) -> None:
        """Change a literal while the graph runs; what setup reads sets its graph up again."""
        for run in self.session.graphs:
            for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True):
                if instance.id == node_id:
                    setattr(node, field, value)
                    if instance.cls.fields[field].setup:
                        run.executor.setup()

    def tick(self, ticks: int = 1) -> Self:
        """Run."""
        self.session.step(ticks)
        return self

    def each_tick(self, ticks: int, read: Callable[[], T]) -> list[T]:
        """What is read after each of the next ticks."""
        return [read() for _ in range(ticks) if self.tick()]

    @property
    def dropped(self) -> dict[str, int]:
        """Ticks in which nodes could not use a value from a wire, by their prim paths."""
        dropped = self.session.services.dropped
        assert dropped is not None
        return dropped.ticks

    def ports(self) -> list[str]:
        """What stands on all ports; what does not say its value is the same object."""
        nodes = [node for run in self.session.graphs for node in run.executor.nodes]
        values = [getattr(node, p.field) for node in nodes for p in type(node).fields.values() if not p.bound_in_setup]
        return [re.sub(r"(Generator\(\w+\)) at 0x\w+", r"\1", repr(value)) for value in values]

    def command(self, name: str, /, **arguments: Any) -> None:
        """Ask the session for something, between two ticks."""
        parse(name, arguments).apply(self.session)

    def published(self, topic: str) -> list[Any]:
        """Messages on a topic, oldest first."""
        return self.transport.messages(topic)


def write(folder: Path, files: Mapping[str, str]) -> None:
    """Write files, by their paths below a folder."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip(), "utf-8")


def checked(folder: Path, text: str) -> Findings:
    """What the check of a graph from text finds; `graph` is given."""
    write(folder, {"graph.yaml": f"graph: graph\n{textwrap.dedent(text)}"})
    return build.load(folder / "graph.yaml").findings


def names(message_type: str) -> dict[str, str]:
    """What a file writes to name a message or a service."""
    return dict(zip(("messagePackage", "messageSubfolder", "messageName"), message_type.split("/"), strict=True))


class Player:
    """Starts sessions of files in a folder of their own, and closes them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.playing: list[Playing] = []

    def graph(self, text: str, world: World | None = None, *, options: Options | None = None, **how: Any) -> Playing:
        """A graph from text; `format` and `graph` are given."""
        path = self.folder / "graph.yaml"
        path.write_text("format: 1\ngraph: graph\n" + textwrap.dedent(text), "utf-8")
        return self.file(path, world, options=options, **how)

    def file(self, path: Path, world: World | None = None, *, options: Options | None = None, **how: Any) -> Playing:
        """A graph file, over a world of a test."""
        self.playing.append(Playing(build.load(path, options), world=world or RecordingWorld(), **how))
        return self.playing[-1]

    def shipped(self, name: str, world: World | None = None, **how: Any) -> Playing:
        """A graph that ships."""
        return self.file(shipped() / "graphs" / f"{name}.yaml", world, **how)

    def scene(self, files: Mapping[str, str]) -> Playing:
        """A scene with its physics; `scene.yaml` is the one to run."""
        write(self.folder, files)
        self.playing.append(Playing(build.load(self.folder / "scene.yaml")))
        return self.playing[-1]

    def close(self) -> None:
        """End every session, after a checkpoint of which going back to it changes no node."""
        for playing in self.playing:
            kept = playing.session.checkpoint()
            before = playing.ports()
            playing.session.restore(kept)
            assert playing.ports() == before
            playing.session.close()


def twist(v: float, w: float) -> messages.Twist:
    """Forward and turning velocity."""
    return messages.Twist(messages.Vector3(v, 0.0, 0.0), messages.Vector3(0.0, 0.0, w))


def vector(message: Any) -> Vector3:
    """x, y, z of a message."""
    return message.x, message.y, message.z


def quaternion(message: Any) -> Quaternion:
    """x, y, z, w of a message."""
    return message.x, message.y, message.z, message.w


def read_points(cloud: Any) -> dict[str, list[Any]]:
    """Columns of a cloud by name, from its bytes and fields as sensor_msgs/PointField defines them."""
    formats = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 8: "d"}
    order = ">" if cloud.is_bigendian else "<"
    data, columns = bytes(cloud.data), dict[str, list[Any]]()
    assert len(data) == cloud.row_step * cloud.height == cloud.point_step * cloud.width * cloud.height
    for field in cloud.fields:
        layout = f"{order}{field.count}{formats[field.datatype]}"
        assert field.offset + struct.calcsize(layout) <= cloud.point_step
        starts = range(field.offset, len(data), cloud.point_step)
        values = [struct.unpack_from(layout, data, start) for start in starts]
        columns[field.name] = [value[0] if field.count == 1 else value for value in values]
    return columns


def yaw(angle: float) -> Quaternion:
    """Rotation about z."""
    return 0.0, 0.0, float(np.sin(angle / 2)), float(np.cos(angle / 2))


def matrix(q: Quaternion) -> NDArray[np.float64]:
    """Rotation matrix of a unit quaternion: (w^2 - u.u) 1 + 2 u u^T + 2 w [u]x."""
    u, w = np.array(q[:3]), q[3]
    x, y, z = q[:3]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: NDArray[np.float64] = (w * w - u @ u) * np.eye(3) + 2.0 * np.outer(u, u) + 2.0 * w * cross
    return turned


def dd100(prefix: str = "/dd100") -> RecordingWorld:
    """The tutorial's robot as its graphs address it: namespaces, links, lidar and wheels, without physics."""
    world = RecordingWorld()
    chassis = f"{prefix}/Geometry/base_link/chassis_link"
    world.add_robot(prefix, ["front_left_wheel_joint", "front_right_wheel_joint"], articulation_root=chassis)
    world.stage.find(f"{prefix}/Geometry/base_link").namespace = "dd100_0000"
    world.stage.add(chassis, "link", body=chassis)
    world.stage.add(f"{chassis}/sim_lidar", "sensor", position=(0.0, 0.0, 0.15), namespace="sim_lidar")
    world.stage.add(f"{chassis}/sim_camera", "sensor", position=(0.3, 0.0, 0.05), namespace="sim_camera")
    world.add_device(LidarStub, f"{chassis}/sim_lidar/Lidar", rate=20.0, angles=(-1.0, 1.0, 0.5), ranges=(0.05, 9.0))
    return world
