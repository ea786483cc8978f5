"""What a session does when the files that it was made from change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from graphengine.format.errors import UsageError
from graphengine.format.files import Signature, near


@dataclass(frozen=True, slots=True, kw_only=True)
class Reloaded:
    """What a reload did. `Session.reload` returns it; its text is one line for people.

    Attributes:
        files: files that are not what they were when they were read last, those that have come or gone among them.
        changed: names of the graphs that were exchanged; all graphs after a restart.
        added: names of the graphs that were not there before.
        removed: names of the graphs that run no more.
        kept: number of nodes of the exchanged graphs that keep their state.
        nodes: number of nodes of the exchanged graphs.
        restarted: whether the world or a robot changed, so that the session began anew at time 0.
        lost: names of the spawned robots that the restart removed.
        warnings: warnings about the new files, as text.
        mended: whether the files had errors at the reload before.
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
        files = ", ".join(near(str(path)) for path in self.files)
        effect = self._restart() if self.restarted else self._exchange()
        return f"{'mended: ' if self.mended else ''}{files or 'no file'} changed: {effect}"

    def _restart(self) -> str:
        lost = f"; {', '.join(self.lost)} must be spawned again" if self.lost else ""
        return f"the world is another one; restarted at t = 0{lost}"

    def _exchange(self) -> str:
        named = {"exchanged": self.changed, "added": self.added, "removed": self.removed}
        effects = [f"{what} {', '.join(names)}" for what, names in named.items() if names]
        if self.changed:
            effects.append(f"{self.kept} of {self.nodes} nodes keep their state")
        return "; ".join(effects) or "no graph and nothing of the world is different"


class Reloader:
    """Reads the files of a session again. A session that was made from files has one that extends this."""

    def reload(self) -> Reloaded:
        """Run what the files say now, between two ticks.

        Raises:
            CheckError: the files have errors.
            GraphError: the changed scene cannot begin. After any error nothing has changed.
        """
        raise UsageError("a session without files has nothing to reload")

    def watched(self) -> Mapping[Path, Signature]:
        """The paths whose files matter, with what was there when they were read last. Any thread may call it."""
        return {}
