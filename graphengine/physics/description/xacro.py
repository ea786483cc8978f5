"""Expands xacro files to URDF in a confined process with a time limit.

The result is a tree of elements, each with its position in the xacro file.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.description.dom import unwritable
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS, Element
from graphengine.sandbox.borders import warn
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import Sources, encoded, note_used, read, take_findings

MAX_SECONDS = 30.0
MAX_ANSWER = 200_000_000
SUFFIX = ".xacro"
_FIND = re.compile(rb"\$\(find\s+([\w.-]+)\)")
_PROCESS = "graphengine.physics.description.xacro_process"


@dataclass(slots=True)
class Expanded:
    """The output of the process.

    Attributes:
        elements: elements of the document in order, each with its depth and without its children; empty after errors.
        known: names of the arguments that the files declare.
        findings: errors.
        wanted: a package that the process needs first.
        used: files that were read.
    """

    elements: list[tuple[int, Element]]
    known: set[str]
    findings: list[Finding]
    wanted: str | None
    used: list[str]


def is_xacro(path: Path, root: Element) -> bool:
    """Return whether a description must be expanded; not every xacro file has a suffix that says so."""

    def holds(element: Element) -> bool:
        return element.tag.startswith("xacro:") or any("$(" in v or "${" in v for v in element.attributes.values())

    return path.suffix == SUFFIX or any(holds(element) for element in root.walk())


def expand(
    path: Path,
    arguments: Mapping[str, str],
    packages: Packages,
    findings: Findings,
    places: Mapping[str, Span] = MappingProxyType({}),
) -> Element | None:
    """Return the robot that a xacro file describes.

    Args:
        path: xacro file.
        arguments: values of its `xacro:arg` elements.
        packages: packages for `$(find …)`, which also decide which files may be read.
        findings: receives errors.
        places: positions of the arguments in files, by name.
    """
    start = Span(Source(str(path), ()), 1, 1)
    warn(findings)
    before = len(findings.errors)
    try:
        answer = _ask(path, arguments, packages)
        take_findings(answer.findings, findings)
        root = _joined(answer.elements) if answer.elements else None
        if root is None and len(findings.errors) == before:
            raise ProcessError("sends a malformed answer", b"")
    except ProcessError as error:
        findings.add("S103", f"xacro: {error}", start)
        return None
    note_used(answer.used, packages.files)
    unknown = [name for name in arguments if name not in answer.known] if root is not None else []
    for name in unknown:
        near = did_you_mean(name, answer.known) or listing(answer.known, "its arguments")
        findings.add("G111", f"{str(path)!r} has no argument {name!r}", places.get(name), near)
    return None if unknown else root


def _ask(path: Path, arguments: Mapping[str, str], packages: Packages) -> Expanded:
    """Run the process that expands a xacro file, and return its answer.

    Where workspaces are sourced, the process may read only those of their packages that the files name: it is run again for
    each that turns up.
    """
    installed = packages.files.installed
    roots = [str(root) for root in packages.files.roots if root not in {folder.resolve() for folder in installed}]
    found: dict[str, str | list[str]] = {}
    named = _names(path, installed) if installed else []
    span = Sources(packages.files).span
    end = time.monotonic() + MAX_SECONDS
    while (left := round(end - time.monotonic(), 1)) > 0:
        for name in named:
            folder = packages.find(name)
            found[name] = str(folder) if folder is not None else packages.lacks(name)
        folders = [folder for folder in found.values() if isinstance(folder, str)]
        shares = [folder for folder in folders if any(map(Path(folder).is_relative_to, installed))]
        request = {
            "path": str(path),
            "folder": str(packages.folder),
            "arguments": dict(arguments),
            "paths": [str(folder) for folder in packages.paths],
            "roots": [*roots, *(str(Path(folder).resolve()) for folder in shares)],
            "installed": shares,
            "found": found if installed else None,
        }
        answer = read(ask(_PROCESS, encoded(request).encode(), left), Expanded, MAX_ANSWER, span)
        if answer.wanted is None:
            return answer
        named = [answer.wanted]
    raise ProcessError(f"takes more than {MAX_SECONDS:g} s", b"")


def _names(path: Path, installed: Sequence[Path]) -> list[str]:
    """Return the installed packages that a file names, and the package that contains the file."""
    around = [folder.name for folder in path.absolute().parents if folder.parent in installed]
    with path.open("rb") as file:
        named = {name.decode() for name in _FIND.findall(file.read(MAX_BYTES))}
    return [*around, *(name for share in installed if share.is_dir() for name in sorted(named & {*os.listdir(share)}))]


def _joined(parts: Sequence[tuple[int, Element]]) -> Element:
    """Join elements, each with its depth, to a tree and return its root.

    Raises:
        ProcessError: the elements are none of one document, or XML cannot hold them.
    """
    above: list[Element] = []
    for depth, element in parts[: MAX_ELEMENTS + 1]:
        fits = min(len(above), 1) < depth <= min(len(above), MAX_DEPTH - 1) + 1
        if not fits or element.children or unwritable(element) or len(parts) > MAX_ELEMENTS:
            raise ProcessError("sends a malformed answer", b"")
        del above[depth - 1 :]
        if above:
            above[-1].children.append(element)
        above.append(element)
    return above[0]
