"""A small world behind the services of simulation_interfaces, and a client that calls them as a peer on the network would."""

from __future__ import annotations

import contextlib
import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from graphengine.control.service_host import SERVICES
from graphengine.control.simulation_interfaces.server import SimulationInterfaces
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import Transport, TransportClient
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build
from tests.control.harness import Controlled, controlled
from tests.physics.harness import Project
from tests.waiting import PATIENCE, eventually

BODIES = """<body name="ball" pos="5 0 3"><freejoint/><geom size=".1" mass="2"/></body>
<body name="shelf" pos="1 2 3"><geom type="box" size=".1 .2 .3"/></body>"""
WORLD = f'<mujoco><worldbody><geom type="plane" size="0 0 1"/>{BODIES}</worldbody></mujoco>'
CRATE = """<robot name="crate"><link name="crate">
  <inertial><mass value="3"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size=".4 .4 .4"/></geometry></collision>
</link></robot>"""


class Client:
    """Calls services by their short names, `get_entities`, and waits for answers."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._clients: dict[str, tuple[TransportClient, queue.Queue[bytes]]] = {}

    def call(self, service: str, /, **fields: Any) -> Any:
        """Ask; nested fields are given with `__` for the dot."""
        kind = f"simulation_interfaces/srv/{''.join(part.capitalize() for part in service.split('_'))}"
        return self.ask(service, kind, **fields)

    def ask(self, service: str, kind: str, /, **fields: Any) -> Any:
        """The same for a service of any type."""
        request = DEFINITIONS.initial(f"{kind}_Request")
        for name, value in fields.items():
            *way, last = name.split("__")
            place = request
            for part in way:
                place = getattr(place, part)
            setattr(place, last, value)
        return self.send(service, kind, messages.encode(request))

    def send(self, service: str, kind: str, data: bytes, patience: float = PATIENCE) -> Any:
        """The same for bytes."""
        if service not in self._clients:
            answers: queue.Queue[bytes] = queue.Queue()
            made = self._transport.client(f"/{service}", kind, SERVICES, lambda number, data: answers.put(data))
            self._clients[service] = made, answers
        client, answers = self._clients[service]
        assert eventually(lambda: client.ready), service
        client.call(data)
        return messages.decode(answers.get(timeout=patience), f"{kind}_Response")


class Simulator(Client):
    """A run with its services."""

    def __init__(self, run: Controlled, transport: MemoryTransport, complaints: list[str]) -> None:
        super().__init__(transport)
        self.run = run
        self.session = run.session
        self.transport = transport
        self.complaints = complaints


@contextlib.contextmanager
def simulator(folder: Path, **how: Any) -> Iterator[Simulator]:
    """A scene of a cart with an arm, `bot`, a free `ball` and a `shelf`, paused at time 0."""
    project = Project(folder).write("world.xml", WORLD)
    assembly = build.load(project.folder / "scene.yaml")
    assert assembly.world is not None
    scenery = assembly.world.scenery
    transport, complaints = MemoryTransport(), list[str]()
    session = build.start(assembly, LiveNetwork(lambda domain: transport, 0, complaints.append))
    with controlled(session, **{"paused": True, **how}) as run:
        services = SimulationInterfaces(
            run.queue, (scenery.scene, scenery.library.files), transport, complaints.append, "/"
        )
        try:
            yield Simulator(run, transport, complaints)
        finally:
            services.close()
