"""Converts meshes that MuJoCo cannot read, many at a time in one confined process with limits on time and memory.

The request to the process is a line of JSON, followed by the files. The process answers each file as soon as it is converted:
length in eight bytes, a line of JSON, and the converted files. If the process is killed, the caller knows which file caused it.
"""

from __future__ import annotations

import io
import itertools
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from graphengine.descriptions.files import meshes
from graphengine.format.files import Files
from graphengine.sandbox.confinement import ProcessError, ask, confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.untrusted import encoded, read

MAX_SECONDS = 60.0
"""Maximum time to convert a mesh, s."""

MAX_REASON = 300
"""Maximum length of the reason why a file cannot be read, characters; longer reasons are cut."""
MAX_HEAD_BYTES = 4_000_000
"""Maximum size of the JSON text that describes converted meshes, bytes."""

_MODULE = "graphengine.descriptions.files.conversion"  # which is called __main__ in the process


@dataclass(frozen=True, slots=True)
class Foreign:
    """A mesh file that MuJoCo cannot read and that is to be converted.

    Attributes:
        data: content of the file.
        suffix: suffix of the file name, in lower case.
        visual: whether the mesh is a visual; then its colours are kept, and it is split into one converted file per colour.
    """

    data: bytes
    suffix: str
    visual: bool


@dataclass(frozen=True, slots=True)
class Converted:
    """A converted mesh in MuJoCo's MSH format, and its colour; None if it has no colour."""

    data: bytes
    colour: meshes.Colour | None


@dataclass(frozen=True, slots=True)
class _Head:
    """The first line of an answer: the reason why the file cannot be read, or (bytes, colour) of each converted file."""

    failure: str
    files: list[tuple[int, meshes.Colour | None]]


def convert_all(files: Sequence[Foreign]) -> list[list[Converted] | meshes.MeshError]:
    """Convert mesh files; return a list of converted files for each file, or an error if the file cannot be read.

    A visual mesh becomes one converted file per colour, any other mesh a single converted file.
    """
    if not files:
        return []
    head = json.dumps([(file.suffix, file.visual, len(file.data)) for file in files])
    request = b"".join((head.encode(), b"\n", *(file.data for file in files)))
    why = "ended too early"
    try:
        answer = ask(_MODULE, request, MAX_SECONDS)
    except ProcessError as error:
        answer, why = error.answer, str(error)
    found = list(itertools.islice(_answers(answer), len(files)))
    found += [meshes.MeshError(f"reading the file {why}")] if len(found) < len(files) else []
    return found + [meshes.MeshError(f"reading an earlier file {why}")] * (len(files) - len(found))


def _answers(answer: bytes) -> Iterator[list[Converted] | meshes.MeshError]:
    """Yield each answer that is complete in the output of the process."""
    stream = io.BytesIO(answer)
    while len(head := stream.read(8)) == 8:
        length = int.from_bytes(head, "little")
        if len(text := stream.read(length)) < length:
            return
        yield _answer(io.BytesIO(text))


def _answer(stream: io.BytesIO) -> list[Converted] | meshes.MeshError:
    try:
        head = read(stream.readline(), _Head, MAX_HEAD_BYTES)
        if head.failure:
            return meshes.MeshError(head.failure[:MAX_REASON])
        return [Converted(stream.read(length), colour) for length, colour in head.files]
    except (ProcessError, OverflowError):
        return meshes.MeshError("the process that reads the file sends a malformed answer")


_parts = lru_cache(maxsize=1)(meshes.convert)  # the next file may be the same file, as a visual instead of a collider


def _converted(data: bytes, suffix: str, *, visual: bool) -> bytes:
    try:
        parts = _parts(data, suffix)
    except meshes.MeshError as error:
        head, files = _Head(str(error) or type(error).__name__, []), []
    else:
        parts = parts if visual else [meshes.merged(parts)]
        files = [meshes.msh(part) for part in parts]
        head = _Head("", [(len(file), part.colour) for file, part in zip(files, parts, strict=True)])
    return b"".join((encoded(head).encode(), b"\n", *files))


def main() -> None:
    """Read a request from standard input, convert its files, and write one answer per file to standard output."""
    wanted = json.loads(sys.stdin.buffer.readline())
    meshes.prepare({suffix for suffix, _, _ in wanted})
    sys.meta_path.clear()  # further imports fail, as if the modules were not installed
    confine(Files(()), TIERS["mesh"])
    for suffix, visual, length in wanted:
        answer = _converted(sys.stdin.buffer.read(length), suffix, visual=visual)
        sys.stdout.buffer.write(len(answer).to_bytes(8, "little") + answer)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
