"""What the confined processes that read stages have in common: open a stage, read it, and answer with what was read."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any, Generic, NoReturn, Protocol, TypeVar

from pxr import Tf, Usd

from graphengine.descriptions.usd.layers import UnreadableError, confined, open_stage, reason
from graphengine.format.files import Files
from graphengine.sandbox.untrusted import answer


class _StageContents(Protocol):
    left_out: list[tuple[str, str]]
    failure: str
    used: list[str]


_Contents = TypeVar("_Contents", bound=_StageContents)


class ConfinedReading(Generic[_Contents]):
    """Reader of one stage; a subclass reads one subject into `contents`.

    Args:
        files: decides which files may be read.
        choice: what to read, as `open_stage` takes it.
    """

    contents: _Contents

    def __init__(self, files: Files, **choice: Any) -> None:
        self.files = files
        self.choice = choice

    def run(self, path: Path) -> _Contents:
        """Open a stage and return what was read; if the stage cannot be read, return the reason as `failure`."""
        try:
            stage, self.contents.left_out = open_stage(path, self.files, **self.choice)
            self.read(stage)
        except UnreadableError as error:
            self.contents.failure = str(error)
        except (Tf.ErrorException, UnicodeDecodeError) as error:
            self.contents.failure = reason(error)
        self.contents.used = [str(used) for used in self.files.used]
        return self.contents

    def read(self, stage: Usd.Stage) -> None:
        """Read an open stage into `contents`.

        Raises:
            UnreadableError: the stage cannot be read.
        """
        raise NotImplementedError

    @classmethod
    def serve(cls) -> NoReturn:
        """Read a request from stdin, confine this process, read the stage, and write `contents` to stdout."""
        request = json.load(sys.stdin)
        files = Files(tuple(map(Path, request["roots"])))
        stream = confined(files)
        reading = cls(files, **request["choice"])
        answer(stream, lambda: reading.run(Path(request["path"])))


def prims(stage: Usd.Stage) -> Any:
    """Return an iterable of the active prims of a stage, those of instances too, in stage order."""
    return stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimIsActive & ~Usd.PrimIsAbstract))
