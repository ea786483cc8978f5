"""Formats of robot descriptions that installed packages add, by entry points of the group `graphengine.descriptions`.

The name of an entry point is the suffix of the files without the dot. Its object is a function that converts a file to URDF:

    def read(source: Source, findings: Findings) -> Element | None

`source` has the path and the lines of the file. The function returns the element `robot` of a URDF; its elements have the source
locations (`Span`) for messages. The function adds errors to `findings`.
"""

from __future__ import annotations

import functools
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from graphengine.descriptions.files.xml import Element, read, read_bytes
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.entry_points import by_name, first_line, load_only, package_of
from graphengine.format.errors import GraphError

GROUP = "graphengine.descriptions"
_BUILT_IN = (
    "",
    ".urdf",
    ".xacro",
    ".sdf",
    ".world",
    ".xml",
    ".mjcf",
    ".usd",
    ".usda",
    ".usdc",
    ".usdz",
    ".yaml",
    ".yml",
)
"""Suffixes that no package can add."""


def is_added(path: Path) -> bool:
    """Return whether an installed package reads files with this suffix."""
    return bool(_entries(path.suffix))


def read_root(path: Path, findings: Findings) -> Element | None:
    """Return the root element of a description, for an added format after conversion to URDF; None after an error."""
    entries = _entries(path.suffix)
    if not entries:
        found = read(path, findings, "S103")
        if found is None:
            tell_suffix(path, Span(Source(str(path), ()), 1, 1), findings)
        return found
    raw = read_bytes(path, findings, "S103")
    if raw is None:
        return None
    source, before = Source(str(path), tuple(raw.decode("utf-8", "replace").split("\n"))), len(findings.errors)
    package, problem, root = package_of(entries[0]), "", None
    try:
        root = load_only("description format", entries)(source, findings)
    except GraphError as error:
        problem = str(error)
    except Exception as error:  # a package may fail in any way
        problem = f"the reader of {package} failed: {first_line(error)}\nupdate {package}, or uninstall it"
    if not isinstance(root, Element) and not problem and len(findings.errors) == before:
        what = "nothing" if root is None else f"a value of the type {type(root).__name__}"
        problem = f"the reader of {package} returned {what} and no error\nupdate {package}, or uninstall it"
    if problem:
        message, *remedy = problem.split("\n")
        findings.add("S103", message, Span(source, 1, 1), *remedy)
    return root if isinstance(root, Element) and len(findings.errors) == before else None


def tell_suffix(path: Path, span: Span | None, findings: Findings) -> None:
    """Add an error that no installed package reads files with this suffix, unless the suffix is built in."""
    if path.suffix not in _BUILT_IN:
        text = f"no installed package reads descriptions that end with {path.suffix[:20]!r}"
        findings.add("S103", text, span, "install the package of this format, or convert the file to URDF")


@functools.cache
def _entries(suffix: str) -> list[EntryPoint]:
    return [] if suffix in _BUILT_IN else by_name(entry_points(group=GROUP)).get(suffix.removeprefix("."), [])
