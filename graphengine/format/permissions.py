"""Permissions that a user grants to graph files: to read files and named environment variables, and to run Python code.

By default, graphs may not read environment variables, because a topic could publish a secret, and may not run code, because code
can do anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.format.errors import ContextError
from graphengine.format.files import Files, NotFoundError
from graphengine.format.regular_files import open_regular
from graphengine.format.wording import did_you_mean

LARGEST_FILE = 10_000_000
"""Maximum size of a file that a node may read, bytes."""


@dataclass(frozen=True, slots=True)
class Permissions:
    """The permissions of the nodes of graphs.

    Attributes:
        files: folders from which nodes may read files; None: nodes may not read files.
        environment: value of each environment variable that nodes may read, by name; empty for a variable that is not set.
        scripts: whether graphs may run Python code without a sandbox.
    """

    files: Files | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    scripts: bool = False

    def variable(self, name: str) -> str:
        """Return the value of an environment variable.

        Raises:
            ContextError: the user does not allow graphs to read the variable.
        """
        if name not in self.environment:
            allow = f"allow it with --env {name}" if name.isidentifier() else "write the name of one variable"
            near = did_you_mean(name, self.environment)
            raise ContextError(f"the environment variable {name!r} may not be read", name, allow, near)
        return self.environment[name]

    def read(self, reference: str, folder: Path) -> tuple[Path, str]:
        """Return the path and content of the text file that a graph file in `folder` refers to as `reference`.

        Raises:
            ContextError: the file does not exist, is too large or is not UTF-8, or graphs are not permitted to read it.
        """
        if self.files is None:
            raise ContextError("graphs may not read files in this session", reference)
        try:
            path = self.files.find(reference, folder)
        except NotFoundError as error:
            raise ContextError(error.message, reference, *error.help) from None
        try:
            with open_regular(path) as file:
                data = file.read(LARGEST_FILE + 1)
            if len(data) > LARGEST_FILE:
                raise ContextError(f"{path} is larger than {LARGEST_FILE} bytes", reference)
            return path, data.decode("utf-8")
        except UnicodeDecodeError:
            raise ContextError(f"{path} is not UTF-8 text", reference) from None
        except OSError as error:
            raise ContextError(f"{path} cannot be read: {error.strerror}", reference) from None

    def require_scripts(self) -> None:
        """Check that graphs may run Python code without a sandbox.

        Raises:
            ContextError: graphs may not run Python code in this session.
        """
        if not self.scripts:
            what = "the node runs Python code, but graphs are not permitted to run code by default"
            raise ContextError(what, None, "read the code, then allow it with --allow-scripts")
