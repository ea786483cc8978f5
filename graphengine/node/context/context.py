"""The context of one node: the only way in which a node reaches the world, the network and the session."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from graphengine.format.stateful import Shared
from graphengine.node.clock import Clock
from graphengine.node.context.action_access import OwnedActions
from graphengine.node.context.device_access import WorldHandles
from graphengine.node.context.session_services import Services
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import EventQueue, Mailbox
from graphengine.node.variable import Variable, find_variable


class Context(WorldHandles, OwnedActions, Shared):
    """The argument of `Node.setup`. A node gets its handles, ROS endpoints and session services from it.

    The context owns the endpoints and destroys them when the node is set up again or removed. Handles stay valid until the
    session ends, even if a robot is added or removed. Units are SI; quaternions are (x, y, z, w); each method names the frame
    of its result.

    Attributes:
        prim_path: path of the node's prim: the path of the graph's prim, followed by the node's name.
        graph_path: path of the graph's prim.
        clock: simulation clock of the graph.
        runs: whether the graph is executed once per `tick` or once per `physics_step`.
    """

    def __init__(
        self,
        services: Services,
        clock: Clock,
        graph: str,
        prim_path: str,
        rate: float | None,
        variables: Mapping[str, Variable],
        runs: Literal["tick", "physics_step"] = "tick",
        wired: Mapping[str, int] | None = None,
        graph_path: str = "",
        folder: Path = Path(),
    ) -> None:
        WorldHandles.__init__(self, services, runs)
        OwnedActions.__init__(self, services, graph, prim_path, rate)
        self.clock = clock
        self.graph_path = graph_path or prim_path.rpartition("/")[0]
        self._wired = wired
        self._folder = folder
        self._variables = variables
        self.mailboxes: list[Mailbox] = []
        """Mailboxes of the node, in the order of the calls of `mailbox`."""
        self.files_read: dict[str, tuple[Path, str]] = {}
        """Resolved path and text of each file that the node read; the key is the path that the node passed to `read_file`."""

    def wired(self, output: str) -> bool:
        """Return whether an output of the node is connected, so that a node can skip the computation of an unused output.

        For a node outside a graph, as in a test, all outputs count as connected.

        Args:
            output: Python name of the output.
        """
        return self._wired is None or output in self._wired

    def wires_into(self, pin: str) -> int:
        """Return the number of wires into an execution input. For a node outside a graph, as in a test, it is 1.

        Args:
            pin: Python name of the execution input.
        """
        return 1 if self._wired is None else self._wired.get(pin, 0)

    def variable(self, name: str) -> Variable:
        """Return the variable of the node's graph with this name.

        Raises:
            ContextError: the graph has no such variable.
        """
        return find_variable(self._variables, name)

    def mailbox(self, name: str) -> Mailbox:
        """Return a new mailbox for the session's event queue `name`; create the queue if it does not exist."""
        self.mailboxes.append(Mailbox(self._services.queues.setdefault(name, EventQueue(name))))
        return self.mailboxes[-1]

    def environment(self, name: str) -> str:
        """Return the value of an environment variable, or an empty string if the variable is not set.

        Raises:
            ContextError: the user has not permitted graphs to read this variable.
        """
        return self._services.permissions.variable(name)

    def read_file(self, path: str) -> tuple[Path, str]:
        """Return the resolved path and the content of a text file.

        Args:
            path: path of the file, relative to the folder of the graph file.

        Raises:
            ContextError: the file does not exist, graphs are not permitted to read it, it is too large, or it is not UTF-8.
        """
        self.files_read[path] = self._services.permissions.read(path, self._folder)
        return self.files_read[path]

    def reads_the_same(self) -> bool:
        """Return whether all files that the node read are unchanged.

        Raises:
            ContextError: one of the files can no longer be read.
        """
        permissions, folder = self._services.permissions, self._folder
        return all(permissions.read(path, folder) == found for path, found in self.files_read.items())

    def allow_scripts(self) -> None:
        """Check that graphs are allowed to run Python scripts; a node calls this before it runs a script.

        Raises:
            ContextError: the user has not permitted graphs to run scripts.
        """
        self._services.permissions.require_scripts()

    def keyboard(self) -> Keyboard:
        """Return the session's keyboard, which lists the keys that are held down."""
        self._services.keys.asked = True
        return self._services.keys

    def random(self) -> np.random.Generator:
        """Return the node's own random generator. Its seed is derived from the session's seed and the node's prim path."""
        if self.prim_path not in self._services.generators:
            self._services.reseed(self.prim_path)
        return self._services.generators[self.prim_path]

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Log a message of the node. `graphrun run` prints messages with the same severity and first line only once."""
        self._services.log(severity, self.prim_path, message)

    def log_dropped(self, message: str) -> None:
        """Count this tick as one in which the node dropped a message; at counts 1, 2, 4, 8, …, log a warning."""
        dropped = self._services.dropped
        if dropped is None or dropped.add(self.prim_path, self.clock.frame):
            earlier = dropped.earlier(self.prim_path) if dropped is not None else ""
            self._services.warn(self.prim_path, message + earlier)
