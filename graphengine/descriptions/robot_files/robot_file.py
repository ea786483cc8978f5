"""Merges a robot file and the robot files that it extends into one spec, and keeps track of the file of each value."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Document
from graphengine.format.files import Files
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.spec_reader import Loaded, read, validate

MAX_CHAIN = 10
"""Maximum number of robot files in a chain of files that extend each other."""
_ALTERNATIVES = (("drive", "usd_drive"), ("rpy_deg", "quaternion_xyzw"))
"""Pairs of keys with the same meaning: a key of one file replaces the other key of the file that it extends."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotFile:
    """A robot file, merged with the files that it extends.

    Attributes:
        spec: merged contents of all files.
        chain: the file itself, the file that it extends, and so on.
    """

    spec: RobotSpec
    chain: tuple[Loaded[RobotSpec], ...]

    def document(self, *location: str | int) -> Document:
        """Return the first document of the chain that has a value at a location (keys and indices); else the file itself."""
        holders = (loaded.document for loaded in self.chain if loaded.document.find(*location) is not None)
        return next(holders, self.chain[0].document)

    def span(self, *location: str | int) -> Span:
        """Return the source location of the value at a location (keys and indices)."""
        return self.document(*location).span(*location)

    def key_span(self, *location: str | int) -> Span:
        """Return the source location of the key of the value at a location (keys and indices)."""
        return self.document(*location).key_span(*location)

    def folder(self, *location: str | int) -> Path:
        """Return the folder of the file that contains the value at a location; relative paths there start from it."""
        return self.document(*location).path.parent


def read_robot(path: Path, files: Files, findings: Findings) -> RobotFile | None:
    """Read a robot file and the files that it extends; return None after an error, which is added to `findings`."""
    chain: list[Loaded[RobotSpec]] = []
    paths = [path]
    while True:
        loaded = read(RobotSpec, paths[-1], findings)
        if loaded is None:
            return None
        chain.append(loaded)
        if not loaded.spec.extends:
            break
        span = loaded.document.span("extends")
        extended = files.look_up(loaded.spec.extends, loaded.folder, findings, span)
        if extended is None:
            return None
        paths.append(extended)
        if paths[-1].resolve() in [path.resolve() for path in paths[:-1]] or len(paths) > MAX_CHAIN:
            way = " extends ".join(path.name for path in paths)
            findings.add(
                "S103",
                f"robot files extend each other in a circle: {way}"
                if len(paths) <= MAX_CHAIN
                else f"more than {MAX_CHAIN} robot files extend each other: {way}",
                span,
            )
            return None
    if len(chain) == 1:
        return RobotFile(chain[0].spec, tuple(chain))
    data: dict[str, Any] = {}
    for loaded in reversed(chain):
        data = _merge(data, loaded.document.data)
    spec = validate(RobotSpec, chain[0].document, data, findings)
    return RobotFile(spec, tuple(chain)) if spec is not None else None


def _merge(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return `base` with `changes`: nested mappings are merged key by key, any other value replaces the value of `base`."""
    replaced = {a for one, other in _ALTERNATIVES for a, b in ((one, other), (other, one)) if b in changes}
    merged = {key: value for key, value in base.items() if key not in replaced}
    for key, value in changes.items():
        old = merged.get(key)
        merged[key] = _merge(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return merged
