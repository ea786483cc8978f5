"""Expands xacro files to URDF in a confined process with a time limit.

The result is a tree of elements, each with its source location in the xacro files.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS, Element
from graphengine.descriptions.xacro.absent_packages import AbsentPackage, UnknownCall, report
from graphengine.descriptions.xacro.dom import unwritable
from graphengine.format.diagnostics import Finding, Findings, Source, Span
from graphengine.format.wording import did_you_mean, listing
from graphengine.sandbox.borders import warn
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import Sources, encoded, note_used, read, take_findings

MAX_SECONDS = 30.0
"""Maximum run time of xacro, s."""
MAX_ANSWER = 200_000_000
"""Maximum size of the URDF that xacro makes, bytes."""
SUFFIX = ".xacro"
_FIND = re.compile(rb"\$\(find\s+([\w.-]+)\)")
_PROCESS = "graphengine.descriptions.xacro.xacro_process"


@dataclass(slots=True)
class Expanded:
    """The response of the process that expands a file.

    Attributes:
        elements: (depth, element) of the expanded document in document order; elements have no children. Empty after errors.
        known: defaults of the arguments that the files declare or use, by name; None for an argument without a default.
        findings: errors and notes.
        wanted: name of a package whose location the process needs to continue; None if it is done.
        used: paths of the files that were read.
        absent: packages that are missing, or left out on request.
        unknown_calls: calls of undefined macros, left out because an include of a package in `absent` was left out.
    """

    elements: list[tuple[int, Element]]
    known: dict[str, str | None]
    findings: list[Finding]
    wanted: str | None
    used: list[str]
    absent: list[AbsentPackage]
    unknown_calls: list[UnknownCall]


def is_xacro(path: Path, root: Element) -> bool:
    """Return whether a description must be expanded by xacro.

    It must if its file name ends in `.xacro`, or if it contains xacro elements or substitutions; for SDF, only the name counts.
    """

    def holds(element: Element) -> bool:
        return element.tag.startswith("xacro:") or any("$(" in v or "${" in v for v in element.attributes.values())

    if root.tag == "sdf":  # whose plugins may hold ${…} of their own
        return path.suffix == SUFFIX
    return path.suffix == SUFFIX or any(holds(element) for element in root.walk())


def expand(
    path: Path,
    arguments: Mapping[str, str],
    packages: Packages,
    findings: Findings,
    places: Mapping[str, Span] = MappingProxyType({}),
    text: str | None = None,
    without: Collection[str] = (),
) -> Element | None:
    """Return the root element to which a xacro file expands; None after an error.

    Args:
        path: path of the xacro file.
        arguments: values of its `xacro:arg` elements, by name.
        packages: resolve `$(find …)`, and decide which files may be read.
        findings: receives errors and notes.
        places: source locations of the arguments, by name, for errors about unknown arguments.
        text: content of the file; by default it is read from `path`.
        without: names of packages to leave out.
    """
    start = Span(Source(str(path), ()), 1, 1)
    warn(findings)
    before = len(findings.errors)
    try:
        answer = _ask(path, arguments, packages, text, without)
        report(answer.absent, answer.unknown_calls, without, findings, failed=not answer.elements)
        if any(package.includes and package.name not in without for package in answer.absent):
            return None  # further errors would only be consequences
        take_findings(answer.findings, findings)
        root = _joined(answer.elements) if answer.elements else None
        if root is None and len(findings.errors) == before:
            raise ProcessError("sends a malformed answer", b"")
    except ProcessError as error:
        findings.add("S103", f"xacro: the process that expands the file {error}", start)
        return None
    note_used(answer.used, packages.files)
    unknown = [name for name in arguments if name not in answer.known] if root is not None else []
    for name in unknown:
        near = did_you_mean(name, answer.known) or listing(answer.known, "its arguments")
        findings.add("G111", f"{str(path)!r} has no argument {name!r}", places.get(name), near)
    return None if unknown else root


def defaults(path: Path, packages: Packages, findings: Findings) -> dict[str, str | None]:
    """Return the defaults of the arguments of a xacro file and its includes, by name; None for an argument without a default.

    Errors in the file are ignored; only a failure of the process that expands it is added to `findings`.
    """
    try:
        return _ask(path, {}, packages, None, ()).known
    except ProcessError as error:
        findings.add("S103", f"xacro: the process that expands the file {error}", Span(Source(str(path), ()), 1, 1))
        return {}


def _ask(
    path: Path, arguments: Mapping[str, str], packages: Packages, text: str | None, without: Collection[str]
) -> Expanded:
    """Run the process that expands a file, and return its response.

    In a sourced ROS workspace, the process may read only packages that the files name. If it needs another package, it ends, and
    is run again with the location of this package.

    Raises:
        ProcessError: the process fails, or takes too long.
    """
    installed = packages.files.installed
    roots = [str(root) for root in packages.files.roots if root not in {folder.resolve() for folder in installed}]
    found: dict[str, str | list[str]] = {}
    named = _names(path, installed, text) if installed else []
    known = [Source(str(path), tuple(text.split("\n")))] if text is not None else []
    span = Sources(packages.files, *known).span
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
            "text": text,
            "without": sorted(without),
        }
        answer = read(ask(_PROCESS, encoded(request).encode(), left), Expanded, MAX_ANSWER, span)
        if answer.wanted is None:
            return answer
        named = [answer.wanted]
    raise ProcessError(f"takes more than {MAX_SECONDS:g} s", b"")


def _names(path: Path, installed: Sequence[Path], text: str | None) -> list[str]:
    """Return the installed packages that a file names in `$(find …)`, and the installed package that contains the file."""
    around = [folder.name for folder in path.absolute().parents if folder.parent in installed]
    if text is None:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES)
    else:
        content = text.encode()
    named = {name.decode() for name in _FIND.findall(content)}
    return [*around, *(name for share in installed if share.is_dir() for name in sorted(named & {*os.listdir(share)}))]


def _joined(parts: Sequence[tuple[int, Element]]) -> Element:
    """Build a tree from (depth, element) pairs in document order, and return its root.

    Raises:
        ProcessError: the elements do not form one tree, are too many or too deep, or cannot be written as XML.
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
