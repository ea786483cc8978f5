"""Permissions that a user grants to graph files: to read files and named environment variables, and to run Python code.

By default, graphs may neither read environment variables nor run code: a variable can be a secret, which a topic would
publish, and code can do anything.
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
    """What the nodes of graphs may read and run.

    Attributes:
        files: folders from which nodes may read files; None: nodes may not read files.
        environment: values of the environment variables that nodes may read, by name; empty for a variable that is not set.
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
            ContextError: the file does not exist, graphs are not permitted to read it, it is too large, or it is not UTF-8.
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
            ContextError: the user does not allow it.
        """
        if not self.scripts:
            advice = "read the code, then allow it with --allow-scripts"
            raise ContextError("the node runs Python code, which graphs may not do by default", None, advice)
