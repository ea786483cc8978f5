"""Permissions that a user gives to graph files: to read environment variables by name, and to run Python.

By default graphs have neither, since a variable may be a secret that a topic would publish, and code may do anything.
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
"""Maximum size of a file that a node reads, bytes."""


@dataclass(frozen=True, slots=True)
class Permissions:
    """Permissions of graphs.

    Attributes:
        files: folders that may be read; None: no files can be read.
        environment: readable environment variables with their values; unset ones are empty.
        scripts: whether graphs may run Python.
    """

    files: Files | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    scripts: bool = False

    def variable(self, name: str) -> str:
        """Return the value of an environment variable.

        Raises:
            ContextError: the variable may not be read.
        """
        if name not in self.environment:
            allow = f"allow it with --env {name}" if name.isidentifier() else "write the name of one variable"
            near = did_you_mean(name, self.environment)
            raise ContextError(f"the environment variable {name!r} may not be read", name, allow, near)
        return self.environment[name]

    def read(self, reference: str, folder: Path) -> tuple[Path, str]:
        """Read a text file to which a graph file in `folder` refers; return its path and content.

        Raises:
            ContextError: the file does not exist, may not be read, is too large, or is not text.
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
        """Check that graphs may run Python.

        Raises:
            ContextError: the user does not allow it.
        """
        if not self.scripts:
            advice = "read the code, then allow it with --allow-scripts"
            raise ContextError("it runs Python code, which graphs may not do by default", None, advice)
