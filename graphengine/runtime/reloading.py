"""Interface through which a session reloads its files, and the result of a reload."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphengine.compiler.graph import Graph
from graphengine.format.errors import UsageError
from graphengine.format.files import Signature, near
from graphengine.runtime.addresses import NodePort

MOST_NAMES = 4
"""Maximum number of names in one list of the summary of a reload."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reloaded:
    """The result of `Session.reload`; `str()` returns a summary in one line.

    Attributes:
        files: files that were changed, added or removed since the previous reload.
        changed: names of the changed graphs, which were replaced; all graphs after a restart.
        added: names of new graphs.
        removed: names of removed graphs.
        kept: number of nodes of the changed graphs that keep their state.
        nodes: number of all nodes of the changed graphs.
        restarted: whether a change of the world or of a robot restarted the session at time 0.
        lost: names of the spawned robots that the restart removed.
        warnings: warnings about the new files, as text.
        mended: whether the previous reload failed because of errors that are now corrected.
    """

    files: tuple[Path, ...] = ()
    changed: tuple[str, ...] = ()
    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    kept: int = 0
    nodes: int = 0
    restarted: bool = False
    lost: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    mended: bool = False

    def __str__(self) -> str:
        files = _listed([near(str(path)) for path in self.files])
        effect = self._restart() if self.restarted else self._exchange()
        return f"{'mended: ' if self.mended else ''}{files or 'no file'} changed: {effect}"

    def _restart(self) -> str:
        lost = f"; {_listed(self.lost)} must be spawned again" if self.lost else ""
        return f"the world changed; restarted at t = 0{lost}"

    def _exchange(self) -> str:
        named = {"exchanged": self.changed, "added": self.added, "removed": self.removed}
        effects = [f"{what} {_listed(names)}" for what, names in named.items() if names]
        if self.changed:
            effects.append(f"{self.kept} of {self.nodes} nodes keep their state")
        return "; ".join(effects) or "graphs and world are unchanged"


def _listed(names: Sequence[str]) -> str:
    """Return up to `MOST_NAMES` names and the number of the other names, such as `a, b, c, d and 2 more`."""
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


class Reloader:
    """Reloads the files of a session; this base class is for a session without files and refuses to reload."""

    def reload(self) -> Reloaded:
        """Read the files again and let the session run the changed scene; only between two ticks.

        After an error, the session continues unchanged.

        Raises:
            CheckError: the files have errors.
            GraphError: the changed scene cannot start.
            UsageError: the session was not loaded from files.
        """
        raise UsageError("the session was not loaded from files, so it cannot be reloaded")

    def save(self) -> Any:
        """Return the version of the files that the session runs, in a form for `restore`."""

    def restore(self, saved: Any) -> None:
        """Let the session run the version of the files that `save` returned, from time 0.

        Args:
            saved: result of `save`.

        Raises:
            GraphError: physics or a node cannot start; the session continues unchanged.
        """

    def propose_value(self, port: NodePort, value: Any) -> Any:
        """Return the change of a file that writes a value of an input; see `scene.value_edits`.

        Raises:
            UsageError: the session was not loaded from files, or no file can be changed.
        """
        raise UsageError("the session was not loaded from files, so no value can be saved")

    def propose_position(self, graph: Graph, node: str, at: Sequence[float]) -> Any:
        """Return the change of a graph file that writes the position of a node in drawings.

        Raises:
            UsageError: the session was not loaded from files, or the file cannot be changed.
        """
        raise UsageError("the session was not loaded from files, so no position can be saved")

    def write(self, change: Any) -> None:
        """Write a proposed change, and reload."""

    def undo(self) -> Any:
        """Take back the newest change and return it."""
        raise UsageError("the session was not loaded from files, so there is no change to undo")

    def redo(self) -> Any:
        """Write the change that was undone last, and return it."""
        raise UsageError("the session was not loaded from files, so there is no undone change")

    def watched(self) -> Mapping[Path, Signature]:
        """Return each path to watch for changes, with the file's signature from before the reading. Thread-safe."""
        return {}
