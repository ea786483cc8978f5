"""Environment variables and files of the machine that runs the graph (`isaacsim.core.nodes`).

Both are read once, before the first tick.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import Bound, Context, In, Node, Out, String


class IsaacReadEnvVar(Node, type="isaacsim.core.nodes.IsaacReadEnvVar"):
    """Reads an environment variable that the user allowed with `--env NAME`."""

    env_var: String = In(default="", setup=True, required=True, doc="name of the variable")
    value: String = Out(doc="value of the variable; empty if it is not set")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read the variable once.

        Raises:
            ContextError: the user did not allow the variable.
        """
        self.found = context.environment(self.env_var)

    def compute(self) -> None:
        """Output the value that `setup` has read."""
        self.value = self.found


class IsaacReadFilePath(Node, type="isaacsim.core.nodes.IsaacReadFilePath"):
    """Reads a text file from the graph file's folder, from the included files, or from a folder given by `--allow`."""

    path: Any = In(type="path", default="", setup=True, required=True, doc="path relative to the graph file's folder")
    file_contents: Any = Out(type="string|token")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read the file once.

        Raises:
            ContextError: the file does not exist, may not be read, is too large, or is not text.
        """
        self.found = context.read_file(self.path)[1]

    def compute(self) -> None:
        """Output the text that `setup` has read."""
        self.file_contents = self.found
