"""Meshes that MuJoCo cannot read, converted all at once in a process of their own, which bounds what a file can ask for.

A request is a line of JSON and the files one after another. Each file is answered when it is done, by its length in eight bytes,
a line of JSON and the files that it became: a process that is ended has told by then which file it was at.
"""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from graphengine.world.files import meshes
from graphengine.world.files.confinement import ProcessError, ask, bound

MAX_SECONDS = 60.0

_MODULE = "graphengine.world.files.conversion"  # which is called __main__ in the process


@dataclass(frozen=True, slots=True)
class Foreign:
    """A file that MuJoCo cannot read.

    Attributes:
        data: what is in it.
        suffix: of its name, in lower case.
        visual: whether its colours count.
    """

    data: bytes
    suffix: str
    visual: bool


@dataclass(frozen=True, slots=True)
class Converted:
    """A file of MuJoCo's own format, and the colour of what is in it."""

    data: bytes
    colour: meshes.Colour | None


def convert_all(files: Sequence[Foreign]) -> list[list[Converted] | meshes.MeshError]:
    """What each file becomes: one file a colour if it is looked at, else one; or why it cannot be read."""
    if not files:
        return []
    head = json.dumps([(file.suffix, file.visual, len(file.data)) for file in files])
    request = b"".join((head.encode(), b"\n", *(file.data for file in files)))
    why = "ended before its time"
    try:
        answer = ask(_MODULE, request, MAX_SECONDS)
    except ProcessError as error:
        answer, why = error.answer, str(error)
    found = list(_answers(answer))
    found += [meshes.MeshError(f"reading it {why}")] if len(found) < len(files) else []
    return found + [meshes.MeshError(f"reading one before it {why}")] * (len(files) - len(found))


def _answers(answer: bytes) -> Iterator[list[Converted] | meshes.MeshError]:
    """The answers that are complete."""
    stream = io.BytesIO(answer)
    while len(head := stream.read(8)) == 8:
        length = int.from_bytes(head, "little")
        if len(told := stream.read(length)) < length:
            return
        yield _answer(io.BytesIO(told))


def _answer(told: io.BytesIO) -> list[Converted] | meshes.MeshError:
    line = json.loads(told.readline())
    if isinstance(line, str):
        return meshes.MeshError(line)
    return [Converted(told.read(length), tuple(colour) if colour else None) for length, colour in line]


@lru_cache(maxsize=1)  # the same file may follow for another use
def _parts(data: bytes, suffix: str) -> list[meshes.Part]:
    return meshes.convert(data, suffix)


def _converted(data: bytes, suffix: str, *, visual: bool) -> bytes:
    line: Any
    try:
        parts = _parts(data, suffix)
    except meshes.MeshError as error:
        line, files = str(error), []
    else:
        parts = parts if visual else [meshes.merged(parts)]
        files = [meshes.msh(part) for part in parts]
        line = [(len(file), part.colour) for file, part in zip(files, parts, strict=True)]
    return b"".join((json.dumps(line).encode(), b"\n", *files))


def main() -> None:
    """Answer one request."""
    wanted = json.loads(sys.stdin.buffer.readline())
    bound()
    for suffix, visual, length in wanted:
        told = _converted(sys.stdin.buffer.read(length), suffix, visual=visual)
        sys.stdout.buffer.write(len(told).to_bytes(8, "little") + told)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
