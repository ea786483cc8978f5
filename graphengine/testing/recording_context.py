"""A context in which tests run a single node without a session."""

from __future__ import annotations

from typing import Any

from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.context.session_services import Services
from graphengine.node.node_class import Node
from graphengine.node.variable import Variable
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.testing.recording_world import RecordingWorld


class RecordingContext(Context):
    """A context for the test of a single node, with a `RecordingWorld` and an in-memory transport.

    Args:
        prim_path: path of the node's prim.
        wanted: whether every topic counts as having a subscriber. If False, topics have only the subscribers that the test
            adds to `transport`; most nodes publish nothing on a topic without subscribers.
        ros_domain_id: value of the environment variable `ROS_DOMAIN_ID`; None if the variable is not set.
    """

    def __init__(
        self, prim_path: str = "/World/graph/node", *, wanted: bool = True, ros_domain_id: int | None = None
    ) -> None:
        self.world, self._memory = RecordingWorld(), MemoryTransport(wants_all=wanted)
        self.logged: list[tuple[str, str]] = []  # severity and text
        self.variables: dict[str, Variable] = {}
        network = LiveNetwork(lambda _: self._memory, 0, lambda text: self.logged.append(("network", text)))
        self.services = Services(self.world, network, domain_from_environment=ros_domain_id)
        self.services.log = lambda severity, _, message: self.logged.append((severity, message))
        clock = Clock(self.world.tick_period)
        super().__init__(self.services, clock, "graph", prim_path, 1.0 / clock.delta, self.variables)

    @property
    def transport(self) -> MemoryTransport:
        """The in-memory transport, which has all messages that the node published so far."""
        self.services.network.flush()
        return self._memory

    def tick(self, ticks: int = 1) -> None:
        """Advance time by a number of ticks; each tick delivers the messages sent to the node since the previous tick."""
        for _ in range(ticks):
            shared = self.services
            frozen: list[Any] = [shared.network, shared.keys, *shared.queues.values(), *self.variables.values()]
            for part in frozen:
                part.freeze()
            self.clock.set_frame(self.clock.frame + 1)

    def stop(self, *nodes: Node) -> None:
        """Stop as a session does: reset time to 0, and outputs and state of `nodes` to their defaults."""
        self.services.forget_calls()
        for node in nodes:
            node.reset()
            node.clear()
        for path in self.services.generators:
            self.services.reseed(path)
        self.clock.stop()
