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
        document = load(paths[-1], findings)
        spec = (
            validate(RobotSpec, document, _without_removals(document.data), findings) if document is not None else None
        )
        if document is None or spec is None:
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
        _remove(data, loaded.document, findings)
        data = _merge(data, _without_removals(loaded.document.data))
    spec = validate(RobotSpec, chain[0].document, data, findings)
    return RobotFile(spec, tuple(chain)) if spec is not None else None


def _removals(data: Any) -> list[tuple[str, str]]:
    """Return the section and the name of each entry that a file removes from the file that it extends: those with a null."""
    if not isinstance(data, dict) or not data.get("extends"):
        return []
    sections = {name: data[name] for name in _SECTIONS if isinstance(data.get(name), dict)}
    return [(name, entry) for name, entries in sections.items() for entry, value in entries.items() if value is None]


def _without_removals(data: Any) -> Any:
    """Return the data of a file without the entries that it removes."""
    removals = _removals(data)
    sections = {section for section, _ in removals}
    kept = {name: {key: v for key, v in data[name].items() if (name, key) not in removals} for name in sections}
    return {**data, **kept} if removals else data


def _remove(data: dict[str, Any], document: Document, findings: Findings) -> None:
    """Remove the entries that a file removes from the merged data of the files that it extends."""
    for section, name in _removals(document.data):
        entries = data.get(section, {})
        if name not in entries:
            text = f"{section}: null removes an entry of the file that this file extends, which has no {name!r}"
            near = did_you_mean(name, entries) or listing(entries, "entries")
            findings.add("G106", text, document.key_span(section, name), near)
        entries.pop(name, None)


def _merge(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return `base` with `changes`: nested mappings are merged key by key, any other value replaces the value of `base`."""
    replaced = {a for one, other in _ALTERNATIVES for a, b in ((one, other), (other, one)) if b in changes}
    merged = {key: value for key, value in base.items() if key not in replaced}
    for key, value in changes.items():
        old = merged.get(key)
        merged[key] = _merge(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return merged
