"""One node's door to the session."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from graphengine.node.clock import Clock
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import EventQueue, Mailbox
from graphengine.node.variable import Variable, find_variable
from graphengine.runtime.node_context.endpoints import OwnedEndpoints
from graphengine.runtime.node_context.handles import WorldHandles
from graphengine.runtime.node_context.services import Services


class NodeContext(WorldHandles, OwnedEndpoints):
    """All that a node may touch."""

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
        OwnedEndpoints.__init__(self, services, graph, prim_path, rate)
        self.clock = clock
        self.graph_path = graph_path or prim_path.rpartition("/")[0]
        self._wired = wired
        self._folder = folder
        self._variables = variables

    def wired(self, output: str) -> bool:
        """Whether a wire takes an output of the node; every output, where there is no graph."""
        return self._wired is None or output in self._wired

    def wires_into(self, pin: str) -> int:
        """How many wires end at an execution input of the node; one, where there is no graph."""
        return 1 if self._wired is None else self._wired.get(pin, 0)

    def variable(self, name: str) -> Variable:
        """A variable of the node's graph."""
        return find_variable(self._variables, name)

    def mailbox(self, name: str) -> Mailbox:
        """A named queue of the session."""
        return Mailbox(self._services.queues.setdefault(name, EventQueue(name)))

    def environment(self, name: str) -> str:
        """A variable of the environment."""
        return self._services.permissions.variable(name)

    def read_file(self, path: str) -> tuple[Path, str]:
        """A text file, named from the folder of the graph file."""
        return self._services.permissions.read(path, self._folder)

    def allow_scripts(self) -> None:
        """Refuse to go on unless the user lets graphs run Python."""
        self._services.permissions.require_scripts()

    def keyboard(self) -> Keyboard:
        """The keys of whoever runs the session."""
        self._services.keys.asked = True
        return self._services.keys

    def random(self) -> np.random.Generator:
        """A generator seeded by the session's seed and the node's prim path."""
        if self.prim_path not in self._services.generators:
            self._services.reseed(self.prim_path)
        return self._services.generators[self.prim_path]

    def log(self, severity: Literal["info", "warning", "error"], message: str) -> None:
        """Tell the user."""
        self._services.log(severity, self.prim_path, message)
