"""The context of one node, its only access to the world, the network and the session."""

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
    """Gives a node handles, endpoints and services in `setup`. The context owns them and closes the endpoints.

    Handles stay valid for the life of the session; the engine rebinds them when a robot is added or removed. Units are SI;
    quaternions are (x, y, z, w); each method names the frame of its result.

    Attributes:
        prim_path: path of the node's prim: the path of the graph's prim, then the node's name.
        graph_path: path of the graph's prim.
        clock: simulation time.
        runs: how often the graph runs: once per `tick` or once per `physics_step`.
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
        """Mailboxes that the node opened."""
        self.files_read: dict[str, tuple[Path, str]] = {}
        """Path and text of each file that the node read, by the path that it gave."""

    def wired(self, output: str) -> bool:
        """Return whether an output of the node, given by its Python name, has a wire; true for a node outside a graph.

        A node may skip the computation of an unwired output.
        """
        return self._wired is None or output in self._wired

    def wires_into(self, pin: str) -> int:
        """Return the number of wires into an execution input, given by its Python name; 1 for a node outside a graph."""
        return 1 if self._wired is None else self._wired.get(pin, 0)

    def variable(self, name: str) -> Variable:
        """Return the variable of the node's graph with this name.

        Raises:
            ContextError: the graph has no such variable.
        """
        return find_variable(self._variables, name)

    def mailbox(self, name: str) -> Mailbox:
        """Open a mailbox for the node on a named queue of the session; a missing queue is created."""
        self.mailboxes.append(Mailbox(self._services.queues.setdefault(name, EventQueue(name))))
        return self.mailboxes[-1]

    def environment(self, name: str) -> str:
        """Return the value of an environment variable that the user lets graphs read; empty if it is not set.

        Raises:
            ContextError: the user does not let graphs read the variable.
        """
        return self._services.permissions.variable(name)

    def read_file(self, path: str) -> tuple[Path, str]:
        """Read a text file.

        Args:
            path: path of the file, relative to the folder of the graph file.

        Returns:
            The file's path and its text.

        Raises:
            ContextError: the file does not exist, may not be read, is too large, or is not UTF-8.
        """
        self.files_read[path] = self._services.permissions.read(path, self._folder)
        return self.files_read[path]

    def reads_the_same(self) -> bool:
        """Whether every file that the node read still has the same text.

        Raises:
            ContextError: one of them cannot be read any more.
        """
        permissions, folder = self._services.permissions, self._folder
        return all(permissions.read(path, folder) == found for path, found in self.files_read.items())

    def allow_scripts(self) -> None:
        """Check that the user lets graphs run Python.

        Raises:
            ContextError: the user does not allow it.
        """
        self._services.permissions.require_scripts()

    def keyboard(self) -> Keyboard:
        """Return the keyboard of the session, with the keys that are held down."""
        self._services.keys.asked = True
        return self._services.keys

    def random(self) -> np.random.Generator:
        """Return the node's random generator, seeded by the session's seed and the node's prim path."""
        if self.prim_path not in self._services.generators:
            self._services.reseed(self.prim_path)
        return self._services.generators[self.prim_path]

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Print a message for the user; a repeated message is printed once."""
        self._services.log(severity, self.prim_path, message)
