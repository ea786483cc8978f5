"""Offers the parameters of a session as ROS 2 parameters, on one ROS 2 node for each robot and on the session's own node."""

from __future__ import annotations

import atexit
import re
import threading
from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.control.parameter_services import ParameterServices
from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.names import join_namespaces, strip
from graphengine.messages.parameters import EVENT, EVENTS, ParameterType, parameter_message
from graphengine.messages.qos import PARAMETER_EVENTS
from graphengine.ros.network_graph import full_name, split_name
from graphengine.ros.transport import Complain, Transport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.graph_run import GraphRun
from graphengine.runtime.parameter_table import USE_SIM_TIME, graph_parameters, session_parameters
from graphengine.runtime.session_core import SessionCore

Snapshot = tuple[Sequence[GraphRun], Mapping[str, str]]
"""The graphs of a session, and a dict from robot names to the full names of the robots' ROS nodes."""


class ParameterNodes:
    """The ROS 2 nodes with the parameters of a session.

    A thread creates and destroys parameter services after changes of robots and graphs, and publishes changed values on
    `/parameter_events`. Ticks do no work for the parameters.

    Args:
        session: session whose graph inputs and settings become parameters.
        queue: command queue of the session.
        transport: transport with a ROS node.
        complain: called once with each warning about malformed requests and about nodes that cannot be created.
    """

    def __init__(self, session: SessionCore, queue: CommandQueue, transport: Transport, complain: Complain) -> None:
        self._session = session
        self._queue = queue
        self._transport = transport
        self._complain = complain
        self._nodes: dict[str, ParameterServices] = {}
        self._announced: dict[str, dict[str, Any]] = {}
        """Newest value on `/parameter_events` of each parameter, by node name and parameter name."""
        self._followed: Snapshot | None = None
        self._events = transport.writer(EVENTS, EVENT, PARAMETER_EVENTS)
        self._snapshot = self._look()
        self._wake = threading.Event()
        self._wake.set()
        self._closed = False
        self._warned: set[str] = set()
        self._thread = threading.Thread(target=self._work, name="parameters", daemon=True)
        session.listeners.append(self._listen)
        self._thread.start()
        atexit.register(self.close)  # for a session that is not closed; runs before the transport's exit handler

    def close(self) -> None:
        """End the thread and destroy all services. Safe to call twice."""
        if self._closed:
            return
        self._closed = True
        atexit.unregister(self.close)
        self._session.listeners.remove(self._listen)
        self._wake.set()
        self._thread.join()
        for services in self._nodes.values():
            services.close()
        self._events.close()

    def _listen(self) -> None:
        """Wake the thread after a change of the session; the session's thread calls this method."""
        if self._session.graphs is not self._snapshot[0]:
            self._snapshot = self._look()
        self._wake.set()

    def _look(self) -> Snapshot:
        """Return a snapshot of the session: its graphs, and the full node name of each robot."""
        stage, own = self._session.services.stage, self._transport.node
        above = split_name(own)[0].strip("/")
        nodes: dict[str, str] = {}
        for prim in stage.prims("robot"):
            namespace = join_namespaces([above, *map(strip, stage.namespaces(prim.facts["base_link"]))])
            nodes[prim.entity_name] = node_name(namespace, prim.entity_name, {own, *nodes.values()})
        return self._session.graphs, nodes

    def _work(self) -> None:
        while True:
            self._wake.wait()
            self._wake.clear()
            if self._closed:
                return
            snapshot = self._snapshot
            if snapshot is not self._followed:
                self._follow(snapshot)
                self._followed = snapshot
                self._announce()
            elif self._events.matched:  # without a subscriber, changes wait for the first subscriber
                self._announce()

    def _follow(self, snapshot: Snapshot) -> None:
        """Create and destroy parameter services to match a snapshot; all other nodes get new parameter tables."""
        graphs, robots = snapshot
        own = {**session_parameters(self._session), **graph_parameters(graphs)}
        tables = {self._transport.node: own}
        tables |= {node: graph_parameters(graphs, robot) for robot, node in robots.items()}
        for node in [node for node in self._nodes if node not in tables]:
            self._nodes.pop(node).close()
        for node, table in tables.items():
            table[USE_SIM_TIME.name] = USE_SIM_TIME
            if node in self._nodes:
                self._nodes[node].table = table
            elif not self._closed:
                try:
                    self._nodes[node] = ParameterServices(node, table, self._queue, self._transport, self._complain)
                except GraphError as error:  # the other nodes keep their services
                    self._warn(f"{node}: its parameters are not offered: {error}")

    def _announce(self) -> None:
        """Publish a ParameterEvent for each node whose parameters were created, changed or deleted since the last call."""
        gone = self._announced.keys() - self._nodes.keys()
        for node in [*self._nodes, *gone]:
            table = self._nodes[node].table if node in self._nodes else {}
            before, now = self._announced.get(node, {}), {name: each.read() for name, each in table.items()}
            new = [name for name in now if name not in before]
            changed = [name for name in now if name in before and not table[name].has(before[name])]
            deleted = [name for name in before if name not in now]
            if self._events.matched and (new or changed or deleted):
                event = DEFINITIONS.initial(EVENT)
                event.node = node
                event.stamp = messages.Time(*divmod(round(self._session.time * 1e9), 1_000_000_000))
                event.new_parameters = [table[name].message(now[name]) for name in new]
                event.changed_parameters = [table[name].message(now[name]) for name in changed]
                event.deleted_parameters = [parameter_message(name, ParameterType.NOT_SET, None) for name in deleted]
                try:
                    self._events.write(messages.encode(event))
                except GraphError as error:
                    self._warn(f"{node}: changes of parameters are not announced: {error}")
            self._announced[node] = now
        for node in gone:
            del self._announced[node]

    def _warn(self, text: str) -> None:
        """Report each warning once; ignore warnings while `close` destroys the services."""
        if text not in self._warned and not self._closed:
            self._warned.add(text)
            self._complain(text)


def node_name(namespace: str, robot: str, taken: set[str]) -> str:
    """Return the full name of a robot's ROS node: the robot's name in the namespace, with a number if the name is in `taken`.

    `_` replaces characters that are illegal in node names.
    """
    plain = re.sub(r"\A(?![A-Za-z_])", "robot_", re.sub(r"[^A-Za-z0-9_]", "_", robot))
    name = full_name(f"/{namespace.strip('/')}", plain)
    number = 2
    while name in taken:
        name = full_name(f"/{namespace.strip('/')}", f"{plain}_{number}")
        number += 1
    return name
