"""Nodes that read environment variables and files of the machine that runs the graph (`isaacsim.core.nodes`).

The nodes read variables and files once, before the first tick.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import Bound, Context, In, Node, Out, String


class IsaacReadEnvVar(Node, type="isaacsim.core.nodes.IsaacReadEnvVar"):
    """Outputs the value of an environment variable. The user must allow this variable with the option `--env NAME`."""

    env_var: String = In(default="", setup=True, required=True, doc="name of the variable")
    value: String = Out(doc="value of the variable; empty if it is not set")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read the environment variable.

        Raises:
            ContextError: the user does not allow graphs to read the variable.
        """
        self.found = context.environment(self.env_var)

    def compute(self) -> None:
        """Output the value that `setup` read."""
        self.value = self.found


class IsaacReadFilePath(Node, type="isaacsim.core.nodes.IsaacReadFilePath"):
    """Outputs the text of a file.

    The file must be in the graph file's folder, among the graphs and scenes that come with graphengine, or in a folder given by
    the option `--allow`.
    """

    path: Any = In(type="path", default="", setup=True, required=True, doc="path, relative to the graph file's folder")
    file_contents: Any = Out(type="string|token")

    found: str = Bound()

    def setup(self, context: Context) -> None:
        """Read the file.

        Raises:
            ContextError: the file does not exist, may not be read, is too large, or is not UTF-8 text.
        """
        self.found = context.read_file(self.path)[1]

    def compute(self) -> None:
        """Output the text that `setup` read."""
        self.file_contents = self.found
