"""What comes from the machine that runs the graph: variables of the environment, and files (`isaacsim.core.nodes`).

Both are read once, before the first tick.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import Bound, Context, In, Node, Out, String


class IsaacReadEnvVar(Node, type="isaacsim.core.nodes.IsaacReadEnvVar"):
    """Value of a variable of the environment that whoever runs the graph allowed by `--env NAME`."""

    env_var: String = In(default="", setup=True, required=True, doc="name of the variable")
    value: String = Out(doc="empty where the environment has none of that name")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read it.

        Raises:
            ContextError: it may not be read.
        """
        self.found = context.environment(self.env_var)

    def compute(self) -> None:
        """Tell it."""
        self.value = self.found


class IsaacReadFilePath(Node, type="isaacsim.core.nodes.IsaacReadFilePath"):
    """Text of a file, which lies beside the graph file, among what ships, or in a folder given by `--allow`."""

    path: Any = In(type="path", default="", setup=True, required=True, doc="from the folder of the graph file")
    file_contents: Any = Out(type="string|token")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read it.

        Raises:
            ContextError: it is nowhere, may not be read, is too large, or no text.
        """
        self.found = context.read_file(self.path)[1]

    def compute(self) -> None:
        """Tell it."""
        self.file_contents = self.found
