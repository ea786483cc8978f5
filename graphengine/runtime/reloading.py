"""What a session does when the files that it was made from change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.format.errors import UsageError
from graphengine.format.files import Signature, near
from graphengine.runtime.ticker import Exchange

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore


@dataclass(frozen=True, slots=True)
class Reloaded:
    """What reloading did.

    Attributes:
        files: those that have changed, come or gone since they were read last.
        exchange: of the graphs; of a restart, their names alone.
        restarted: whether the world or a robot changed, so that the session began anew at time 0.
        lost: robots that were spawned and did not survive the restart.
        warnings: of the new files, a text each.
        mended: whether the files had errors before.
    """

    files: tuple[Path, ...] = ()
    exchange: Exchange = Exchange()
    restarted: bool = False
    lost: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    mended: bool = False

    def __str__(self) -> str:
        files = ", ".join(near(str(path)) for path in self.files) or "no file"
        return f"{'mended: ' if self.mended else ''}{files} changed: {'; '.join(self._effects())}"

    def _effects(self) -> list[str]:
        exchange = self.exchange
        if self.restarted:
            lost = [f"without {', '.join(self.lost)}, spawned before"] if self.lost else []
            return ["the world is another one, so the run begins anew at t = 0", *lost]
        named = {"graph": exchange.changed, "new graph": exchange.added, "removed graph": exchange.removed}
        effects = [f"{what} {', '.join(names)}" for what, names in named.items() if names]
        if exchange.changed:
            effects.append(f"{exchange.kept} of {exchange.nodes} nodes keep their state")
        return effects or ["the graphs and the world are the same"]

    def record(self) -> dict[str, Any]:
        """What reloading did as JSON types."""
        return {
            "files": [str(path) for path in self.files],
            "changed": list(self.exchange.changed),
            "added": list(self.exchange.added),
            "removed": list(self.exchange.removed),
            "restarted": self.restarted,
            "lost": list(self.lost),
            "warnings": list(self.warnings),
            "text": str(self),
        }

    def as_mended(self) -> Reloaded:
        """The same after files with errors."""
        return replace(self, mended=True)


class Reloader:
    """Reads the files of a session again. A session that was made from files has one that extends this."""

    def reload(self, session: SessionCore) -> Reloaded:
        """Run what the files say now, between two ticks.

        Raises:
            CheckError: the files have errors.
            GraphError: the changed scene cannot begin. After any error nothing has changed.
        """
        raise UsageError("a session without files has nothing to reload")

    def watched(self) -> Mapping[Path, Signature]:
        """The paths whose files matter, with what was there when they were read last. Any thread may call it."""
        return {}
