"""Merges a robot file and the robot files that it extends into one spec, and keeps track of the file of each value."""

from __future__ import annotations

import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Document, load
from graphengine.format.files import Files
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.spec_reader import Loaded, validate
from graphengine.format.wording import did_you_mean, listing

MAX_CHAIN = 10
"""Maximum number of robot files in a chain of files that extend each other."""
_ALTERNATIVES = (("drive", "usd_drive"), ("rpy_deg", "quaternion_xyzw"))
"""Pairs of keys with the same meaning: a key of one file replaces the other key of the file that it extends."""

_SECTIONS = [name for name, field in RobotSpec.model_fields.items() if typing.get_origin(field.annotation) is dict]
"""Keys whose values are mappings of named entries, such as `graphs`."""


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
        """Return the first document of the chain that contains a value; the first document if none contains it.

        Args:
            location: keys and indices that lead to the value.
        """
        holders = (loaded.document for loaded in self.chain if loaded.document.find(*location) is not None)
        return next(holders, self.chain[0].document)

    def span(self, *location: str | int) -> Span:
        """Return the position of a value in its file; `location` has the keys and indices that lead to the value."""
        return self.document(*location).span(*location)

    def key_span(self, *location: str | int) -> Span:
        """Return the position of a value's key in its file; `location` has the keys and indices that lead to the value."""
        return self.document(*location).key_span(*location)

    def folder(self, *location: str | int) -> Path:
        """Return the folder of the file that contains a value. A relative path in the value starts from this folder."""
        return self.document(*location).path.parent


def read_robot(path: Path, files: Files, findings: Findings) -> RobotFile | None:
    """Read a robot file and the files that it extends; return None after an error, which is added to `findings`."""
    chain: list[Loaded[RobotSpec]] = []
    paths = [path]
    while True:
        document = load(paths[-1], findings)
        if document is None:
            return None
        extends = isinstance(document.data, dict) and "extends" in document.data
        spec = validate(RobotSpec, document, _merge({}, document.data) if extends else document.data, findings)
        if spec is None:
            return None
        chain.append(loaded := Loaded(spec, document))
        if not loaded.spec.extends:
            break
        span = loaded.document.span("extends")
        extended = files.look_up(loaded.spec.extends, loaded.folder, findings, span)
        if extended is None:
            return None
        paths.append(extended)
        if paths[-1].resolve() in [path.resolve() for path in paths[:-1]] or len(paths) > MAX_CHAIN:
            way = " extends ".join(path.name for path in paths)
            circle = "robot files extend each other in a circle"
            text = circle if len(paths) <= MAX_CHAIN else f"more than {MAX_CHAIN} robot files extend each other"
            findings.add("S103", f"{text}: {way}", span)
            return None
    if len(chain) == 1:
        return RobotFile(chain[0].spec, tuple(chain))
    data: dict[str, Any] = {}
    for loaded in reversed(chain):
        _check_removals(data, loaded.document, findings)
        data = _merge(data, loaded.document.data)
    spec = validate(RobotSpec, chain[0].document, data, findings)
    return RobotFile(spec, tuple(chain)) if spec is not None else None


def _check_removals(base: dict[str, Any], document: Document, findings: Findings) -> None:
    """Add an error for each null of a file that removes an entry which the extended files do not have."""
    for section in _SECTIONS:
        entries = base.get(section, {})
        for name, value in (document.data.get(section) or {}).items():
            if value is None and name not in entries:
                text = f"{section}: null removes an entry of the file that this file extends, which has no {name!r}"
                near = did_you_mean(name, entries) or listing(entries, "entries")
                findings.add("G106", text, document.key_span(section, name), near)


def _merge(base: dict[str, Any], changes: dict[str, Any], depth: int = 0) -> dict[str, Any]:
    """Return `base` with `changes`: nested mappings are merged key by key, any other value replaces the value of `base`.

    Null removes an entry of a section; `depth` is 0 for whole files, and 1 for sections.
    """
    removable = depth == 1
    replaced = {a for one, other in _ALTERNATIVES for a, b in ((one, other), (other, one)) if b in changes}
    replaced |= {key for key, value in changes.items() if value is None and removable}
    merged = {key: value for key, value in base.items() if key not in replaced}
    for key, value in changes.items():
        old = merged.get(key, {} if depth == 0 and key in _SECTIONS else None)
        if isinstance(old, dict) and isinstance(value, dict):
            merged[key] = _merge(old, value, depth + 1)
        elif value is not None or not removable:
            merged[key] = value
    return merged
